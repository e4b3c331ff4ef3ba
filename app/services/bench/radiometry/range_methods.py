"""Range effects against each other: panels over range, then other targets at other ranges."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry import chain as chains
from app.core.radiometry.joint import fit_jointly
from app.core.radiometry.linear_response import LinearResponse
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.range_curve import PolynomialCurve, Scale, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, Form, InverseSquare
from app.core.radiometry.start import guess_salca
from app.core.radiometry.step import Step
from app.core.radiometry.unknowns import Unknowns
from app.services.bench.radiometry.sights import ends_of, see_panels, take_instrument
from app.services.bench.results import ResultTable, Value

NAME = "radiometry_ranges"
SEEDS, QUICK_SEEDS = 8, 1
PANELS = (0.9, 0.5, 0.25, 0.12, 0.05)
TARGETS = (0.08, 0.15, 0.3, 0.6)
MOST_CLIPPED = 0.01
DEGREE = 4
NOTE = (
    "Means of about 200 points of five panels at 11 ranges, fitted; then means of four other "
    "targets at ranges in between. RMSE and bias in percent of the reflectance, over all of them; "
    "lost: targets without a reflectance. The world has an inverse square that levels off below "
    "3 m (LS880, HDS6100), or Hancock's outer form (SALCA). Two curves without steps of ours: a "
    f"polynomial of degree {DEGREE} over all ranges, and none."
)

Invert = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True, slots=True)
class World:
    """An instrument, where its panels stand and where the targets do.

    Attributes
    ----------
    instrument : str
    channel : int
    ranges : tuple of float
        Of the panels, metres; an odd number.
    reference : float
        One of them.
    """

    instrument: str
    channel: int
    ranges: tuple[float, ...]
    reference: float

    @property
    def between(self) -> tuple[float, ...]:
        """Ranges of the targets: in the middle of each two."""
        return tuple(
            float(np.sqrt(a * b)) for a, b in zip(self.ranges, self.ranges[1:], strict=False)
        )


WORLDS = (
    World("ls880", 0, (1.5, 2.15, 2.6, 3.56, 5.0, 7.5, 10.0, 12.5, 15.0, 20.0, 30.0), 3.56),
    World("hds6100", 0, (2.5, 3.0, 3.6, 4.4, 5.2, 6.2, 7.5, 9.0, 10.5, 12.0, 14.0), 4.4),
    World("salca", 1, (2.1, 2.7, 3.6, 5.0, 6.5, 8.0, 11.0, 16.0, 24.0, 36.0, 55.0), 8.0),
)


def compare_ranges(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """All worlds, all range effects.

    Raises
    ------
    Cancelled
    """
    seeds = QUICK_SEEDS if quick else SEEDS
    rows: list[dict[str, Value]] = []
    for place, world in enumerate(WORLDS):
        errors: dict[str, list[Floats]] = {}
        seconds: dict[str, list[float]] = {}
        for seed in range(seeds):
            progress.report((place + seed / seeds) / len(WORLDS), f"Range of {world.instrument}")
            panels = _scan(world, PANELS, world.ranges, 2 * seed)
            targets = _scan(world, TARGETS, world.between, 2 * seed + 1)
            for name, fit in list_methods(world).items():
                start = time.perf_counter()
                invert = fit(panels)
                seconds.setdefault(name, []).append(time.perf_counter() - start)
                found = invert(targets.dn, targets.distance) / targets.reflectance - 1.0
                errors.setdefault(name, []).append(found)
        rows += [_tell(world, name, errors[name], seconds[name]) for name in errors]
    return ResultTable(NAME, "Range effects against each other", rows, NOTE)


def _tell(world: World, name: str, errors: list[Floats], seconds: list[float]) -> dict[str, Value]:
    error = np.concatenate(errors)
    known = error[np.isfinite(error)]
    return {
        "instrument": world.instrument,
        "range_effect": name,
        "fit_seconds": float(f"{np.median(seconds):.3g}"),
        "rmse_percent": float(f"{100 * np.sqrt(np.mean(known**2)):.3g}"),
        "bias_percent": float(f"{100 * known.mean():.3g}"),
        "largest_percent": float(f"{100 * np.abs(known).max():.3g}"),
        "targets": len(error),
        "lost": len(error) - len(known),
    }


def _scan(
    world: World, reflectances: tuple[float, ...], ranges: tuple[float, ...], seed: int
) -> PanelTable:
    """Means of panels at ranges, without those at an end of the scale."""
    tool = take_instrument(world.instrument)
    low, high = ends_of(tool)
    rows = []
    for number, away in enumerate(ranges):
        sight = see_panels(tool, reflectances, away, 1000 * seed + number)
        for place, rho in enumerate(reflectances):
            dn = sight.dn[sight.of(place), world.channel]
            if np.mean((dn <= low) | (dn >= high)) <= MOST_CLIPPED:
                rows.append((away, dn.mean(), rho, dn.std(ddof=1) / np.sqrt(len(dn))))
    away, dn, rho, sigma = np.array(rows).T
    nm = tool.wavelengths_nm[world.channel]
    return make_table(away, dn, rho, nm, dn_sigma=sigma)


def list_methods(world: World) -> dict[str, Callable[[PanelTable], Invert]]:
    """How each range effect is fitted to a table, and what it then says of a number."""
    log = world.instrument == "ls880"
    levels = tuple(float((world.reference / away) ** 2) for away in world.ranges)
    if log:
        levels = tuple(float(600.0 * np.log10(level)) for level in levels)
    kind: Scale = "additive" if log else "multiplicative"
    common = (kind, world.ranges, levels, world.reference)
    effects: dict[str, tuple[Step, ...]] = {
        "polynomial of order 1": (PolynomialCurve(*common, 1),),
        "polynomial of order 2": (PolynomialCurve(*common, 2),),
        "monotone spline": (SplineCurve(*common),),
        "analytic, outer": (_make_analytic(world, "outer"),),
        "analytic, inner": (_make_analytic(world, "inner"),),
        "inverse square": (InverseSquare(world.reference),),
        "none": (),
    }
    methods = {name: _fit_with(world, steps) for name, steps in effects.items()}
    if world.instrument != "salca":
        methods["one polynomial"] = _fit_whole_log if log else _fit_whole_linear
    return methods


def _make_analytic(world: World, form: Form) -> AnalyticRange:
    return AnalyticRange(
        1.7,
        0.3,
        0.7,
        form,
        world.reference,
        world.ranges[0],
        world.ranges[-1],
    )


def _fit_with(world: World, front: tuple[Step, ...]) -> Callable[[PanelTable], Invert]:
    def fit(table: PanelTable) -> Invert:
        response = _guess_response(world, table)
        shifted = bool(front) and getattr(front[0], "scale", "") == "additive"
        steps = (response, *front) if shifted else (*front, response)
        start = Unknowns(steps, table.scans, np.ones(1), np.zeros(1, bool))
        found = fit_jointly(table, start).found.steps
        return lambda dn, away: chains.invert(found, dn, away)

    return fit


def _guess_response(world: World, table: PanelTable) -> Step:
    if world.instrument == "ls880":
        return LogResponse(600.0, float(table.dn.max()))
    weaker = InverseSquare(world.reference).respond(table.reflectance, table.distance)
    if world.instrument == "salca":
        return guess_salca(weaker, table.dn)
    slope, offset = np.polyfit(weaker, table.dn, 1)
    return LinearResponse(float(1.0 / slope), float(-offset / slope))


def _powers(away: Floats) -> Floats:
    return np.stack([away**k for k in range(DEGREE + 1)], axis=1)


def _fit_whole_log(table: PanelTable) -> Invert:
    """DN = a0 log ρ + p(d)."""
    columns = np.column_stack([np.log10(table.reflectance), _powers(table.distance)])
    found = np.linalg.lstsq(columns, table.dn, rcond=None)[0]
    return lambda dn, away: 10.0 ** ((dn - _powers(away) @ found[1:]) / found[0])


def _fit_whole_linear(table: PanelTable) -> Invert:
    """DN = ρ p(d) + offset."""
    spread = table.reflectance[:, None] * _powers(table.distance)
    columns = np.column_stack([np.ones(len(table)), spread])
    found = np.linalg.lstsq(columns, table.dn, rcond=None)[0]
    return lambda dn, away: (dn - found[0]) / (_powers(away) @ found[1:])
