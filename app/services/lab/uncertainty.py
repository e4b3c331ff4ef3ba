"""How sure the parameters of a curve are: plain, by profile, and by resampled leaves; in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.fitting import FitResult
from app.core.fitting.bins import average_bins
from app.core.fitting.bootstrap import COUNT, bootstrap_leaves
from app.core.fitting.intervals import LEVEL
from app.core.fitting.profile import profile_intervals
from app.core.phase import Parameter, PhaseModel
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.services.lab.gather import Measured
from app.services.lab.method import Method, choose_pairs
from app.services.lab.own_models import AnyModel, find_model

SURE = 0.95
"""Share of the trials that must determine a parameter, or it is said how few do."""


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One fitted parameter with its plain interval; None for what there is not.

    `words` says why a number is missing; empty when all is well.
    """

    name: str
    unit: str
    meaning: str
    value: float | None
    sd: float | None
    low: float | None
    high: float | None
    at_bound: bool
    fixed: bool
    words: str


@dataclass(frozen=True, slots=True)
class IntervalRow:
    """An interval of one parameter; an open end is its bound, or infinite (None).

    `known` is the share of a bootstrap's trials that determine it; None for profiles.
    """

    name: str
    unit: str
    low: float | None
    high: float | None
    low_open: bool
    high_open: bool
    known: float | None
    words: str

    def as_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def describe_parameters(result: FitResult, level: float = LEVEL) -> tuple[ParameterRow, ...]:
    """The parameters of a fit with intervals from their standard deviations (Student's t)."""
    return tuple(_describe(result, p, level) for p in result.angular_model.parameters)


def _describe(result: FitResult, p: Parameter, level: float) -> ParameterRow:
    found, span = result.parameters[p.name], result.interval(p.name, level)
    low, high = span if span is not None else (None, None)
    said = [text for text in result.warnings if text.startswith(f"{p.name} ")]
    return ParameterRow(
        p.name, found.unit, p.meaning, found.value, found.sd, low, high, found.at_bound,
        found.fixed, " ".join(said),
    )  # fmt: skip


def profile(
    method: Method,
    model: AnyModel,
    angle_deg: Floats,
    value: Floats,
    level: float = LEVEL,
    fixed: Mapping[str, float] | None = None,
) -> tuple[IntervalRow, ...]:
    """Profile intervals: how far each parameter can go while the others follow.

    Raises
    ------
    WrongUse
        The fit is none by least squares, or the model is a formula.
    BadInput
        Too few pairs.
    """
    known = _require_squares(method, model, "Profile intervals")
    angle, chosen, _ = choose_pairs(method, angle_deg, value)
    weights = None
    if method.to == "bins":
        means = average_bins(known, angle, chosen, float(to_radians(method.width)))
        angle, chosen, weights = means.angle, means.value, means.weights
    found = profile_intervals(known, angle, chosen, weights=weights, fixed=fixed, level=level)
    rows = []
    for p in known.parameters:
        if p.name in found:
            one = found[p.name]
            low_open, high_open = one.low_open and not p.wraps, one.high_open and not p.wraps
            words = _tell_open(p, low_open, high_open)
            rows.append(
                IntervalRow(
                    p.name, p.unit, _finite(one.low), _finite(one.high), low_open, high_open,
                    None, words,
                )
            )  # fmt: skip
    return tuple(rows)


def _tell_open(p: Parameter, low: bool, high: bool) -> str:
    if low and high:
        return f"The data do not limit {p.name} at all."
    if not (low or high):
        return ""
    end = p.lower if low else p.upper
    if np.isfinite(end):
        return f"{p.name} may lie at its bound, {end:g}."
    return f"The data do not limit {p.name} {'downwards' if low else 'upwards'}."


def bootstrap(
    method: Method,
    model: AnyModel,
    measured: Measured,
    count: int = COUNT,
    seed: int = 0,
    level: float = LEVEL,
    fixed: Mapping[str, float] | None = None,
    progress: Progress = QUIET,
) -> tuple[IntervalRow, ...]:
    """Intervals from whole leaves drawn with replacement: what other leaves would have given.

    A fit to means keeps its weights: a point has that of its step's mean, shared with the
    others of the step.

    Parameters
    ----------
    measured : Measured
        With the leaf of each point; points without one are left out.
    count : int
        Trials.
    seed : int
        The same seed gives the same intervals.

    Raises
    ------
    WrongUse
        The fit is none by least squares, the model is a formula, or the count is impossible.
    BadInput
        Fewer than two leaves, or too few pairs.
    Cancelled
    """
    known = _require_squares(method, model, "Bootstrap intervals")
    low, high = method.angles
    own = measured.take((measured.leaf >= 0) & (measured.angle >= low) & (measured.angle < high))
    angle = to_radians(own.angle)
    weights = _share_weights(known, method, angle, own.value) if method.to == "bins" else None
    found = bootstrap_leaves(
        known, angle, own.value, own.leaf, weights=weights, fixed=fixed, count=count, seed=seed,
        progress=progress,
    )  # fmt: skip
    rows = []
    for p in known.parameters:
        if p.name not in (fixed or {}):
            span, share = found.interval(p.name, level), found.known(p.name)
            low_end, high_end = (None, None) if span is None else span
            words = _tell_share(p, share, count, found.leaves, found.warnings)
            rows.append(IntervalRow(p.name, p.unit, low_end, high_end, False, False, share, words))
    return tuple(rows)


def _share_weights(
    model: PhaseModel, method: Method, angle: Floats, value: Floats
) -> Floats | None:
    """Weight of each point so that points count as their steps' means do."""
    width = float(to_radians(method.width))
    means = average_bins(model, angle, value, width)
    if means.weights is None:
        return None
    weights = np.zeros(len(angle))
    usable = np.flatnonzero(model.accepts(angle))
    place = np.floor(angle[usable] / width + 1e-9).astype(np.int64)
    weights[usable] = (means.weights / means.count)[np.unique(place, return_inverse=True)[1]]
    return weights


def _tell_share(
    p: Parameter, share: float, count: int, leaves: int, warnings: tuple[str, ...]
) -> str:
    words = [w for w in warnings if w.startswith("Only ")]
    if share < SURE:
        words.append(f"{p.name} is determined in {share:.0%} of {count} trials only.")
    return " ".join([f"{count} draws of {leaves} leaves.", *words])


def _require_squares(method: Method, model: AnyModel, what: str) -> PhaseModel:
    known = find_model(model)
    if not method.by_squares:
        raise WrongUse(
            f"{what} can be had of fits by least squares only.",
            "Fit single points or means, without a robust loss.",
        )
    if not isinstance(known, PhaseModel):
        raise WrongUse(
            f"{what} cannot be had of a formula.",
            "Its parameters have standard deviations; the models of the list have both.",
        )
    return known


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
