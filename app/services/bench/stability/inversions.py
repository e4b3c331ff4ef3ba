"""Angles from intensity, offsets and the wrinkle index at the ends of what they are made for."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from app.core.arrays import Floats
from app.core.errors import LeafscopeError
from app.core.intensity_angle import Doubt
from app.core.phase import get_model
from app.core.units import to_radians
from app.core.wrinkling.curve import KnownCurve, curve_of_model
from app.core.wrinkling.index import find_index
from app.core.wrinkling.level import level_leaf
from app.core.wrinkling.offset import Offset
from app.core.wrinkling.validity import PointAngles, invert_points
from app.services.bench.results import ResultTable, Value

NAME = "stability_inversion"
EXACT = 1e-7
"""Radians, where the curve is not level."""
LEVEL = 2e-6
"""Radians: at ω = 0 curves are level, and rounding of the intensity is a root of it."""
LOOSE = 1e-5
HUGE = (1e-12, 1e12)
NOTE = (
    "right: the deviation is within the limit; refused: a sentence says why. Deviations in "
    "radians; 0 where marks are all there is to compare."
)
Run = Callable[[KnownCurve], float]


@dataclass(frozen=True, slots=True)
class Case:
    """Something with a known answer (a deviation), or that must be refused."""

    group: str
    name: str
    limit: float
    run: Run
    refused: bool = False


def make_curve(name: str, values: Mapping[str, float], per_decade: float | None) -> KnownCurve:
    """A curve of a model."""
    return curve_of_model(get_model(name), values, per_decade=per_decade)


LB = {"f": 0.4, "k_d": 0.8, "m": 0.3}
CURVES: Mapping[str, KnownCurve] = {
    "lambert": make_curve("lambert", {"f": 0.4}, None),
    "lambert_beckmann": make_curve("lambert-beckmann", LB, None),
    "in_dn": make_curve("lambert-beckmann", LB, 600.0),
    "incidence_b": make_curve("incidence-b", {"a": 0.4, "b": 0.8}, None),
}
ANGLES = to_radians(np.linspace(0.5, 85.0, 340))


def list_cases() -> list[Case]:
    """All of them."""
    return [
        Case("limits", "there and back, 0.5° to 85°", EXACT, go_and_return),
        Case("limits", "the brightest and the darkest value of the curve", LEVEL, see_ends),
        Case("limits", "just beyond both ends: marked, no angle", 0.0, see_beyond),
        Case("limits", "noise 0 and infinite", 0.0, see_noise),
        *(Case("scaled", f"curve and values × {factor:g}", EXACT, partial(scale, factor=factor))
          for factor in HUGE),
        *(Case("scaled", f"an offset of × {factor:g}", LOOSE, partial(offset, factor=factor))
          for factor in HUGE),
        Case("spoilt", "NaN and infinite values: marked, no angle", 0.0, spoil),
        Case("spoilt", "zero and negative values: marked, no angle", 0.0, darken),
        Case("spoilt", "negative noise", 0.0, give_negative_noise, refused=True),
        Case("odd", "no points", 0.0, see_nothing),
        Case("odd", "one point", EXACT, see_one),
        Case("odd", "all values the same", EXACT, tie),
        Case("curves", "flat", 0.0, see_flat, refused=True),
        Case("curves", "rises, then falls: the part with two angles is marked", 0.0, see_hump),
        *(Case("offset", f"found again at × {factor:g}", LOOSE, partial(find_offset, factor=factor))
          for factor in (1.0, *HUGE)),
        Case("offset", "all values the same", LOOSE, find_offset_of_ties),
        Case("offset", "a plane beyond 60°", 0.0, find_offset_of_steep, refused=True),
        Case("offset", "no plane", 0.0, find_offset_of_nothing, refused=True),
        Case("offset", "one point", 0.0, find_offset_of_one, refused=True),
        *(Case("index", f"places × {factor:g}", EXACT, partial(scale_index, factor=factor))
          for factor in HUGE),
        Case("index", "a flat leaf", EXACT, index_flat),
        Case("index", "NaN among the angles", EXACT, index_spoilt),
        Case("index", "no points", 0.0, index_nothing, refused=True),
        Case("index", "one point", 0.0, index_one, refused=True),
        Case("index", "all points at one place", 0.0, index_ties, refused=True),
    ]  # fmt: skip


def check_inversions() -> ResultTable:
    """All cases with all curves."""
    rows = [tell_case(case) for case in list_cases()]
    return ResultTable(NAME, "Angles from intensity at the ends of their domain", rows, NOTE)


def tell_case(case: Case) -> dict[str, Value]:
    """One row: the deviation with each curve, or that it was refused, and the verdict."""
    answers = {name: _answer(case, curve) for name, curve in CURVES.items()}
    wrong = [name for name, (right, _) in answers.items() if not right]
    return {
        "group": case.group,
        "case": case.name,
        "limit": case.limit,
        **{name: text for name, (_, text) in answers.items()},
        "verdict": "FAILS: " + ", ".join(wrong) if wrong else "holds",
    }


def _answer(case: Case, curve: KnownCurve) -> tuple[bool, str]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            away = case.run(curve)
    except LeafscopeError as error:
        return case.refused and bool(str(error)), "refused"
    except RuntimeWarning:
        return False, "a warning"
    return not case.refused and bool(away <= case.limit), f"{away:.3g}"


def _see(curve: KnownCurve, values: Floats, offset: Offset | None = None) -> PointAngles:
    return invert_points(values, 0.0, curve, offset)


def _away(found: Floats, angle: Floats) -> float:
    away = np.abs(found - angle)
    return float(np.where(np.isnan(away), np.inf, away).max(initial=0.0))


def _count_wrong(found: PointAngles, doubt: Doubt) -> float:
    """How many points have an angle, or lack the mark."""
    marked = (found.doubt & int(doubt)) != 0
    return float((~marked | np.isfinite(found.omega)).sum())


def go_and_return(curve: KnownCurve) -> float:
    """Angles at which the curve is not level."""
    return _away(_see(curve, curve.evaluate(ANGLES)).omega, ANGLES)


def see_ends(curve: KnownCurve) -> float:
    """Both ends have an angle."""
    ends = np.array(curve.monotone)
    return _away(_see(curve, curve.evaluate(ends)).omega, ends)


def see_beyond(curve: KnownCurve) -> float:
    """A millionth of the curve's height beyond."""
    low, high = curve.span
    step = 1e-6 * (high - low)
    return _count_wrong(_see(curve, np.array([low - step, high + step])), Doubt.OUTSIDE)


