"""Angles of leaves' planes against the true ones: kinds × angles × methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from app.core.arrays import Bools
from app.core.progress import QUIET, Progress
from app.core.units import to_mm
from app.services.bench.picture import Curve, Panel
from app.services.bench.planes.leaves import POINTS, SHAPES, Kind, Points, SeenLeaf, see_leaf
from app.services.bench.planes.methods import METHODS, Angle, measure_angle
from app.services.bench.results import ResultTable, Value

NAME = "leaf_planes"
TILTS = (0, 15, 30, 45, 60, 70, 75, 80, 85)
QUICK_TILTS = (0, 60)
SIGMAS = (0.0007, 0.0026)
"""Metres: of an LS880 with and without its filter, here both white."""
SEEDS, QUICK_SEEDS = 20, 1
FEWEST = 30
"""True points that a leaf must show to be judged."""
NOTE = (
    "Leaves of 6 to 9 cm, 2.5 m away, before a wall at 5 m, beams 0.018° apart and 4 mm wide. The "
    "true angle is that of the plane on which the leaf was built, its mean plane where it is "
    "curved (5 to 14 per metre) or wrinkled (0.8 to 2 mm), for the beam to the same point. Errors "
    "in degrees, estimated − true; bias: their mean. A refused leaf counts as 90° in median and "
    f"90 %. Leaves that show fewer than {FEWEST} true points are left out of all. Of mixed pixels, "
    "those whose main surface is the leaf are among the points. Nothing behind: the same leaf "
    "without the wall, all points. LSR or robust: what the program "
    "uses."
)


@dataclass(frozen=True, slots=True)
class Cell:
    """What all leaves of one cell of the table have in common."""

    kind: Kind
    points: Points
    sigma: float
    tilt: float


def measure_leaves(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """All kinds, angles, noises and methods.

    Raises
    ------
    Cancelled
    """
    tilts, seeds = (QUICK_TILTS, QUICK_SEEDS) if quick else (TILTS, SEEDS)
    found: dict[tuple[Cell, str], list[Angle]] = {}
    for place, kind in enumerate(SHAPES):
        for step, tilt in enumerate(tilts):
            progress.report((place + step / len(tilts)) / len(SHAPES), f"{kind} leaves, {tilt}°")
            for seed in range(seeds):
                leaf = see_leaf(kind, tilt, seed)
                if len(leaf.xyz) - leaf.ghost.sum() >= FEWEST:
                    _judge(leaf, kind, tilt, seed, found)
    rows = [_tell(cell, method, angles) for (cell, method), angles in found.items()]
    return ResultTable(NAME, "Angles of leaves' planes", rows, NOTE)


def _judge(
    leaf: SeenLeaf, kind: Kind, tilt: float, seed: int, found: dict[tuple[Cell, str], list[Angle]]
) -> None:
    for points, sigma, method in product(POINTS, SIGMAS, METHODS):
        own = found.setdefault((Cell(kind, points, sigma, tilt), method), [])
        own.append(measure_angle(method, leaf.draw(points, sigma, seed), leaf.normal))


def _tell(cell: Cell, method: str, angles: Sequence[Angle]) -> dict[str, Value]:
    errors = np.array([angle.error for angle in angles])
    sigmas = np.array([angle.sigma for angle in angles])
    known = errors[np.isfinite(errors)]
    size = np.abs(np.where(np.isfinite(errors), errors, 90.0))
    stated = np.isfinite(sigmas) & np.isfinite(errors)
    return {
        "leaves": cell.kind,
        "points": cell.points,
        "sigma_mm": to_mm(cell.sigma),
        "angle_deg": float(cell.tilt),
        "method": method,
        "count": len(angles),
        "median_deg": _round(float(np.median(size))),
        "p90_deg": _round(float(np.percentile(size, 90))),
        "bias_deg": _round(float(known.mean()) if len(known) else float("nan")),
        "undefined": len(errors) - len(known),
        "within 1 σ": _round(_share(np.asarray(np.abs(errors[stated]) <= sigmas[stated]))),
        "median σ, °": _round(float(np.median(sigmas[stated])) if stated.any() else float("nan")),
    }


def _share(of: Bools) -> float:
    return float(of.mean()) if len(of) else float("nan")


def _round(value: float) -> float:
    return float(f"{value:.4g}")


DRAWN = [method for method in METHODS if method != "LSR"]
"""Alone it fails as TLS does."""


def draw_leaves(table: ResultTable, sigma_mm: float = 0.7) -> list[Panel]:
    """Median error against the angle, a panel per kind of leaves, with mixed pixels."""
    rows = [
        row
        for row in table.rows
        if row["points"] == "with mixed pixels" and row["sigma_mm"] == sigma_mm
    ]
    panels = []
    for kind in SHAPES:
        curves = []
        for method in DRAWN:
            own = [row for row in rows if (row["leaves"], row["method"]) == (kind, method)]
            angle, error = (
                [float(row[name]) for row in own] for name in ("angle_deg", "median_deg")
            )
            curves.append(Curve(method, angle, error, dashed=method == "LSR or robust"))
        title = f"{kind} leaves, mixed pixels, {sigma_mm:g} mm"
        panels.append(Panel(title, "true angle, °", "median error, °", curves, y_scale="log"))
    return panels
