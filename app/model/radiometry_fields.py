"""Reflectance as fields: what a profile makes of a channel, how sure it is, why it is missing."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import MissingChannel, WrongUse
from app.core.radiometry.budget import Budget, error_budget
from app.core.radiometry.drift import Power
from app.core.radiometry.marks import WORDS, reflect
from app.core.radiometry.profile import ChannelCalibration, Profile
from app.model.calibrated import find_source
from app.model.fields import Computed, Evaluation, FieldSpec
from app.model.hit_fields import find_missing
from app.model.parameters import Parameters, ScanPower
from app.model.scan import Scan
from app.model.state import ScanState

SIGMA, MARK = "_sigma", "_mark"
OUTSIDE = "darker or brighter than all panels"
PARAMETERS = ("profile", "powers", "partial_hits", "beam")


def reflectance_fields(profile: Profile | None, scan: Scan) -> list[FieldSpec]:
    """Three fields per channel of a profile: the reflectance, its σ, and the mark."""
    specs: list[FieldSpec] = []
    for calibration in profile.channels if profile else ():
        specs += _fields_of(calibration, profile, scan)
    return specs


def _fields_of(
    calibration: ChannelCalibration, profile: Profile | None, scan: Scan
) -> list[FieldSpec]:
    name, unit = calibration.name, "" if calibration.kind == "reflectance" else "DN"
    word = "Reflectance" if calibration.kind == "reflectance" else "Range-corrected"
    nm = calibration.wavelength_nm
    title = f"{word}, {calibration.channel if nm is None else f'{nm:g} nm'}"
    inputs = _inputs(calibration, profile, scan)

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        return compute_reflectance(calibration, evaluation, points)

    def sigma(evaluation: Evaluation, points: Ints | None) -> Computed:
        return Computed(budget_at(calibration, evaluation, points).sigma)

    def mark(evaluation: Evaluation, points: Ints | None) -> Computed:
        return Computed(evaluation.read_beside(name, "mark", points).astype(np.float64))

    needs = ("points", "channels", "pose") if calibration.needs_range else ("points", "channels")
    return [
        FieldSpec(name, title, unit, "scalar", compute, inputs, PARAMETERS, needs),  # type: ignore[arg-type]
        FieldSpec(name + SIGMA, f"σ of {name}", unit, "scalar", sigma, (name,)),
        FieldSpec(name + MARK, f"Mark of {name}", "", "mark", mark, (name,)),
    ]


def _inputs(
    calibration: ChannelCalibration, profile: Profile | None, scan: Scan
) -> tuple[str, ...]:
    inputs = ["range", "hit_fraction"] if calibration.needs_range else ["hit_fraction"]
    with suppress(MissingChannel):  # asking for the values says what is missing
        inputs.insert(0, find_source(calibration, profile, scan))
    return tuple(inputs)


def compute_reflectance(
    calibration: ChannelCalibration, evaluation: Evaluation, points: Ints | None
) -> Computed:
    """Reflectance of a channel by its chain; NaN with a mark beside where there is none."""
    number, distance = _measured(calibration, evaluation, points)
    partial, told = _find_partial(evaluation, points)
    power = power_of(evaluation.subject.state.parameters, calibration)
    values, marks = reflect(calibration, number, distance, power.value, partial)
    counts = np.bincount(marks, minlength=len(WORDS))
    notes: dict[str, object] = {word: int(n) for word, n in zip(WORDS, counts, strict=True) if n}
    parameters = evaluation.subject.state.parameters
    notes |= {"partial hits": told, "power": _tell_power(parameters, calibration)}
    notes["from"] = source_of(calibration, evaluation.subject.state)
    if parameters.profile is not None:
        notes |= {"profile": parameters.profile.name, "origin": parameters.profile.origin}
    if calibration.reflectances is not None and calibration.kind == "reflectance":
        low, high = calibration.reflectances
        notes[OUTSIDE] = int(((values < low) | (values > high)).sum())
    return Computed(values, notes, beside={"mark": marks})


def budget_at(
    calibration: ChannelCalibration, evaluation: Evaluation, points: Ints | None
) -> Budget:
    """Error budget of the reflectance at points; see `app.core.radiometry.budget`."""
    number, distance = _measured(calibration, evaluation, points)
    power = power_of(evaluation.subject.state.parameters, calibration)
    reflectance = evaluation.read(calibration.name, points)
    return error_budget(
        calibration, reflectance, number, distance, power.value, power.sigma, pull_of(power)
    )


def source_of(calibration: ChannelCalibration, state: ScanState) -> str:
    """Name of the raw values of a calibration of the profile in use."""
    return find_source(calibration, state.parameters.profile, state.scan)


def has_power(calibration: ChannelCalibration) -> bool:
    """Whether a channel is calibrated for the power of the laser."""
    return any(isinstance(step, Power) for step in calibration.steps)


def is_power_known(parameters: Parameters, calibration: ChannelCalibration) -> bool:
    """Whether somebody said the power of the scan, where the channel has one."""
    said = any(power.channel == calibration.name for power in parameters.powers)
    return said or not has_power(calibration)


def _tell_power(parameters: Parameters, calibration: ChannelCalibration) -> str:
    power = power_of(parameters, calibration)
    if not has_power(calibration):
        return "of no account"
    if not is_power_known(parameters, calibration):
        return "taken as 1, not measured"
    return f"{power.value:.4g}" + (f" ({power.origin})" if power.origin else "")


def power_of(parameters: Parameters, calibration: ChannelCalibration) -> ScanPower:
    """Laser power of the scan for a channel; 1 where nobody said."""
    said = [power for power in parameters.powers if power.channel == calibration.name]
    return said[0] if said else ScanPower(calibration.name)


def pull_of(power: ScanPower) -> Floats | None:
    """How errors of the calibration move a power, (k,); None where it does not rest on it."""
    return np.array(power.pull) if power.pull else None


def find_calibration(parameters: Parameters, channel: str) -> ChannelCalibration:
    """The calibration of a channel; raises `WrongUse` where no profile in use gives it."""
    for calibration in parameters.profile.channels if parameters.profile else ():
        if calibration.name == channel:
            return calibration
    raise WrongUse(f"{channel} is no channel of a profile in use.", "Open or make a profile first.")


def _measured(
    calibration: ChannelCalibration, evaluation: Evaluation, points: Ints | None
) -> tuple[Floats, Floats]:
    number = evaluation.read(source_of(calibration, evaluation.subject.state), points)
    if not calibration.needs_range:
        return number, np.ones(len(number))
    return number, evaluation.read("range", points)


def _find_partial(evaluation: Evaluation, points: Ints | None) -> tuple[Bools | None, str]:
    """Points that the beam hits in part, or None; and in words how they were looked for."""
    from app.core.radiometry.partial_hits import FULL_HIT

    state = evaluation.subject.state
    if state.parameters.partial_hits:
        return None, "taken along, as asked"
    missing = find_missing(state, evaluation.progress)
    if missing:
        return None, f"not looked for: {missing}"
    share = evaluation.read("hit_fraction", points)
    return share < FULL_HIT, f"left out below {FULL_HIT:g} of the beam"