def see_noise(curve: KnownCurve) -> float:
    """Without noise there is no error; with infinite noise no valid angle."""
    values = curve.evaluate(ANGLES)
    sure, lost = invert_points(values, 0.0, curve), invert_points(values, np.inf, curve)
    return float((sure.sigma != 0.0).sum() + lost.valid.sum())


def scale(curve: KnownCurve, factor: float) -> float:
    """Another unit of intensity; a logarithmic scale is shifted instead."""
    values = curve.evaluate(ANGLES)
    if curve.scale == "log":
        return offset(curve, factor)
    other = KnownCurve(
        lambda angle: factor * curve.evaluate(angle), lambda angle: factor * curve.slope(angle),
        curve.within, curve.scale,
    )  # fmt: skip
    return _away(_see(other, factor * values).omega, ANGLES)


def offset(curve: KnownCurve, factor: float) -> float:
    """An offset that is taken off again; on a logarithmic scale the shift of that factor."""
    values = curve.evaluate(ANGLES)
    found = make_offset(curve, factor)
    return _away(_see(curve, found.apply(values), offset=found).omega, ANGLES)


def make_offset(curve: KnownCurve, factor: float) -> Offset:
    """A factor, or its shift."""
    if curve.scale == "log":
        return Offset("added", float((curve.per_decade or 1.0) * np.log10(factor)))
    return Offset("factor", factor)


def spoil(curve: KnownCurve) -> float:
    """Not a number, and no end."""
    return _count_wrong(_see(curve, np.array([np.nan, np.inf, -np.inf])), Doubt.MISSING)


def darken(curve: KnownCurve) -> float:
    """Below the curve; on a logarithmic scale far below."""
    values = (
        np.array([-1e-9, -1.0, -1e300]) if curve.scale == "linear" else np.array([-1e5, -1e300])
    )
    return _count_wrong(_see(curve, values), Doubt.OUTSIDE)


def give_negative_noise(curve: KnownCurve) -> float:
    """There is none."""
    return float(len(invert_points(curve.evaluate(ANGLES), -1.0, curve).omega))


def see_nothing(curve: KnownCurve) -> float:
    """Empty in, empty out."""
    return float(len(_see(curve, np.empty(0)).omega))


def see_one(curve: KnownCurve) -> float:
    """One angle."""
    return _away(_see(curve, curve.evaluate(ANGLES[100:101])).omega, ANGLES[100:101])


