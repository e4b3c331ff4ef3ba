"""Columns of labels beside columns of results."""

from __future__ import annotations

import pytest

from app.services.labels import name_apart, put_labels_first


@pytest.mark.parametrize(
    ("labels", "taken", "names"),
    [
        (["leaf", "nm"], ["model"], ["leaf", "nm"]),
        (["model", "leaf"], ["model", "rss"], ["group_model", "leaf"]),
        (["model"], ["model", "group_model"], ["group_group_model"]),
        (["model", "group_model"], ["model"], ["group_group_model", "group_model"]),
        (["a", "a"], [], ["a", "group_a"]),
    ],
)
def test_no_name_stands_twice(labels: list[str], taken: list[str], names: list[str]) -> None:
    assert name_apart(labels, taken) == names


def test_results_never_overwrite_labels() -> None:
    rows = put_labels_first([{"n": "oak"}, {"n": "elm"}], [{"mean": 0.5}, {"mean": 0.6, "n": 9}])
    assert rows == [{"group_n": "oak", "mean": 0.5}, {"group_n": "elm", "mean": 0.6, "n": 9}]
    assert list(rows[1]) == ["group_n", "mean", "n"]
