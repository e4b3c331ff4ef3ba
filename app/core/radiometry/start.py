"""Start values of a joint fit, by linear least squares where the model allows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import msgspec
import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.models import CalibrationModel
from app.core.radiometry.nodes import (
    Nodes,
    Order,
    choose_nodes,
    find_ranges,
    place_reference,
    take_every,
    take_nodes,
)
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.range_curve import PolynomialCurve, RangeCurve, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, Form, InverseSquare
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.step import Step

GRID_A = (1.0, 1.5, 2.0, 2.5)
GRID_K2 = (0.05, 0.15, 0.5, 1.5)
GRID_K3 = (0.3, 0.7, 1.5)
GRID_K = np.geomspace(0.3, 100.0, 40)
LEAST_RISE = 1e-9
"""Share of the largest number; less is rounding."""
DIMMEST = 1e-3
"""Least level of a multiplicative curve at the start, as a share of the largest."""


@dataclass(frozen=True, slots=True)
class Ranging:
    """What is decided about the range before a fit.

    Attributes
    ----------
    reference : float
        Metres.
    breaks : tuple of float
        Where the user wants pieces to meet; empty: found by the rule of `nodes`.
    """

    reference: float
    breaks: tuple[float, ...] = ()


@np.errstate(over="ignore", invalid="ignore")
def guess_steps(
    table: PanelTable, model: CalibrationModel, ranging: Ranging, powers: Floats
) -> tuple[Step, ...]:
    """Steps of a model with values from which a fit finds the best ones.

    Parameters
    ----------
    table : PanelTable
    model : CalibrationModel
    ranging : Ranging
    powers : (n,) array
        Power of each row's scan, as far as it is known.
    """
    light = table.reflectance * powers
    effect = model.range_effect.name if model.range_effect else ""
    if effect in ("polynomial", "spline"):
        return _guess_curve(table, model, ranging, light)
    tried = [
        _guess_behind(table, model, light, step) for step in _offer_effects(effect, table, ranging)
    ]
    return min(tried, key=lambda steps: _measure_misfit(table, steps, light))


def form_of(effect: str) -> Form:
    """Reading of equation A5 that a range effect names."""
    return "inner" if effect.endswith("inner") else "outer"


def offer_analytic(form: Form, distance: Floats, reference: float) -> list[AnalyticRange]:
    """Analytic effects on a coarse grid, known over the distances."""
    ends = (float(distance.min()), float(distance.max()))
    near, far = min(ends[0], reference), max(ends[1], reference)
    grid = product(GRID_A, GRID_K2, GRID_K3)
    return [AnalyticRange(a, k2, k3, form, reference, near, far) for a, k2, k3 in grid]


def guess_powers(table: PanelTable, fixed: Sequence[str], log: bool) -> Floats:
    """Power of each scan over that of the first, from panels that stand still, (s,).

    Not for SALCA's response, whose stages find the powers.
    """
    rows = table.pick(np.isin(table.panel, fixed))
    place = np.array([table.scans.index(scan) for scan in rows.scan.tolist()])
    each = np.equal.outer(place, np.arange(len(table.scans))).astype(float)
    if log:
        decades = np.log10(rows.reflectance)[:, None]
        slope = decades if np.ptp(decades) > 0 else np.empty((len(rows), 0))
        found = solve_linear(np.hstack([each, slope]), rows.dn)
        steep = found[-1] if slope.size else _guess_slope(table)
        return np.asarray(10.0 ** ((found[: len(table.scans)] - found[0]) / steep))
    columns = each * rows.reflectance[:, None]
    if len(rows.panels) > 1:
        columns = np.hstack([columns, np.ones((len(rows), 1))])
    found = solve_linear(columns, rows.dn)[: len(table.scans)]
    return (
        np.asarray(np.maximum(found / found[0], DIMMEST)) if found[0] > 0 else np.ones(len(found))
    )


def _guess_slope(table: PanelTable) -> float:
    """DN per decade, over all rows."""
    columns = np.stack([np.ones(len(table)), np.log10(table.reflectance)], axis=1)
    return max(float(solve_linear(columns, table.dn)[1]), 1e-6)


def _offer_effects(effect: str, table: PanelTable, ranging: Ranging) -> Sequence[Step | None]:
    if not effect:
        return [None]
    if effect == "inverse-square":
        return [InverseSquare(ranging.reference)]
    return offer_analytic(form_of(effect), table.distance, ranging.reference)


def _guess_behind(
    table: PanelTable, model: CalibrationModel, light: Floats, effect: Step | None
) -> tuple[Step, ...]:
    """The response behind a range effect that is taken as it is."""
    front = () if effect is None else (effect,)
    seen = chains.respond(front, light, table.distance)
    return (*front, guess_response(model, seen, table.dn))


def guess_response(model: CalibrationModel, light: Floats, dn: Floats) -> Step:
    """A response through pairs of light and number.

    Raises
    ------
    BadInput
        The number does not rise with the light.
    """
    name = model.response.name
    if name == "salca":
        return guess_salca(light, dn)
    if name == "proportional":
        gain = float(light @ dn / (light @ light))
        _refuse_falling(gain * float(light.max()), dn)
        return Proportional(gain)
    x = np.log10(light) if name == "log" else light
    offset, slope = solve_linear(np.stack([np.ones(len(x)), x], axis=1), dn)
    _refuse_falling(slope * float(np.ptp(x)), dn)
    return (
        LogResponse(slope, offset) if name == "log" else LinearResponse(1 / slope, -offset / slope)
    )


def guess_salca(light: Floats, dn: Floats) -> SalcaResponse:
    """Linear least squares of m and c for each k of a grid; the best of them."""
    best = (np.inf, SalcaResponse(1.0, 1.0, 1.0))
    for k in GRID_K:
        rise = -np.expm1(-k * light)
        columns = np.stack([light * rise, rise], axis=1)
        m, c = solve_linear(columns, dn)
        top = max(abs(m), abs(c), 1e-9)
        m, c = max(m, 1e-3 * top), max(c, 1e-3 * top)
        misfit = float(np.sum((columns @ (m, c) - dn) ** 2))
        if misfit < best[0]:
            best = misfit, SalcaResponse(float(m), float(c), float(k))
    return best[1]


def guess_levels(
    nodes: Nodes, model: CalibrationModel, reference: float, factor: Floats, distance: Floats
) -> RangeCurve:
    """A multiplicative curve through factors that were seen at distances."""
    curve = make_curve(nodes, model, reference)
    found = solve_linear(curve.shares(distance).T, factor)
    at = curve.ranges.index(reference)
    levels = found / found[at] if found[at] > 0 else np.ones(len(found))
    raised = np.maximum(levels, DIMMEST * levels.max())
    return msgspec.structs.replace(curve, levels=tuple(map(float, raised)))


def find_nodes(
    model: CalibrationModel, ranging: Ranging, number: Floats, light: Floats, distance: Floats
) -> Nodes:
    """Nodes of a curve: those the user gave, or by the rule of `nodes`.

    `number` rises with the logarithm of the light (additive), or in proportion to it.
    """
    if ranging.breaks:
        return take_nodes(ranging.breaks, distance, ranging.reference)
    additive = model.range_scale == "additive"
    rows: Bools = np.isfinite(number) & (additive | (number > 0))
    seen = number[rows] if additive else np.log(number[rows])
    spread = float(np.sum((seen - seen.mean()) ** 2)) or 1.0

    slopes = np.log(light)[None]
    if model.response.name == "proportional":  # its slope is known
        seen, slopes = seen - slopes[0, rows], slopes[:0]

    def measure(curve: PolynomialCurve) -> float:
        columns = np.vstack([curve.shares(distance), slopes]).T[rows]
        return float(np.sum((columns @ solve_linear(columns, seen) - seen) ** 2)) / spread

    return choose_nodes(
        distance, ranging.reference, model.range_scale, measure, orders_of(model), len(slopes)
    )


def orders_of(model: CalibrationModel) -> tuple[Order, ...]:
    """Orders of the pieces that a model's curve may have."""
    named = model.range_effect.name if model.range_effect else ""
    return (1, 2) if named == "polynomial" else (1,)


