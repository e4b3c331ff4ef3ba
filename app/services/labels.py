"""Columns of a user's table beside columns of results: no name stands in a header twice."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

PREFIX = "group_"


def name_apart(labels: Sequence[str], taken: Iterable[str]) -> list[str]:
    """Names for columns of labels: those that results or others have get a prefix."""
    used, found = set(taken), []
    kept = set(labels)
    for label in labels:
        name = label
        while name in used or (name != label and name in kept):
            name = PREFIX + name
        used.add(name)
        found.append(name)
    return found


def put_labels_first(
    labels: Sequence[Mapping[str, str]], rows: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Rows of results behind the labels of each, named by `name_apart`."""
    names = list(dict.fromkeys(name for each in labels for name in each))
    apart = dict(zip(names, name_apart(names, {key for row in rows for key in row}), strict=True))
    return [
        {**{apart[name]: text for name, text in each.items()}, **row}
        for each, row in zip(labels, rows, strict=True)
    ]
