"""What must not change a reflectance, and what must leave a mark instead of one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.radiometry.marks import BEYOND_RANGE, GOOD, NO_SIGNAL, SATURATED
from app.model.scan import Scan
from app.services.bench.results import ResultTable, Value
from app.services.bench.stability.changes import DIRECTION, draw_turn
from app.services.bench.stability.signals import (
    CALIBRATIONS,
    CHANNEL,
    FARTHEST,
    HERE,
    Calibrated,
    Seen,
    change,
    judge_marks,
    tell_difference,
)

NAME = "stability_reflectance"
COUNT, QUICK_COUNT = 20_000, 500
EXACT = 1e-9
"""The σ of a spline comes from differences of splines, and is rounded by 1e-10 of itself."""
ALONE = 1e-15
"""One point and many are summed in different orders."""
ROUNDING = 1e-15
"""Relative change of a reflectance at 2 m, per metre by which the coordinates are far away."""
HUGE = (-3.4e38, -1e9, -1.0, 0.0, 1.0, 1e9, 3.4e38)
"""Up to what a float32 can hold, which some programs write for a missing value."""
ODD_RANGES = (0.0, 1e-300, 1e-3, 8.0, 1e9, 1e150)
NOTE = (
    "Largest relative deviation of a reflectance or its σ from the scan unchanged. inf: a mark "
    "differs, a value is missing or one too many, is infinite, or numpy warned. All by the "
    "program's fields: scan, profile, range, reflectance, σ and mark."
)


@dataclass(frozen=True, slots=True)
class Case:
    """A change, and how far it may move a reflectance.

    Attributes
    ----------
    group, name : str
    limit : float
        Relative.
    run : callable
        (calibration, scan) → deviation
    """

    group: str
    name: str
    limit: float
    run: Callable[[Calibrated, Scan], float]


def list_cases() -> list[Case]:
    """All of them."""
    moved = [
        Case(
            "moved",
            f"{offset:.0e} m away",
            max(EXACT, ROUNDING * offset),
            partial(shift, offset=offset),
        )
        for offset in (1e3, 1e5, 1e6, 1e7)
    ]
    types = ("uint8", "uint16", "int16", "int32", "int64", "float32")
    kinds = [Case("number type", name, 0.0, partial(retype, name=name)) for name in types]
    return [
        *moved,
        Case("moved", "UTM: 500 km east, 5400 km north", 5.4e6 * ROUNDING, shift_to_utm),
        Case("turned", "scan and scanner", EXACT, turn),
        Case("scaled", "millimetres in the file", EXACT, read_millimetres),
        Case("shuffled", "points in another order", ALONE, shuffle),
        Case("doubled", "each point twice", ALONE, double),
        Case("asked for", "every third point", ALONE, ask_some),
        Case("asked for", "one point twice, backwards", ALONE, ask_twice),
        Case("asked for", "none", 0.0, ask_none),
        *kinds,
        Case("spoilt", "points not finite", ALONE, spoil_points),
        Case("spoilt", "numbers not finite", ALONE, spoil_numbers),
        Case("odd", "no points", 0.0, see_nothing),
        Case("odd", "one point", ALONE, see_one),
        Case("odd", "all numbers the same", ALONE, level),
        Case("odd", "all saturated", 0.0, saturate),
        Case("odd", "all at the scanner", 0.0, collapse),
        Case("extreme", "numbers up to ±3.4e38", 0.0, exaggerate),
        Case("extreme", "ranges from 0 to 1e150 m", 0.0, scatter),
    ]  # fmt: skip


def check_reflectances(quick: bool = False) -> ResultTable:
    """All cases with all calibrations."""
    count = QUICK_COUNT if quick else COUNT
    rows = [tell_case(case, count) for case in list_cases()]
    return ResultTable(NAME, "What must not change a reflectance", rows, NOTE)


def tell_case(case: Case, count: int) -> dict[str, Value]:
    """One row: the deviation of each calibration, and whether all are within the limit."""
    found = {each.name: _try(case, each, count) for each in CALIBRATIONS}
    failed = [name for name, deviation in found.items() if not deviation <= case.limit]
    return {
        "group": case.group,
        "case": case.name,
        "limit": case.limit,
        **{name: float(f"{deviation:.3g}") for name, deviation in found.items()},
        "verdict": "FAILS: " + ", ".join(failed) if failed else "holds",
    }


def _try(case: Case, way: Calibrated, count: int) -> float:
    try:
        return case.run(way, way.make_scan(count))
    except RuntimeWarning:
        return np.inf


def shift(way: Calibrated, scan: Scan, offset: float) -> float:
    """Far coordinates."""
    move = np.round(DIRECTION * offset)
    far = way.put(scan.attributes[CHANNEL], scan.xyz + move, _place(np.array(HERE) + move))
    return tell_difference(way.see(far), way.see(scan))


def shift_to_utm(way: Calibrated, scan: Scan) -> float:
    """Coordinates of a map."""
    move = np.array([500_000.0, 5_400_000.0, 300.0])
    far = way.put(scan.attributes[CHANNEL], scan.xyz + move, _place(np.array(HERE) + move))
    return tell_difference(way.see(far), way.see(scan))


def turn(way: Calibrated, scan: Scan) -> float:
    """A random rotation about the origin."""
    rotation = draw_turn(1).T
    other = way.put(
        scan.attributes[CHANNEL], scan.xyz @ rotation, _place(np.array(HERE) @ rotation)
    )
    return tell_difference(way.see(other), way.see(scan))


def read_millimetres(way: Calibrated, scan: Scan) -> float:
    """Points that were millimetres and came back to metres, as reading does."""
    place = _place(0.001 * (1000.0 * np.array(HERE)))
    other = way.put(scan.attributes[CHANNEL], 0.001 * (1000.0 * scan.xyz), place)
    return tell_difference(way.see(other), way.see(scan))


def _place(position: Floats) -> tuple[float, float, float]:
    x, y, z = map(float, position)
    return x, y, z


def shuffle(way: Calibrated, scan: Scan) -> float:
    """Another order."""
    order = np.random.default_rng(1).permutation(len(scan))
    other = change(scan, scan.attributes[CHANNEL][order], scan.xyz[order])
    return tell_difference(way.see(other), _pick(way.see(scan), order))


def _pick(seen: Seen, rows: AnyArray) -> Seen:
    return Seen(seen.values[rows], seen.sigma[rows], seen.marks[rows])


def double(way: Calibrated, scan: Scan) -> float:
    """Each point twice."""
    rows = np.repeat(np.arange(len(scan)), 2)
    other = change(scan, scan.attributes[CHANNEL][rows], scan.xyz[rows])
    return tell_difference(way.see(other), _pick(way.see(scan), rows))


def ask_some(way: Calibrated, scan: Scan) -> float:
    """Some points alone."""
    rows = np.arange(0, len(scan), 3)
    return tell_difference(way.see(scan, rows), _pick(way.see(scan), rows))


def ask_twice(way: Calibrated, scan: Scan) -> float:
    """Points more than once, and not in order."""
    rows = np.array([7, 7, 3, 0])
    return tell_difference(way.see(scan, rows), _pick(way.see(scan), rows))


def ask_none(way: Calibrated, scan: Scan) -> float:
    """An empty selection."""
    rows = np.empty(0, np.int64)
    return tell_difference(way.see(scan, rows), _pick(way.see(scan), rows))


def retype(way: Calibrated, scan: Scan, name: str) -> float:
    """Whole numbers in another type, those that it can hold."""
    dn = scan.attributes[CHANNEL]
    if name != "float32":
        limits = np.iinfo(name)
        dn = np.clip(dn, limits.min, limits.max)
    other = change(scan, dn.astype(name))
    return tell_difference(way.see(other), way.see(change(scan, dn)))


def spoil_points(way: Calibrated, scan: Scan) -> float:
    """Coordinates that are no numbers: marked where the range counts; the others as before."""
    bad = np.arange(len(scan)) % 5 == 0
    xyz = scan.xyz.copy()
    xyz[bad, 1] = np.resize([np.nan, np.inf, -np.inf], int(bad.sum()))
    found, whole = way.see(change(scan, xyz=xyz)), way.see(scan)
    if (found.marks[bad] == GOOD).any():
        return np.inf
    return tell_difference(_pick(found, ~bad), _pick(whole, ~bad))


def spoil_numbers(way: Calibrated, scan: Scan) -> float:
    """Numbers that are none."""
    bad = np.arange(len(scan)) % 5 == 0
    dn = scan.attributes[CHANNEL].copy()
    dn[bad] = np.resize([np.nan, np.inf, -np.inf], int(bad.sum()))
    found, whole = way.see(change(scan, dn)), way.see(scan)
    if (found.marks[bad] != NO_SIGNAL).any():
        return np.inf
    return max(judge_marks(found), tell_difference(_pick(found, ~bad), _pick(whole, ~bad)))


def see_nothing(way: Calibrated, scan: Scan) -> float:
    """A scan without points."""
    found = way.see(change(scan, np.empty(0), np.empty((0, 3))))
    return 0.0 if len(found.values) == 0 else np.inf


def see_one(way: Calibrated, scan: Scan) -> float:
    """One point of the scan alone."""
    rows = np.array([5])
    one = change(scan, scan.attributes[CHANNEL][rows], scan.xyz[rows])
    return tell_difference(way.see(one), _pick(way.see(scan), rows))


def level(way: Calibrated, scan: Scan) -> float:
    """The same number everywhere: each point what it is alone."""
    dn = np.full(len(scan), scan.attributes[CHANNEL][5])
    whole, one = way.see(change(scan, dn)), way.see(change(scan, dn[:1], scan.xyz[:1]))
    return max(judge_marks(whole), tell_difference(_pick(whole, np.array([0])), one))


def saturate(way: Calibrated, scan: Scan) -> float:
    """Numbers at the end of the scale, where the calibration knows one."""
    top = way.calibration.saturated
    found = way.see(change(scan, np.full(len(scan), 5000.0 if top is None else top)))
    if top is not None and (found.marks != SATURATED).any():
        return np.inf
    return judge_marks(found)


def collapse(way: Calibrated, scan: Scan) -> float:
    """Points in the scanner itself are outside the calibrated ranges."""
    found = way.see(change(scan, xyz=np.broadcast_to(HERE, scan.xyz.shape).copy()))
    known = way.calibration.saturated or np.inf
    expected = np.where(scan.attributes[CHANNEL] >= known, SATURATED, BEYOND_RANGE)
    return max(judge_marks(found), 0.0 if (found.marks == expected).all() else np.inf)


def exaggerate(way: Calibrated, scan: Scan) -> float:
    """Numbers that no instrument gives."""
    return judge_marks(way.see(change(scan, np.resize(HUGE, len(scan)).astype(float))))


def scatter(way: Calibrated, scan: Scan) -> float:
    """Ranges that no instrument measures: marked, all but those in between."""
    away = np.resize(ODD_RANGES, len(scan))
    xyz = np.array(HERE) + away[:, None] * np.array([0.0, 0.6, 0.8])
    found = way.see(change(scan, xyz=xyz))
    outside = (away < 1.0) | (away > FARTHEST)
    return np.inf if (found.marks[outside] == GOOD).any() else judge_marks(found)
