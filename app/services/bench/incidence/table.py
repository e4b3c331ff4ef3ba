"""The main table: every method at every radius, its time and its errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.core.units import to_mm
from app.services.bench.incidence.peers import OPEN3D, RADIUS_SEARCH
from app.services.bench.incidence.rivals import Rival
from app.services.bench.incidence.scenes import KIND_NAMES
from app.services.bench.results import ResultTable, Value

NAN = float("nan")
NOTE = (
    "Errors of true leaf points; a missing angle counts as 90°. seconds: neighbours, planes and "
    "angles, the middle of the turns, all methods taking turns; preparing_s is what a program "
    "takes to get the points, and is not in it. width_mm: median half-width or radius that was "
    "used. times_faster and ratios: Open3D's radius search at the same radius; to_best: the best "
    "that it reaches over all radii. CloudCompare: the time that it tells itself."
)


def tell_load(rivals: Sequence[Rival]) -> list[dict[str, Value]]:
    """Rows of all that ran on one load."""
    rows = [_tell(rival) for rival in rivals]
    reference = [r for r in rows if r["program"] == OPEN3D and r["method"] == RADIUS_SEARCH]
    by_radius = {row["radius_mm"]: row for row in reference}
    # One radius is no choice: its best would be itself.
    several = reference if len(reference) > 1 else []
    best = [min((float(r[name]) for r in several), default=NAN) for name in ERRORS]
    front = find_front([(float(row["seconds"]), float(row["median_deg"])) for row in rows])
    for row, on in zip(rows, front, strict=True):
        same = by_radius.get(row["radius_mm"])
        row["times_faster"] = _round(_divide(same, "seconds", row)) if same else NAN
        for name, ratio in ERRORS.items():
            row[ratio] = _round(1 / _divide(same, name, row)) if same and row[name] else NAN
        for (name, ratio), least in zip(ERRORS.items(), best, strict=True):
            row[f"{ratio}_to_best"] = _round(float(row[name]) / least)
        row["on_pareto"] = bool(on)
    return rows


ERRORS = {"median_deg": "median_ratio", "p90_deg": "p90_ratio"}


def _divide(reference: dict[str, Value], name: str, row: dict[str, Value]) -> float:
    value = float(row[name])
    return float(reference[name]) / value if value else NAN


def _round(value: float) -> float:
    return float(f"{value:.4g}")


def _tell(rival: Rival) -> dict[str, Value]:
    truth, noise = rival.load.truth, rival.load.noise
    errors = rival.errors()
    width = rival.width[rival.judged]
    known = width[np.isfinite(width) & (width > 0)]
    return {
        "scene": truth.name,
        "noise": noise.kind,
        "sigma_mm": _round(to_mm(noise.sigma)),
        "points": len(truth.xyz),
        "evaluated": len(errors),
        "method": rival.method,
        "program": rival.program,
        "radius_mm": _round(to_mm(rival.radius)),
        "width_mm": _round(to_mm(float(np.median(known)))) if len(known) else NAN,
        "turns": len(rival.seconds),
        "seconds": _round(rival.median_seconds),
        "spread": _round(rival.spread),
        "preparing_s": _round(float(np.median(rival.preparing))),
        "median_deg": _round(float(np.median(errors))),
        "p90_deg": _round(float(np.percentile(errors, 90))),
        "undefined": _round(rival.undefined()),
    }


def find_front(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Which (cost, error) no other point beats in one and at least equals in the other."""
    return [not any((a <= x and b < y) or (a < x and b <= y) for a, b in points) for x, y in points]


def tabulate(rows: list[dict[str, Value]]) -> ResultTable:
    """The rows as a table."""
    return ResultTable("incidence", "Angles of incidence: time and error", rows, NOTE)


def tell_kinds(rivals: Sequence[Rival]) -> list[dict[str, Value]]:
    """Errors on flat, bent and wrinkled leaves."""
    rows: list[dict[str, Value]] = []
    for rival in rivals:
        errors = rival.errors()
        kinds = rival.load.truth.kind[rival.judged]
        for kind, name in KIND_NAMES.items():
            own = errors[kinds == kind]
            if len(own):
                rows.append({
                    "scene": rival.load.truth.name,
                    "noise": rival.load.noise.kind,
                    "sigma_mm": _round(to_mm(rival.load.noise.sigma)),
                    "leaves": name,
                    "method": rival.method,
                    "program": rival.program,
                    "radius_mm": _round(to_mm(rival.radius)),
                    "points": len(own),
                    "median_deg": _round(float(np.median(own))),
                    "p90_deg": _round(float(np.percentile(own, 90))),
                })  # fmt: skip
    return rows
