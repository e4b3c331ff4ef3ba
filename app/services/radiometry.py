"""A profile put to use on a scan, and what it gave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec.structs import replace

from app.core.errors import BadInput, MissingChannel
from app.core.radiometry.marks import WORDS
from app.core.radiometry.profile import ChannelCalibration, Profile
from app.model.calibrated import find_source
from app.model.project import Project
from app.model.radiometry_fields import OUTSIDE
from app.model.scan import Scan
from app.services.beams import name_instrument, propose_beam


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
    project.set_parameters(scan, profile=profile, powers=(), beam=beam)


def join_profiles(old: Profile | None, new: Profile) -> Profile:
    """A profile with the channels of `old` beside those of `new`, which win.

    Only profiles that somebody made of the same instrument are joined: drawn panels calibrate one
    channel at a time.
    """
    if old is None or old.origin != "yours" or old.instrument != new.instrument:
        return new
    names = {channel.name for channel in new.channels}
    kept = tuple(channel for channel in old.channels if channel.name not in names)
    notes = (*old.notes, *(note for note in new.notes if note not in old.notes))
    return replace(new, channels=(*kept, *new.channels), notes=notes) if kept else new


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
            find_source(calibration, profile, scan)
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
    project.set_parameters(scan, partial_hits=wanted)


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
    if notes.get(OUTSIDE):
        counts.append(f"{notes[OUTSIDE]:,} of the good ones {OUTSIDE}")
    return (
        f"{name} (from {notes['from']}): {', '.join(counts)}; laser power {notes['power']}; "
        f"partial hits {notes['partial hits']}."
    )
