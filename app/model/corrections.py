"""Corrections in use on a scan: which channel, by which workflow, with which numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import msgspec

from app.core.errors import WrongUse
from app.core.workflows.chain import LEAST_BRACKET, RIGHT_ANGLE, Limits, get_workflow
from app.model.scan import Channel


class Correction(msgspec.Struct, frozen=True):
    """A workflow on a channel, of all points or of some leaves.

    Attributes
    ----------
    source : str
        The channel that is corrected.
    workflow : str
        A name in `app.core.workflows.WORKFLOWS`.
    values : dict of str to float
        Its parameters, those that are determined; m may be missing where k_d is 1.
    covariance : dict of str to dict of str to float
        Of these parameters; what is missing is taken as exact.
    least_bracket : float
        Points whose 1 − b(1 − cos ω) is smaller are marked.
    fitted : (float, float)
        Angles that the parameters were fitted to, radians.
    origin : str
        Where the numbers come from in words, e.g. "fit of Leaf 3".
    leaves : tuple of str
        Keys of the leaves that it is for; empty: all points that no other correction of the
        same name is for.
    """

    source: str
    workflow: str
    values: dict[str, float]
    covariance: dict[str, dict[str, float]] = {}
    least_bracket: float = LEAST_BRACKET
    fitted: tuple[float, float] = (0.0, RIGHT_ANGLE)
    origin: str = ""
    leaves: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the channel that it makes, e.g. ``reflectance_1550_wf2``."""
        return f"{self.source}_{self.workflow}"

    @property
    def limits(self) -> Limits:
        """Where it is believed."""
        return Limits(self.least_bracket, self.fitted)

    def __post_init__(self) -> None:
        chain = get_workflow(self.workflow)
        needed = [p for p in chain.parameters if p not in chain.assumed]
        if self.values.get("k_d") == 1.0:
            needed.remove("m")
        missing = [name for name in needed if name not in self.values]
        strange = [name for name in self.values if name not in chain.parameters]
        if missing or strange:
            raise WrongUse(
                f"{self.workflow} takes {', '.join(chain.parameters)}; "
                f"{', '.join(missing) + ' is missing' if missing else strange[0] + ' is not one'}."
            )
        _check_values(self.values)
        if not 0.0 < self.least_bracket <= 1.0:
            raise WrongUse(
                f"The least bracket lies above 0 and up to 1, not at {self.least_bracket:g}."
            )
        low, high = self.fitted
        if not 0.0 <= low < high <= RIGHT_ANGLE:
            raise WrongUse("The angles of a correction rise within 0 and 90 degrees.")


def _check_values(values: dict[str, float]) -> None:
    for name, value in values.items():
        low, high = {"k_d": (0.0, 1.0), "m": (0.0, 1.0), "f": (0.0, math.inf)}.get(
            name, (-math.inf, math.inf)
        )
        if not (math.isfinite(value) and low <= value <= high) or (name == "m" and value == 0.0):
            raise WrongUse(f"{name} = {value:g} cannot be: it lies within {low:g} and {high:g}.")


def group_corrections(
    corrections: Iterable[Correction], channels: Sequence[Channel]
) -> dict[str, tuple[Correction, ...]]:
    """Corrections by the channel that they make, those whose source is among `channels`."""
    there, found = {channel.name for channel in channels}, dict[str, tuple[Correction, ...]]()
    for correction in corrections:
        if correction.source in there:
            found[correction.name] = (*found.get(correction.name, ()), correction)
    return found


def corrected_channels(
    corrections: Iterable[Correction], channels: Sequence[Channel]
) -> tuple[Channel, ...]:
    """Channels that corrections make of others; of the same wavelength and kind."""
    by_name = {channel.name: channel for channel in channels}
    made = []
    for name, group in group_corrections(corrections, channels).items():
        # The values are no attribute of the file but a field.
        made.append(
            replace(
                by_name[group[0].source],
                name=name,
                attribute="",
                calibration=_describe_group(group),
                sigma=None,
                workflow=group[0].workflow,
            )
        )
    return tuple(made)


def _describe_group(group: Sequence[Correction]) -> str:
    if len(group) > 1:
        return f"{get_workflow(group[0].workflow).title}, {len(group)} corrections, by leaf"
    return describe_correction(group[0])


def describe_correction(correction: Correction) -> str:
    """A correction in a line: its workflow, numbers and origin."""
    numbers = ", ".join(
        f"{name} = {value:.4g}{_tell_spread(correction, name)}"
        for name, value in correction.values.items()
    )
    where = f" ({correction.origin})" if correction.origin else ""
    return f"{get_workflow(correction.workflow).title}, {numbers}{where}"


def _tell_spread(correction: Correction, name: str) -> str:
    variance = correction.covariance.get(name, {}).get(name)
    return "" if variance is None else f" ± {math.sqrt(variance):.2g}"
