"""Power of the laser in a scan, from a panel of known reflectance, or as somebody says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from app.core.arrays import Ints
from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.core.radiometry.power import measure_power
from app.core.radiometry.profile import ChannelCalibration
from app.model.parameters import ScanPower
from app.model.project import Project
from app.model.radiometry_fields import find_calibration, has_power, source_of
from app.services.panel_readings import FEWEST

TINY = 1e-9
STRONGEST = 20.0
"""Power over that of the profile's reference scan beyond which it was meant as percent."""


class Known(NamedTuple):
    """What is known of a panel: its reflectance, how sure, and where it stands in words."""

    reflectance: float
    sigma: float
    origin: str


def power_from_panel(
    project: Project,
    scan: str,
    points: Ints,
    reflectance: float,
    sigma: float = 0.0,
    panel: str = "",
    progress: Progress = QUIET,
) -> tuple[ScanPower, ...]:
    """Power of the laser in a scan, from a panel of known reflectance in it (Junttila 2016, 2.5).

    Parameters
    ----------
    points : (k,) rows of the panel's points
    reflectance, sigma : float
        Of the panel, a fraction.
    panel : str
        What it is called, for the origin that is kept.

    Returns
    -------
    tuple of ScanPower
        One per calibrated channel that has a laser power and that the scan has.

    Raises
    ------
    WrongUse
        No profile is in use, it knows no laser power, or the reflectance is not a fraction.
    BadInput
        The panel has too few points with a reflectance.
    """
    state = project.state.scan(scan)
    if state.parameters.profile is None:
        raise WrongUse("The laser's power needs a profile.", "Open or make one first.")
    if not 0.0 < reflectance <= 1.5:
        raise WrongUse(
            f"A panel's reflectance is a fraction such as 0.5, not {reflectance:g}.",
            "Divide percent by 100.",
        )
    points = points[state.alive[points]]
    there = {channel.name for channel in state.channels}
    known = Known(reflectance, sigma, f"panel of {100 * reflectance:.3g} %")
    if panel:
        known = known._replace(origin=f"{known.origin} in {panel}")
    found = [
        _measure_power(project, scan, calibration, points, known, progress)
        for calibration in state.parameters.profile.channels
        if calibration.name in there and has_power(calibration)
    ]
    if not found:
        raise WrongUse("The profile in use knows no laser power.", "It was made without drift.")
    return tuple(found)


def measure_by_label(
    project: Project, scan: str, text: str, progress: Progress = QUIET
) -> tuple[ScanPower, ...]:
    """Power by a panel that a field marks, ``FIELD=LABEL:REFLECTANCE[:SIGMA]``.

    Raises
    ------
    WrongUse
        The text says something else, or there is no such field.
    BadInput
        No point has that label; see `power_from_panel`.
    """
    field, _, rest = text.partition("=")
    try:
        label, *known = (float(part) for part in rest.split(":"))
        reflectance, sigma = (*known, 0.0)[:2] if 0 < len(known) < 3 else ()
    except ValueError as error:
        raise WrongUse(
            f"{text!r} does not say a panel.",
            "Write FIELD=LABEL:REFLECTANCE[:SIGMA], e.g. panel=3:0.5:0.01.",
        ) from error
    points = np.flatnonzero(project.field(scan, field, None, progress) == label)
    if not len(points):
        raise BadInput(f"No point has the {field} {label:g}.", "Name the label of the panel.")
    told = f"{field} {label:g}"
    return power_from_panel(project, scan, points, reflectance, sigma, told, progress)


def use_powers(project: Project, scan: str, powers: tuple[ScanPower, ...]) -> None:
    """Take powers of the laser for a scan (none: 1 again); one step to undo.

    Raises
    ------
    WrongUse
        One is for a channel that the profile in use does not have, or whose power it ignores.
    """
    parameters = project.state.scan(scan).parameters
    names = [power.channel for power in powers]
    if len(set(names)) < len(names):
        raise WrongUse(f"A laser power is given twice: {', '.join(names)}.", "Give each once.")
    for power in powers:
        if power.value > STRONGEST:
            raise WrongUse(
                f"A laser power of {power.value:g} is not a share of that of the profile.",
                "Give 0.93 for 93 %.",
            )
        if not has_power(find_calibration(parameters, power.channel)):
            raise WrongUse(f"The profile in use knows no laser power of {power.channel}.")
        if len(power.pull) not in (0, len(find_calibration(parameters, power.channel).free)):
            raise WrongUse(f"The power of {power.channel} was measured with another profile.")
    project.set_parameters(scan, powers=powers)


def parse_powers(texts: Sequence[str]) -> tuple[ScanPower, ...]:
    """Read ``CHANNEL=VALUE`` or ``CHANNEL=VALUE:SIGMA``; raises `WrongUse` for anything else."""
    powers = []
    for text in texts:
        channel, _, rest = text.partition("=")
        value, _, sigma = rest.partition(":")
        try:
            powers.append(ScanPower(channel, float(value), float(sigma or 0.0), "given"))
        except ValueError as error:
            raise WrongUse(
                f"{text!r} does not say the laser's power.",
                "Write CHANNEL=VALUE or CHANNEL=VALUE:SIGMA, e.g. reflectance_1545=0.93:0.01.",
            ) from error
    return tuple(powers)


def _measure_power(
    project: Project,
    scan: str,
    calibration: ChannelCalibration,
    points: Ints,
    known: Known,
    progress: Progress,
) -> ScanPower:
    """Power from the points of a panel that have a reflectance; the panel's own σ is one error."""
    state = project.state.scan(scan)
    good = np.isfinite(project.field(scan, calibration.name, points, progress))
    count = int(np.count_nonzero(good))
    if count < FEWEST:
        raise BadInput(
            f"Only {count} of {len(points)} points of the panel have a {calibration.name}, and the "
            f"laser's power needs {FEWEST}.",
            "See the marks: they may be saturated, or outside the calibrated ranges.",
        )
    number = project.field(scan, source_of(calibration, state), points[good])
    distance = np.ones(count)
    if calibration.needs_range:
        distance = calibration.hold(project.field(scan, "range", points[good]))
    told = None if calibration.noise else np.full(count, max(float(np.std(number)), TINY))
    rho = np.full(count, known.reflectance)
    power, spread, pull = measure_power(calibration, number, distance, rho, 0.0, told)
    sigma = float(np.hypot(spread, power * known.sigma / known.reflectance))
    return ScanPower(calibration.name, power, sigma, known.origin, tuple(map(float, pull)))
