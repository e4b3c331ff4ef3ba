"""Plan a scan: what an instrument will show of a leaf at each range and angle of incidence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.mixing import Mixing, PhaseMixing, PulseMixing
from app.core.planning import (
    BOUNDS,
    Bound,
    Limits,
    Prospect,
    Sight,
    Steepest,
    find_steepest,
    foresee,
    full_leaf_angle,
)
from app.core.units import to_degrees, to_mm, to_radians
from app.model.parameters import Beam
from app.simulate.instrument import Instrument
from app.simulate.ranging import WAVELENGTHS, PhaseShift, Pulsed
from app.simulate.virtual_scan import find_instrument

MOST_RANGES, MOST_ANGLES = 200, 361
USUAL = Limits()
LARGEST_FOOTPRINT, MOST_FULL_HITS = 5.0, 1e6
"""Limits beyond these limit nothing: they are slips."""
STEEPEST = 89.0
"""Degrees: beyond, an angle is not worth a plan."""
SHARES = (0.25, 0.5, 1.0)
"""Of the leaf's width, for which the angle that the footprint reaches them is told."""
LEAST_SEEN = 0.02
"""Share of the energy that the first return of a typed-in pulsed instrument needs."""


@dataclass(frozen=True, slots=True)
class Tool:
    """An instrument as far as a plan needs it.

    Attributes
    ----------
    title : str
    beam : Beam
    step_deg : float
        Between neighbouring beams, degrees.
    mixing : PhaseMixing or PulseMixing
    nearest, farthest : float
        Ranges that it measures, metres.
    """

    title: str
    beam: Beam
    step_deg: float
    mixing: Mixing
    nearest: float = 0.0
    farthest: float = math.inf


@dataclass(frozen=True, slots=True)
class PlanOrder:
    """What is planned.

    Attributes
    ----------
    tool : Tool
    length, width : float
        Of the leaf, metres; the longer one is taken for the length.
    ranges : tuple of float
        Metres, rising.
    angles_deg : tuple of float
        Of incidence, degrees, rising.
    behind : float or None
        Metres from the leaf to what stands behind it; None: nothing does.
    contrast : float
        Reflectance of what stands behind over the leaf's.
    limits : Limits
    """

    tool: Tool
    length: float
    width: float
    ranges: tuple[float, ...]
    angles_deg: tuple[float, ...]
    behind: float | None = 1.0
    contrast: float = 1.0
    limits: Limits = USUAL


@dataclass(frozen=True, slots=True)
class RangePlan:
    """One range of a plan: how steep a leaf may stand, and what is seen of it then.

    Attributes
    ----------
    range_m : float
    largest_deg : float or None
        Largest usable angle of incidence, degrees; None: not even 0.
    bound : str
        The limit that binds: footprint, full hits or ghosts.
    footprint_mm : float
        At that angle, or at 0 where none is usable.
    footprint_share : float
        Of the leaf's width.
    points, full_hits, ghosts : float
        Beams whose middle is on the leaf, beams wholly on it, and the share of ghosts, there.
    """

    range_m: float
    largest_deg: float | None
    bound: Bound
    footprint_mm: float
    footprint_share: float
    points: float
    full_hits: float
    ghosts: float


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan: rows for each range and angle, and how steep a leaf may stand at each range."""

    order: PlanOrder
    seen: Prospect  # (ranges, angles)
    rows: tuple[RangePlan, ...]
    reached_deg: Floats  # (ranges, SHARES): where the footprint is so long; NaN: always longer

    @cached_property
    def share(self) -> Floats:
        """Footprint over the leaf's width, (ranges, angles)."""
        found: Floats = self.seen.footprint / self.order.width
        return found


def tool_of(instrument: str, step_deg: float | None = None) -> Tool:
    """A preset, or an instrument that a TOML file describes, with its own step or another.

    Raises
    ------
    WrongUse
        There is no such instrument.
    BadInput
        The file cannot be understood.
    """
    return describe_tool(find_instrument(instrument), step_deg)


def describe_tool(known: Instrument, step_deg: float | None = None) -> Tool:
    """What a plan needs of an instrument."""
    bundle, receiver = known.bundle, known.receiver
    beam = Beam(bundle.exit_diameter / 2, bundle.half_divergence, f"instrument {known.name}")
    step = known.step_deg if step_deg is None else step_deg
    return Tool(
        known.title, beam, step, _mixing_of(known.ranging), receiver.nearest, receiver.farthest
    )


def typed_tool(beam: Beam, step_deg: float, pulse_length: float | None = None) -> Tool:
    """An instrument of one's own: phase shift, or pulsed with a pulse length in metres of range."""
    if pulse_length is None:
        return Tool("Own beam, phase shift", beam, step_deg, PhaseMixing(WAVELENGTHS))
    return Tool("Own beam, pulsed", beam, step_deg, PulseMixing(pulse_length, LEAST_SEEN))


def make_plan(order: PlanOrder) -> Plan:
    """Work a plan out.

    Raises
    ------
    WrongUse
        A size or step that is none, ranges outside the instrument's, an angle of 90 degrees or
        more, or a beam that at every range is wider than the leaf.
    """
    check_order(order)
    sight = sight_of(order)
    ranges, angles = np.array(order.ranges), to_radians(np.array(order.angles_deg))
    seen = foresee(ranges[:, None], angles[None, :], sight)
    steepest = find_steepest(ranges, sight, order.limits)
    at_limit = foresee(ranges, np.nan_to_num(steepest.incidence), sight)
    rows = tuple(_tell_range(order, steepest, at_limit, k) for k in range(len(ranges)))
    return Plan(order, seen, rows, _reach(ranges, sight))


