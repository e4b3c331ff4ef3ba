"""A profile put to use on a scan: apply it, find the laser's power, explain a reflectance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, MissingChannel, WrongUse
from app.core.progress import QUIET, Progress
from app.core.radiometry.budget import PARTS, mean_budget
from app.core.radiometry.drift import Power
from app.core.radiometry.marks import WORDS
from app.core.radiometry.profile import ChannelCalibration, Profile
from app.model.calibrated import find_source
from app.model.operations import SetParameters
from app.model.parameters import Parameters, ScanPower
from app.model.project import Project
from app.model.radiometry_fields import MARK, power_of
from app.model.scan import Scan
from app.services.beams import name_instrument, propose_beam

FEWEST = 10
"""Returns of a panel below which its mean says little."""


@dataclass(frozen=True, slots=True)
class PanelReading:
    """A panel in a scan, as one raw channel saw it.

    Attributes
    ----------
    channel : str
    range_m : float
        Mean of its returns.
    dn : float
        Mean of its full hits.
    sigma : float
        Standard error of that mean.
    n : int
        Full hits.
    partial : int
        Returns that were left out because the beam lay on the panel in part.
    partial_known : bool
        False where nobody could look for partial hits: without a beam or a grid.
    """

    channel: str
    range_m: float
    dn: float
    sigma: float
    n: int
    partial: int
    partial_known: bool


@dataclass(frozen=True, slots=True)
class Explained:
    """A reflectance, of a point or as the mean of several, and what makes it unsure.

    Attributes
    ----------
    reflectance, sigma : float
        NaN where no point has one.
    parts : mapping of str to float
        σ by cause: noise, fit, panels, power, range.
    n : int
        Points with a reflectance.
    marks : mapping of str to int
        How many points have none, and why.
    """

    reflectance: float
    sigma: float
    parts: Mapping[str, float]
    n: int
    marks: Mapping[str, int]


def apply_profile(project: Project, scan: str, profile: Profile | None) -> None:
    """Calibrate the channels of a scan by a profile, or (None) no more; one step to undo.

    The power of the laser goes back to 1: it was measured against another profile. Where the
    beam is unknown, that of the scan's own instrument is taken, to leave partial hits out.

    Raises
    ------
    BadInput
        The profile is of another instrument than the scan says.
    MissingChannel
        The scan has no raw channel that the profile calibrates.
    """
    state = project.state.scan(scan)
    beam = state.parameters.beam
    if profile is not None:
        check_profile(state.scan, profile)
        beam = beam or propose_beam(state.scan)
    _change(project, scan, profile=profile, powers=(), beam=beam)


def check_profile(scan: Scan, profile: Profile) -> None:
    """Refuse a profile that does not belong to a scan; see `apply_profile` for the errors."""
    tool = name_instrument(scan)
    if tool is not None and profile.instrument and not _same(profile.instrument, tool.name):
        raise BadInput(
            f"The profile {profile.name} is for the instrument {profile.instrument}; "
            f"{scan.name} was made with {tool.title}.",
            "Take a profile of that instrument, or calibrate one from panels.",
        )
    errors = []
    for calibration in profile.channels:
        try:
            find_source(calibration, scan)
        except MissingChannel as error:
            errors.append(error)
        else:
            _refuse_twice(calibration, scan)
    if len(errors) == len(profile.channels):
        raise errors[0]


def _refuse_twice(calibration: ChannelCalibration, scan: Scan) -> None:
    if calibration.name in scan.attributes or any(
        c.name == calibration.name for c in scan.channels
    ):
        raise BadInput(
            f"{scan.name} has values named {calibration.name} already, and the profile would "
            "give them once more.",
            "Rename them in the file, or use what is there.",
        )


def _same(instrument: str, tool: str) -> bool:
    """Whether a profile's instrument is a scan's; a filter in its software changes no intensity."""
    first, second = instrument.casefold(), tool.casefold()
    return first == second or second == f"{first}_filtered" or first == f"{second}_filtered"


def take_partial_hits(project: Project, scan: str, wanted: bool) -> None:
    """Give a reflectance also to partial hits, or to full hits only; one step to undo."""
    _change(project, scan, partial_hits=wanted)


def measure_panel(
    project: Project, scan: str, points: Ints, channel: str, progress: Progress = QUIET
) -> PanelReading:
    """Mean of a raw channel over the full hits of a panel.

    Raises
    ------
    BadInput
        Too few points are left.
    """
    state = project.state.scan(scan)
    points = points[state.alive[points]]
    share = _read_share(project, scan, points, progress)
    full = np.ones(len(points), bool) if share is None else _is_full(share)
    values = project.field(scan, channel, points, progress)
    used = full & np.isfinite(values)
    if np.count_nonzero(used) < FEWEST:
        raise BadInput(
            f"Only {np.count_nonzero(used)} of {len(points)} points of the panel can be used, and "
            f"its mean needs {FEWEST}.",
            "Draw it larger, away from its border.",
        )
    chosen, number = values[used], int(used.sum())
    return PanelReading(
        channel,
        float(np.mean(project.field(scan, "range", points[used]))),
        float(np.mean(chosen)),
        float(np.std(chosen, ddof=1) / np.sqrt(number)),
        number,
        int(np.count_nonzero(~full)),
        share is not None,
    )


def _is_full(share: Floats) -> np.ndarray:
    from app.core.radiometry.partial_hits import FULL_HIT

    return ~(share < FULL_HIT)


def _read_share(project: Project, scan: str, points: Ints, progress: Progress) -> Floats | None:
    from app.model.neighbours import neighbours_of

    state = project.state.scan(scan)
    if state.parameters.beam is None or state.scan.pose is None:
        return None
    if neighbours_of(state.scan, progress).grid is None:
        return None
    return project.field(scan, "hit_fraction", points, progress)


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
    found = []
    for calibration in state.parameters.profile.channels:
        if calibration.name in there and _has_power(calibration):
            value, spread = _measure_power(project, scan, calibration, points, progress)
            share = np.hypot(spread, sigma / reflectance)
            value /= reflectance
            found.append(
                ScanPower(calibration.name, value, float(value * share), _tell(panel, reflectance))
            )
    if not found:
        raise WrongUse("The profile in use knows no laser power.", "It was made without drift.")
    return tuple(found)


def use_powers(project: Project, scan: str, powers: tuple[ScanPower, ...]) -> None:
    """Take powers of the laser for a scan (none: 1 again); one step to undo.

    Raises
    ------
    WrongUse
        One is for a channel that the profile in use does not have, or whose power it ignores.
    """
    parameters = project.state.scan(scan).parameters
    for power in powers:
        if not _has_power(_find(parameters, power.channel)):
            raise WrongUse(f"The profile in use knows no laser power of {power.channel}.")
    _change(project, scan, powers=powers)


def _tell(panel: str, reflectance: float) -> str:
    return f"panel of {100 * reflectance:.3g} %{f' in {panel}' if panel else ''}"


def _has_power(calibration: ChannelCalibration) -> bool:
    return any(isinstance(step, Power) for step in calibration.steps)


def _measure_power(
    project: Project, scan: str, calibration: ChannelCalibration, points: Ints, progress: Progress
) -> tuple[float, float]:
    """Mean reflectance of points at a power of 1, and its relative standard error."""
    seen = project.field(scan, calibration.name, points, progress)
    seen = (
        seen[np.isfinite(seen)] * power_of(project.state.scan(scan).parameters, calibration).value
    )
    if len(seen) < FEWEST:
        raise BadInput(
            f"Only {len(seen)} of {len(points)} points of the panel have a {calibration.name}, and "
            f"the laser's power needs {FEWEST}.",
            "See the marks: they may be saturated, or outside the calibrated ranges.",
        )
    mean = float(np.mean(seen))
    return mean, float(np.std(seen, ddof=1) / np.sqrt(len(seen)) / mean)


def explain_reflectance(
    project: Project, scan: str, channel: str, points: Ints, progress: Progress = QUIET
) -> Explained:
    """Mean reflectance of points (or of one), its σ, and the parts of it.

    Raises
    ------
    WrongUse
        The channel is not one of the profile in use.
    """
    state = project.state.scan(scan)
    calibration = _find(state.parameters, channel)
    points = points[state.alive[points]]
    values = project.field(scan, channel, points, progress)
    marks = project.field(scan, channel + MARK, points).astype(np.int64)
    number = project.field(scan, find_source(calibration, state.scan), points)
    distance = (
        project.field(scan, "range", points) if calibration.needs_range else np.ones(len(points))
    )
    power = power_of(state.parameters, calibration)
    budget = mean_budget(calibration, values, number, distance, power.value, power.sigma)
    known = values[np.isfinite(values)]
    counts = np.bincount(marks, minlength=len(WORDS))
    return Explained(
        float(np.mean(known)) if len(known) else float("nan"),
        float(budget.sigma[0]),
        {part: float(value[0]) for part, value in zip(PARTS, budget, strict=True)},
        len(known),
        {word: int(n) for word, n in zip(WORDS[1:], counts[1:], strict=True) if n},
    )


def _find(parameters: Parameters, channel: str) -> ChannelCalibration:
    for calibration in parameters.profile.channels if parameters.profile else ():
        if calibration.name == channel:
            return calibration
    raise WrongUse(f"{channel} is no channel of a profile in use.", "Open or make a profile first.")


def _change(project: Project, scan: str, **values: object) -> None:
    import msgspec

    old = project.state.scan(scan).parameters
    project.do(SetParameters(scan, msgspec.structs.replace(old, **values)))


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


def tell_calibration(project: Project, scan: str, fields: Sequence[str]) -> list[str]:
    """Sentences about calibrated channels among computed fields: the profile, what is marked."""
    parameters = project.state.scan(scan).parameters
    known = project.cache.known(scan)
    lines = []
    for calibration in parameters.profile.channels if parameters.profile else ():
        if any(name.startswith(calibration.name) for name in fields) and calibration.name in known:
            lines.append(_tell_marks(calibration.name, known[calibration.name].notes))
    if lines and parameters.profile is not None:
        whose = "published, not yours" if parameters.profile.origin == "published" else "yours"
        lines.insert(0, f"Profile: {parameters.profile.name} ({whose}).")
    return lines


def _tell_marks(name: str, notes: Mapping[str, object]) -> str:
    counts = [f"{notes[word]:,} {word}" for word in WORDS if notes.get(word)]
    return f"{name}: {', '.join(counts)}; partial hits {notes['partial hits']}."
