"""Time against error: our angles and what else one might do with the same points."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import LeafscopeError
from app.core.fitting import fit
from app.core.incidence import Estimator, incidence_angle, local_planes
from app.core.planes import leaf_plane
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees, to_radians
from app.core.wrinkling.claim import Calibration
from app.core.wrinkling.curve import curve_of_fit
from app.core.wrinkling.leaf import Choices, judge_leaf
from app.services.bench.results import ResultTable, Value
from app.services.bench.wrinkles.cases import BAND, RIGHT, TABLE_DEG, measure_table
from app.services.bench.wrinkles.scenes import KINDS, TrueLeaf

Found = tuple[Floats, Bools]
Way = Callable[[TrueLeaf], Found]
OURS = "ours: means, then the curve"
LIMIT = np.pi / 3
REPEATS = 3


def _invert(leaf: TrueLeaf, means: bool) -> Found:
    curve = measure_table(leaf, np.random.default_rng(len(leaf.omega)))
    choices = Choices(means=means, index=False)
    try:
        found = judge_leaf(leaf.points, Calibration("known", curve), choices)
    except LeafscopeError:
        return _nothing(leaf)
    return found.angles.omega, found.angles.valid


def _invert_polynomial(leaf: TrueLeaf) -> Found:
    """Balduzzi's way: a polynomial of fourth degree up to 60°, single points."""
    angle = to_radians(TABLE_DEG)
    angle = angle[angle <= LIMIT]
    noise = 0.01 * np.random.default_rng(len(leaf.omega)).standard_normal(len(angle))
    value = leaf.respond(angle)
    value = (
        value * (1 + noise) if leaf.per_decade is None else value + noise * leaf.per_decade / 2.3
    )
    curve = curve_of_fit(fit("polynomial-4", angle, value), leaf.scale)
    try:
        omega = curve.invert(leaf.points.intensity)
    except LeafscopeError:
        return _nothing(leaf)
    return omega, np.isfinite(omega)


def _see_locally(estimator: Estimator) -> Way:
    def measure(leaf: TrueLeaf) -> Found:
        points = leaf.points
        planes = local_planes(
            points.xyz, points.scanner, None, 0.004, points.cells, estimator=estimator
        )
        omega = incidence_angle(points.xyz, planes.normals, points.scanner)
        with np.errstate(invalid="ignore"):
            return omega, omega <= LIMIT

    return measure


def _see_plane(leaf: TrueLeaf) -> Found:
    try:
        omega = leaf_plane(leaf.points.xyz, leaf.points.scanner).incidence
    except LeafscopeError:
        return _nothing(leaf)
    return np.full(len(leaf.omega), omega), np.full(len(leaf.omega), omega <= LIMIT)


def _nothing(leaf: TrueLeaf) -> Found:
    return np.full(len(leaf.omega), np.nan), np.zeros(len(leaf.omega), bool)


WAYS: Mapping[str, Way] = {
    OURS: lambda leaf: _invert(leaf, means=True),
    "single points, then the curve": lambda leaf: _invert(leaf, means=False),
    "polynomial of 4th degree, single points": _invert_polynomial,
    "local planes, adaptive": _see_locally("adaptive"),
    "local planes, balls of 4 mm": _see_locally("ball"),
    "plane of the leaf": _see_plane,
}


def measure_trade(
    leaves: Sequence[TrueLeaf], repeats: int = REPEATS, progress: Progress = QUIET
) -> ResultTable:
    """Rows: kind × way, over the full hits of one scene."""
    rows: list[dict[str, Value]] = []
    for place, kind in enumerate(KINDS):
        some = [leaf for leaf in leaves if leaf.kind == kind]
        found: dict[str, list[Found]] = {}
        taken: dict[str, list[float]] = {name: [] for name in WAYS}
        for turn in range(repeats):  # in turns, so that a busy moment hits all
            progress.report((place + turn / repeats) / len(KINDS), f"{kind} leaves")
            for name, way in WAYS.items():
                start = time.perf_counter()
                found[name] = [way(leaf) for leaf in some]
                taken[name].append(time.perf_counter() - start)
        count = sum(len(leaf.omega) for leaf in some)
        for name in WAYS if some else ():
            seconds = float(np.median(taken[name]))
            rows.append(_tell(kind, name, some, found[name], 1e6 * seconds / max(count, 1)))
    return ResultTable(
        "wrinkles_trade", "Time against error of ways to an angle, case (a)", rows,
        "Full hits whose true angle is 15° to 60°. right: |error| ≤ 5°, of all of them: one that "
        "is not valid is not right. Geometric ways need no curve, and see no wrinkle smaller than "
        "their window.",
    )  # fmt: skip


def _tell(
    kind: str, name: str, some: Sequence[TrueLeaf], found: Sequence[Found], cost: float
) -> dict[str, Value]:
    parts = []
    for leaf, (omega, valid) in zip(some, found, strict=True):
        chosen = leaf.full & (leaf.omega >= BAND[0]) & (leaf.omega <= BAND[1])
        away = np.where(valid[chosen], np.abs(omega[chosen] - leaf.omega[chosen]), np.inf)
        parts.append(np.where(np.isnan(away), np.inf, away))
    error = np.concatenate(parts)
    known = error[np.isfinite(error)]
    rms = float(to_degrees(np.sqrt(np.mean(known**2)))) if len(known) else float("nan")
    return {
        "kind": kind,
        "way": name,
        "points": len(error),
        "us_per_point": float(f"{cost:.3g}"),
        "valid": round(float(np.isfinite(error).mean()), 4),
        "right": round(float((error <= RIGHT).mean()), 4),
        "rms_deg": float(f"{rms:.4g}"),
    }