def sight_of(order: PlanOrder) -> Sight:
    """The order in the terms of `app.core.planning`."""
    tool = order.tool
    return Sight(
        tool.beam.radius,
        tool.beam.half_divergence,
        float(to_radians(tool.step_deg)),
        max(order.length, order.width),
        min(order.length, order.width),
        math.inf if order.behind is None else order.behind,
        tool.mixing,
        order.contrast,
    )


def check_order(order: PlanOrder) -> None:
    """Raise `WrongUse` for an order that has no answer."""
    tool, ranges = order.tool, order.ranges
    if not 0.0 < tool.step_deg < 90.0:
        raise WrongUse(
            f"The step between beams must lie above 0 and below 90 degrees, not at "
            f"{tool.step_deg:g}.", "Take it from the settings of the scan, e.g. 0.018.",
        )  # fmt: skip
    if not (ranges and order.angles_deg):
        raise WrongUse("A plan needs a range and an angle of incidence.")
    if len(ranges) > MOST_RANGES or len(order.angles_deg) > MOST_ANGLES:
        raise WrongUse(
            f"A plan has at most {MOST_RANGES} ranges and {MOST_ANGLES} angles.",
            "Give a larger step.",
        )
    for distance in ranges:
        if not (distance > 0.0 and tool.nearest <= distance <= tool.farthest):
            raise WrongUse(
                f"{tool.title} measures from {tool.nearest:g} to {tool.farthest:g} m, not at "
                f"{distance:g} m.", "Give ranges within.",
            )  # fmt: skip
    for angle in order.angles_deg:
        if not 0.0 <= angle <= STEEPEST:
            raise WrongUse(
                f"An angle of incidence of {angle:g} degrees cannot be planned: at 90 the beam "
                "runs along the leaf and has no footprint on it.",
                f"Give angles from 0 to {STEEPEST:g}.",
            )
    if order.behind is not None and not 0.0 < order.behind < math.inf:
        raise WrongUse(
            f"What stands behind a leaf is farther than 0 m and not endlessly far, not at "
            f"{order.behind:g} m.", "Say that nothing stands there where it is the sky.",
        )  # fmt: skip
    _check_limits(order.limits)
    _check_width(order)


def _check_limits(limits: Limits) -> None:
    if not limits.footprint <= LARGEST_FOOTPRINT:
        raise WrongUse(
            f"The largest footprint lies above 0 and up to {100 * LARGEST_FOOTPRINT:g} % of the "
            f"leaf's width, not at {100 * limits.footprint:g} %."
        )
    if not limits.full_hits <= MOST_FULL_HITS:
        raise WrongUse(
            f"The fewest full hits lie from 0 to {MOST_FULL_HITS:,.0f}, not at "
            f"{limits.full_hits:g}."
        )
    if not limits.ghosts <= 1.0:
        raise WrongUse(
            "The largest share of ghosts lies above 0 and up to 100 %, not at "
            f"{100 * limits.ghosts:g} %."
        )


def _check_width(order: PlanOrder) -> None:
    for size in (order.length, order.width):
        if not 0.0 < size < math.inf:
            raise WrongUse(f"Length and width of a leaf must be above 0, not {to_mm(size):g} mm.")
    width, beam, nearest = min(order.length, order.width), order.tool.beam, min(order.ranges)
    spot = 2.0 * (beam.radius + nearest * math.tan(beam.half_divergence))
    if spot >= width:
        raise WrongUse(
            f"At {nearest:g} m the beam is {to_mm(spot):.3g} mm wide, and the leaf only "
            f"{to_mm(width):.3g} mm: no beam falls wholly on it.",
            "Go nearer, or check whether the divergence is the HALF angle.",
        )


def _mixing_of(ranging: PhaseShift | Pulsed) -> Mixing:
    if isinstance(ranging, PhaseShift):
        return PhaseMixing(ranging.wavelengths)
    # Of a digitised record pulses blend where they overlap, which is about their length.
    blend = ranging.blend if ranging.waveform is None else ranging.pulse
    return PulseMixing(blend or ranging.pulse, ranging.least)


def _tell_range(order: PlanOrder, steepest: Steepest, seen: Prospect, k: int) -> RangePlan:
    angle, width = float(steepest.incidence[k]), min(order.length, order.width)
    return RangePlan(
        order.ranges[k],
        None if math.isnan(angle) else float(to_degrees(angle)),
        BOUNDS[int(steepest.bound[k])],
        float(to_mm(seen.footprint[k])),
        float(seen.footprint[k] / width),
        float(seen.points[k]),
        float(seen.full_hits[k]),
        float(seen.ghosts[k]),
    )


def _reach(ranges: Floats, sight: Sight) -> Floats:
    spot = 2.0 * (sight.beam_radius + ranges * math.tan(sight.half_divergence))
    columns = [
        np.where(spot <= share * sight.width, full_leaf_angle(ranges, share, sight), np.nan)
        for share in SHARES
    ]
    found: Floats = to_degrees(np.stack(columns, axis=1))
    return found


def beam_facts(order: PlanOrder) -> dict[str, Any]:
    """What was planned, by names for JSON."""
    tool, mixing = order.tool, order.tool.mixing
    pulsed = isinstance(mixing, PulseMixing)
    return {
        "instrument": tool.title,
        "exit_diameter_mm": to_mm(2.0 * tool.beam.radius),
        "half_divergence_deg": to_degrees(tool.beam.half_divergence),
        "full_divergence_deg": 2.0 * to_degrees(tool.beam.half_divergence),
        "step_deg": tool.step_deg,
        "ranging": "pulsed" if pulsed else "phase shift",
        "pulse_length_m": mixing.blend if isinstance(mixing, PulseMixing) else None,
        "leaf_mm": [to_mm(order.length), to_mm(order.width)],
        "behind_m": order.behind,
        "contrast": order.contrast,
    }
