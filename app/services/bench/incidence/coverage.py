"""How often the true angle lies within one σ of the estimate, where σ is our own."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.incidence import RADIUS, incidence_angle, local_planes
from app.core.units import to_degrees, to_mm
from app.services.bench.incidence.scenes import KIND_NAMES, Noise, Truth
from app.services.bench.incidence.windows import lie_undisturbed
from app.services.bench.results import ResultTable, Value

POLE = 3.0
"""σ from ω = 0 within which the error is not normal: an angle has no sign."""
GOAL, TOLERANCE = 0.68, 0.05
NOTE = (
    "Share of judged points with |ω − true ω| ≤ σ. Near the pole: true ω ≤ 3 σ, where an angle "
    "without sign is not normal. Undisturbed: the window holds points of the same leaf only. "
    "A normal error gives 0.683. σ knows of white noise only."
)


def measure_coverage(
    truth: Truth, noises: tuple[Noise, ...], radius: float = RADIUS
) -> list[dict[str, Value]]:
    """Rows of one scene: kinds of leaves × noise × which points."""
    rows: list[dict[str, Value]] = []
    for noise in noises:
        xyz = truth.add_noise(noise)
        planes = local_planes(xyz, truth.scanner, radius=radius, grid=truth.grid)
        omega = to_degrees(incidence_angle(xyz, planes.normals, truth.scanner))
        sigma = to_degrees(np.asarray(planes.sigma, np.float64))
        quiet = lie_undisturbed(truth, planes.width)
        for kind in KIND_NAMES:
            rows += _tell_kind(truth, noise, kind, omega, sigma, quiet)
    return rows


def _tell_kind(
    truth: Truth, noise: Noise, kind: int, omega: Floats, sigma: Floats, quiet: Bools
) -> list[dict[str, Value]]:
    away = truth.omega > POLE * sigma
    known = np.isfinite(sigma) & np.isfinite(omega)
    chosen = truth.judged & (truth.kind == kind)
    groups = {
        ("away from the pole", "all"): away,
        ("away from the pole", "undisturbed"): away & quiet,
        ("near the pole", "all"): ~away,
        ("near the pole", "undisturbed"): ~away & quiet,
    }
    rows: list[dict[str, Value]] = []
    for (where, points), group in groups.items():
        taken = chosen & known & group
        if not taken.any():
            continue
        off = np.abs(omega[taken] - truth.omega[taken]) / sigma[taken]
        rows.append({
            "scene": truth.name, "noise": noise.kind, "sigma_mm": round(to_mm(noise.sigma), 3),
            "leaves": KIND_NAMES[kind], "where": where, "points": points,
            "count": int(taken.sum()),
            "within 1 σ": round(float((off <= 1).mean()), 4),
            "within 2 σ": round(float((off <= 2).mean()), 4),
            "median σ, °": round(float(np.median(sigma[taken])), 4),
            "without σ": round(1.0 - float(known[chosen].mean()), 5),
        })  # fmt: skip
    return rows


def tabulate_coverage(rows: list[dict[str, Value]]) -> ResultTable:
    """The rows as a table."""
    return ResultTable("incidence_coverage", "How often the true angle is within σ", rows, NOTE)
