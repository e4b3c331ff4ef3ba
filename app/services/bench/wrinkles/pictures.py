"""The picture: time of an angle against its error, by kind of leaf."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path

from app.services.bench.picture import Dots, Scatter, draw_scatters
from app.services.bench.results import Value
from app.services.bench.wrinkles.trade import OURS

Row = Mapping[str, Value]
LEAST = 1e-4


def draw_trade(rows: Sequence[Row], path: Path) -> None:
    """Draw a panel for each kind of leaf."""
    panels = []
    for kind, some in groupby(rows, lambda row: str(row["kind"])):
        dots = [
            Dots(str(row["way"]), [float(row["us_per_point"])],
                 [max(1.0 - float(row["right"]), LEAST)], [""], [False], row["way"] != OURS)
            for row in some
        ]  # fmt: skip
        panels.append(
            Scatter(f"{kind} leaves, 15° to 60°", "µs per point", "share not within 5°", dots)
        )
    draw_scatters(panels, path, len(panels))