def tie(curve: KnownCurve) -> float:
    """A thousand equal values."""
    angle = np.full(1000, ANGLES[100])
    return _away(_see(curve, curve.evaluate(angle)).omega, angle)


def see_flat(curve: KnownCurve) -> float:
    """A curve without a slope."""
    flat = KnownCurve(np.ones_like, np.zeros_like, curve.within, curve.scale)
    return float(len(_see(flat, np.ones(3)).omega))


def see_hump(curve: KnownCurve) -> float:
    """A curve turned about 30°: what it has on both sides of the turn is marked."""
    turn = float(to_radians(30.0))
    hump = KnownCurve(
        lambda angle: -((angle - turn) ** 2), lambda angle: -2.0 * (angle - turn), (0.0, 1.4),
        curve.scale,
    )  # fmt: skip
    angle = to_radians(np.array([35.0, 45.0, 59.0, 65.0, 75.0]))
    marked = (_see(hump, hump.evaluate(angle)).doubt & int(Doubt.AMBIGUOUS)) != 0
    return float((marked != [True, True, True, False, False]).sum())


TILTS = to_radians(np.linspace(30.0, 50.0, 201))


def find_offset(curve: KnownCurve, factor: float) -> float:
    """A known offset, as an error of the angle at the middle of the leaf."""
    given = make_offset(curve, factor)
    found = level_leaf(given.apply(curve.evaluate(TILTS)), curve, float(TILTS.mean()))
    return _away(curve.invert(found.remove(given.apply(curve.evaluate(TILTS)))), TILTS)


def find_offset_of_ties(curve: KnownCurve) -> float:
    """A leaf of one value lies on its plane."""
    values = curve.evaluate(np.full(50, TILTS[100]))
    found = level_leaf(values, curve, float(TILTS[0]))
    return _away(curve.invert(found.remove(values)), np.full(50, TILTS[0]))


def find_offset_of_steep(curve: KnownCurve) -> float:
    """Beyond the limit."""
    return level_leaf(curve.evaluate(TILTS), curve, float(to_radians(70.0))).value


def find_offset_of_nothing(curve: KnownCurve) -> float:
    """No angle of a plane."""
    return level_leaf(curve.evaluate(TILTS), curve, float("nan")).value


def find_offset_of_one(curve: KnownCurve) -> float:
    """Too few."""
    return level_leaf(curve.evaluate(TILTS[:1]), curve, float(TILTS[0])).value


def _make_waves() -> tuple[Floats, Floats, Floats]:
    """Angles of a leaf with waves of 5°, no noise, and its places."""
    u, v = (
        side.ravel() for side in np.meshgrid(np.linspace(0, 0.06, 60), np.linspace(0, 0.04, 40))
    )
    omega = to_radians(40.0 + 5.0 * np.sin(2 * np.pi * u / 0.012))
    return omega, np.zeros(len(u)), np.stack([u, v], axis=1)


FOOTPRINT = 0.00411
"""Metres; no point lies on the border of two blocks."""


def scale_index(_: KnownCurve, factor: float) -> float:
    """Places in another unit."""
    omega, noise, flat = _make_waves()
    one = find_index(omega, noise, flat, FOOTPRINT, trials=0)
    other = find_index(omega, noise, flat * factor, FOOTPRINT * factor, trials=0)
    return abs(one.value - other.value)


def index_flat(_: KnownCurve) -> float:
    """No waves, no index."""
    omega, noise, flat = _make_waves()
    return find_index(np.full(len(omega), 0.7), noise, flat, FOOTPRINT).high


def index_spoilt(_: KnownCurve) -> float:
    """As if the points were not there."""
    omega, noise, flat = _make_waves()
    spoilt = omega.copy()
    spoilt[::7] = np.nan
    kept = np.isfinite(spoilt)
    one = find_index(spoilt, noise, flat, FOOTPRINT, trials=0)
    other = find_index(omega[kept], noise[kept], flat[kept], FOOTPRINT, trials=0)
    return abs(one.value - other.value)


def index_nothing(_: KnownCurve) -> float:
    """Empty."""
    return find_index(np.empty(0), np.empty(0), np.empty((0, 2)), FOOTPRINT).value


def index_one(_: KnownCurve) -> float:
    """One point."""
    return find_index(np.ones(1), np.zeros(1), np.zeros((1, 2)), FOOTPRINT).value


def index_ties(_: KnownCurve) -> float:
    """One footprint."""
    return find_index(np.full(100, 0.7), np.zeros(100), np.zeros((100, 2)), FOOTPRINT).value
