"""Channels that a profile makes of a scan's own: which belong together, and their names."""

from __future__ import annotations

from app.core.errors import MissingChannel
from app.core.radiometry.log_response import Decibel
from app.core.radiometry.profile import ChannelCalibration, Profile
from app.model.scan import Channel, Scan

SAME_NM = 2.0
"""Wavelengths closer than this are one laser's, as two documents print it; 1545 and 1550 nm are
two."""
RAW = ("DN", "dB", "linear")
"""Kinds of channels that are no reflectance yet."""


def find_source(calibration: ChannelCalibration, profile: Profile | None, scan: Scan) -> str:
    """Name of the raw values that a calibration of a profile turns into reflectance.

    By name, else by wavelength, else the only raw channel where its wavelength is unknown. The
    energy of a waveform counts when the calibration names it.

    Raises
    ------
    MissingChannel
        There is none, or several, or another calibration of the profile would take the same one;
        says which channels there are.
    """
    found = _find(calibration, scan)
    rivals = [
        other.name
        for other in (profile.channels if profile else ())
        if other is not calibration and found is not None and _find(other, scan) == found
    ]
    if found is not None and not rivals:
        return found
    there = ", ".join(map(_describe, scan.channels)) or "none"
    nm = calibration.wavelength_nm
    at = "" if nm is None else f" at {nm:g} nm"
    if rivals:
        raise MissingChannel(
            f"{found} of {scan.name} cannot be both {calibration.name} and {', '.join(rivals)}.",
            f"Say its wavelength (--channel {found}=NM:DN), or name the channels.",
        )
    raise MissingChannel(
        f"{scan.name} has no raw channel {calibration.channel}{at} that this profile could "
        f"calibrate; its channels: {there}.",
        "Name the channel and its wavelength, or take the profile of this instrument.",
    )


def _find(calibration: ChannelCalibration, scan: Scan) -> str | None:
    if scan.waveforms is not None and calibration.channel.startswith("energy_"):
        return calibration.channel
    decibels = any(isinstance(step, Decibel) for step in calibration.steps)
    raw = [c for c in scan.channels if c.kind in (("dB",) if decibels else ("DN", "linear"))]
    nm, name = calibration.wavelength_nm, calibration.channel.casefold()
    alone = raw if len(scan.channels) == 1 else []
    for found in (
        [c for c in raw if c.name.casefold() == name and _may_be(c, nm)],
        [c for c in raw if None not in (nm, c.wavelength_nm) and _may_be(c, nm)],
        [c for c in alone if _may_be(c, nm)],
    ):
        if len(found) == 1:
            return found[0].name
    return None


def calibrated_channels(scan: Scan, profile: Profile | None) -> tuple[Channel, ...]:
    """Channels that a profile gives, those whose raw values the scan has."""
    found: list[Channel] = []
    if profile is None:
        return ()
    for calibration in profile.channels:
        try:
            source = find_source(calibration, profile, scan)
        except MissingChannel:
            continue  # asking for its field says what is missing
        nm = calibration.wavelength_nm or _wavelength_of(source, scan)
        # Its values are no attribute of the file but a field.
        found.append(Channel(calibration.name, "", nm, calibration.kind, profile.name))
    return tuple(found)


def _wavelength_of(source: str, scan: Scan) -> float | None:
    return next((c.wavelength_nm for c in scan.channels if c.name == source), None)


def _may_be(channel: Channel, nm: float | None) -> bool:
    known = channel.wavelength_nm
    return known is None or nm is None or abs(known - nm) <= SAME_NM


def _describe(channel: Channel) -> str:
    nm = "wavelength unknown" if channel.wavelength_nm is None else f"{channel.wavelength_nm:g} nm"
    return f"{channel.name} ({nm}, {channel.kind})"