def guess_front(
    table: PanelTable,
    model: CalibrationModel,
    ranging: Ranging,
    light: Floats,
    response: SalcaResponse,
) -> RangeCurve:
    """A multiplicative curve before SALCA's response, from the light that the numbers tell."""
    seen = response.invert(table.dn, table.distance)
    nodes = find_nodes(model, ranging, seen, light, table.distance)
    known = np.isfinite(seen)
    factor, distance = (seen / light)[known], table.distance[known]
    return guess_levels(nodes, model, ranging.reference, factor, distance)


def _guess_curve(
    table: PanelTable, model: CalibrationModel, ranging: Ranging, light: Floats
) -> tuple[Step, ...]:
    if model.response.name == "salca":
        weakened = InverseSquare(ranging.reference).respond(light, table.distance)
        response = guess_salca(weakened, table.dn)
        return guess_front(table, model, ranging, light, response), response
    number = table.dn - _guess_offset(table, model, ranging, light)
    alike = model.response.name == "proportional" and float(np.ptp(table.reflectance)) == 0
    if alike and not ranging.breaks:  # divided by the panel at the same range, as the paper does
        nodes = take_every(table.distance, ranging.reference)
    else:
        nodes = find_nodes(model, ranging, number, light, table.distance)
    curve = make_curve(nodes, model, ranging.reference)
    shares = curve.shares(table.distance)
    at = curve.ranges.index(ranging.reference)
    if model.range_scale == "additive":
        columns = np.vstack([shares, np.log10(light)]).T
        found = solve_linear(columns, table.dn)
        a0, a1 = float(found[-1]), float(found[at])
        _refuse_falling(a0 * float(np.ptp(np.log10(light))), table.dn)
        return LogResponse(a0, a1), curve.with_values(np.delete(found[:-1] - a1, at))
    offset = np.ones((1 if model.response.name == "linear" else 0, len(table)))
    levels = solve_linear(np.vstack([shares * light, offset]).T, table.dn)[: len(shares)]
    _refuse_falling(float(levels[at]) * float(light.max()), table.dn)
    relative = np.maximum(levels / levels[at], DIMMEST)
    front = curve.with_values(np.delete(relative, at))
    return front, guess_response(model, front.respond(light, table.distance), table.dn)


