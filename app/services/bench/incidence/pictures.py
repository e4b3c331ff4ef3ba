"""The picture: run time against error, the Pareto front, every program that took part."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from app.core.units import to_mm
from app.services.bench.incidence.goals import Row, name_noise
from app.services.bench.incidence.rivals import OURS
from app.services.bench.incidence.scenes import GIVEN, USUAL
from app.services.bench.picture import Dots, Scatter, draw_scatters

ERRORS = {"median_deg": "median error, °", "p90_deg": "90 % error, °"}


def draw_fronts(rows: Sequence[Row], radius: float, path: Path) -> None:
    """Draw a row of panels for each scene: median and 90 % error against run time."""
    usual = [row for row in rows if _is_shown(row)]
    panels = [
        Scatter(
            _title(scene, points),
            "seconds (beside the dots: radius in mm)",
            name,
            tuple(_join_dots(points, error, radius)),
        )
        for scene, points in _by_scene(usual)
        for error, name in ERRORS.items()
    ]
    draw_scatters(panels, path, len(ERRORS))


def _is_shown(row: Row) -> bool:
    """Scenes of the other simulator, and ours with the usual noise; float64 points."""
    usual = np.isclose(float(row["sigma_mm"]), to_mm(USUAL.sigma)) and row["noise"] == USUAL.kind
    return bool(usual or row["noise"] == GIVEN.kind) and "float32" not in str(row["method"])


def _by_scene(rows: Sequence[Row]) -> Iterator[tuple[str, list[Row]]]:
    for scene, points in groupby(rows, lambda row: str(row["scene"])):
        yield scene, list(points)


def _title(scene: str, rows: Sequence[Row]) -> str:
    count = float(rows[0]["points"]) / 1e6
    name = scene.split(",")[0].replace("_", " ")
    return f"{name}: {count:.2g} million points, noise: {name_noise(rows[0])}"


def _join_dots(rows: Sequence[Row], error: str, radius: float) -> Iterator[Dots]:
    """One set of dots for each method, from small to large radii, in mm beside the dots."""
    names = dict.fromkeys(_name(row) for row in rows)
    for name in names:
        own = sorted((r for r in rows if _name(r) == name), key=lambda r: float(r["radius_mm"]))
        yield Dots(
            name,
            [float(row["seconds"]) for row in own],
            [float(row[error]) for row in own],
            [f"{row['radius_mm']:g}" for row in own],
            [bool(np.isclose(float(row["radius_mm"]), to_mm(radius))) for row in own],
            rival=own[0]["program"] != OURS,
        )


def _name(row: Row) -> str:
    method = re.split(r" \(|: ", str(row["method"]))[0]
    return f"{row['program']}: {method}"
