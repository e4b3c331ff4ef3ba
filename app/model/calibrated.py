"""Channels that a profile makes of a scan's own: which belong together, and their names."""

from __future__ import annotations

from app.core.errors import MissingChannel
from app.core.radiometry.log_response import Decibel
from app.core.radiometry.profile import ChannelCalibration, Profile
from app.model.scan import Channel, Scan

SAME_NM = 5.0
"""Wavelengths closer than this are one laser's, as two documents print it."""
RAW = ("DN", "dB", "linear")
"""Kinds of channels that are no reflectance yet."""


def find_source(calibration: ChannelCalibration, scan: Scan) -> str:
    """Name of the raw values that a calibration turns into reflectance.

    By name, else by wavelength, else the only raw channel where its wavelength is unknown. The
    energy of a waveform counts when the calibration names it.

    Raises
    ------
    MissingChannel
        There is none, or several; says which channels there are.
    """
    if scan.waveforms is not None and calibration.channel.startswith("energy_"):
        return calibration.channel
    decibels = any(isinstance(step, Decibel) for step in calibration.steps)
    raw = [c for c in scan.channels if c.kind in (("dB",) if decibels else ("DN", "linear"))]
    nm = calibration.wavelength_nm
    for found in (
        [c for c in raw if c.name.casefold() == calibration.channel.casefold() and _may_be(c, nm)],
        [c for c in raw if None not in (nm, c.wavelength_nm) and _may_be(c, nm)],
        raw if len(scan.channels) == 1 and _may_be(raw[0] if raw else None, nm) else [],
    ):
        if len(found) == 1:
            return found[0].name
    there = ", ".join(map(_describe, scan.channels)) or "none"
    at = "" if nm is None else f" at {nm:g} nm"
    raise MissingChannel(
        f"{scan.name} has no raw channel {calibration.channel}{at} that this profile could "
        f"calibrate; its channels: {there}.",
        "Name the channel and its wavelength, or take the profile of this instrument.",
    )


def calibrated_channels(scan: Scan, profile: Profile | None) -> tuple[Channel, ...]:
    """Channels that a profile gives, those whose raw values the scan has."""
    found = []
    for calibration in profile.channels if profile else ():
        try:
            source = find_source(calibration, scan)
        except MissingChannel:
            continue  # asking for its field says what is missing
        nm = calibration.wavelength_nm or _wavelength_of(source, scan)
        # Its values are no attribute of the file but a field.
        calibrated_by = profile.name if profile else ""
        found.append(Channel(calibration.name, "", nm, calibration.kind, calibrated_by))
    return tuple(found)


def _wavelength_of(source: str, scan: Scan) -> float | None:
    return next((c.wavelength_nm for c in scan.channels if c.name == source), None)


def _may_be(channel: Channel | None, nm: float | None) -> bool:
    if channel is None:
        return False
    known = channel.wavelength_nm
    return known is None or nm is None or abs(known - nm) <= SAME_NM


def _describe(channel: Channel) -> str:
    nm = "wavelength unknown" if channel.wavelength_nm is None else f"{channel.wavelength_nm:g} nm"
    return f"{channel.name} ({nm}, {channel.kind})"
