"""Curves through the table of a series: a fit for each leaf."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.services.fit import FitReport, Group, fit_groups
from app.services.leaves import Row

ANGLES = ("incidence_carried_deg", "incidence_plane_deg")
"""Columns that a model takes as its angle: of the plane as carried, or of the one found."""


def list_channels(rows: Sequence[Row]) -> list[str]:
    """Channels of which a table has means, in its order."""
    names = dict.fromkeys(name for row in rows for name in row)
    return [name.removesuffix("_n") for name in names if name.endswith("_n")]


def list_pairs(rows: Sequence[Row], x: str, y: str) -> dict[str, tuple[list[float], list[float]]]:
    """Pairs of two columns by the key of the leaf, in order of x; rows without both are out."""
    found: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        first, second = row.get(x), row.get(y)
        if isinstance(first, (int, float)) and isinstance(second, (int, float)):
            found.setdefault(str(row["leaf"]), []).append((float(first), float(second)))
    sorted_pairs = {leaf: sorted(pairs) for leaf, pairs in found.items()}
    return {leaf: ([a for a, _ in p], [b for _, b in p]) for leaf, p in sorted_pairs.items()}


def fit_series(
    rows: Sequence[Row],
    channel: str,
    model: str,
    angle: str = ANGLES[0],
    progress: Progress = QUIET,
) -> FitReport:
    """Fit a model to the means of each leaf over its angles.

    Parameters
    ----------
    rows : sequence of Row
        As `measure_series` gives them.
    channel, model : str
    angle : str
        One of `ANGLES`.

    Raises
    ------
    BadInput
        No row has both an angle and a mean.
    """
    names = {str(row["leaf"]): str(row["name"]) for row in rows}
    pairs = list_pairs(rows, angle, f"{channel}_mean")
    if not pairs:
        raise BadInput(f"No leaf of the series has an angle and a mean of {channel}.")
    groups: list[Group] = [
        ({"leaf": leaf, "name": names[leaf]}, np.array(x), np.array(y))
        for leaf, (x, y) in pairs.items()
    ]
    return fit_groups(groups, model, progress=progress)