def _guess_offset(
    table: PanelTable, model: CalibrationModel, ranging: Ranging, light: Floats
) -> float:
    """DN of no light: with a factor of its own for each range, a linear problem."""
    if model.response.name != "linear":
        return 0.0
    ranges = place_reference(find_ranges(table.distance), ranging.reference)
    every = make_curve(Nodes(tuple(ranges.tolist()), 1), model, ranging.reference)
    columns = np.vstack([every.shares(table.distance) * light, np.ones(len(light))])
    return float(solve_linear(columns.T, table.dn)[-1])


def make_curve(nodes: Nodes, model: CalibrationModel, reference: float) -> RangeCurve:
    """A curve of a model that is flat as yet."""
    levels = (0.0 if model.range_scale == "additive" else 1.0,) * len(nodes.ranges)
    if model.range_effect is not None and model.range_effect.name == "spline":
        return SplineCurve(model.range_scale, nodes.ranges, levels, reference)
    return PolynomialCurve(model.range_scale, nodes.ranges, levels, reference, nodes.order)


def _measure_misfit(table: PanelTable, steps: tuple[Step, ...], light: Floats) -> float:
    away = chains.respond(steps, light, table.distance) - table.dn
    return float(np.sum(away**2)) if np.isfinite(away).all() else np.inf


def _refuse_falling(rise: float, dn: Floats) -> None:
    """Refuse numbers that do not rise from the darkest panel to the brightest: not by rounding."""
    if not rise > LEAST_RISE * float(np.abs(dn).max()):
        raise BadInput(
            "The DN does not rise with the reflectance of the panels.",
            "Check the columns, and leave saturated panels out (--saturated DN).",
        )


def solve_linear(columns: Floats, target: Floats) -> Floats:
    """Linear least squares."""
    return np.asarray(np.linalg.lstsq(columns, target, rcond=None)[0], float)
