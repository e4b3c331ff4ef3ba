"""The picture: time of a fit against the excess of its sum of squares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from app.services.bench.fit.trade import LEAST, OURS
from app.services.bench.picture import Dots, Scatter, draw_scatters
from app.services.bench.results import Value

Row = Mapping[str, Value]


def draw_costs(rows: Sequence[Row], path: Path) -> None:
    """Draw a panel for each noise."""
    panels = [
        Scatter(
            f"{noise:g} % noise, 17 angles",
            "ms per fit",
            f"largest excess of rss / Σy² (0 at {LEAST:g})",
            tuple(_list_dots(list(some))),
        )
        for noise, some in groupby(rows, lambda row: row["noise_percent"])
    ]
    draw_scatters(panels, path, len(panels))


def _list_dots(rows: Sequence[Row]) -> Iterator[Dots]:
    for row in rows:
        name, error = str(row["way"]), max(float(row["largest_excess"]), LEAST)
        yield Dots(name, [float(row["ms_per_fit"])], [error], [""], [False], name not in OURS)
