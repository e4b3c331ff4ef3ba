"""Put scans that were read into a project; say where the scanner may have stood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.core.radiometry.profile import Profile
from app.core.scanner import fit_spherical
from app.formats.options import DEFAULTS, ReadOptions
from app.model.operations import (
    AddScan,
    AnyOperation,
    SetChannels,
    SetPose,
    Several,
)
from app.model.project import Project
from app.model.scan import Channel, ChannelKind, Pose, Scan, Vector
from app.services.correction_texts import use_correction_texts
from app.services.formulas import use_formula_texts
from app.services.laser_power import measure_by_label, parse_powers, use_powers
from app.services.radiometry import apply_profile, take_partial_hits
from app.services.reading import read_file

KINDS: dict[str, ChannelKind] = {
    "DN": "DN",
    "dB": "dB",
    "linear": "linear",
    "reflectance": "reflectance",
}


def add_scans(project: Project, scans: Sequence[Scan], origin: Vector | None = None) -> list[str]:
    """Put scans on the table as one step of the history; give their keys.

    Parameters
    ----------
    project : Project
    scans : sequence of Scan
        As `read_file` gives them.
    origin : (x, y, z) or None
        Position of the scanner in world metres, when the user gave one.
    """
    keys, steps = [], []
    for scan in scans:
        key = project.shelve(scan)
        keys.append(key)
        steps.append(AddScan(key, scan.name, scan.source))
    poses: list[AnyOperation] = [
        SetPose(key, given_pose(origin, scan))
        for key, scan in zip(keys, scans, strict=True)
        if origin is not None
    ]
    if len(keys) == 1 and not poses:
        project.do(steps[0])
    else:
        names = ", ".join(scan.name for scan in scans)
        project.do(Several(f"Open {names}", (*steps, *poses)))
    return keys


@dataclass(frozen=True)
class Opening:
    """What a headless command is told about its file.

    Attributes
    ----------
    path : Path
    options : ReadOptions
    origin : (x, y, z) or None
        Position of the scanner in world metres, when the user gave one.
    channels : tuple of str
        Channels named by hand, ``NAME=WAVELENGTH:KIND`` or ``NAME=:KIND``.
    profile : Profile or None
        Calibration of its channels.
    powers : tuple of str
        Laser power of the scan, ``CHANNEL=VALUE`` or ``CHANNEL=VALUE:SIGMA``.
    partial_hits : bool
        Give a reflectance also to points that the beam hits in part.
    panel : str or None
        Panel in the scan that tells its laser power, ``FIELD=LABEL:REFLECTANCE[:SIGMA]``: the
        points where the field has that value.
    corrections : tuple of str
        Corrections for the angle of incidence; see `app.services.correction_texts`.
    formulas : tuple of str
        Indices of the user's own, ``NAME=FORMULA``.
    """

    path: Path
    options: ReadOptions = DEFAULTS
    origin: Vector | None = None
    channels: tuple[str, ...] = ()
    profile: Profile | None = None
    powers: tuple[str, ...] = ()
    partial_hits: bool = False
    panel: str | None = None
    corrections: tuple[str, ...] = ()
    formulas: tuple[str, ...] = ()


def open_file(opening: Opening, progress: Progress = QUIET) -> tuple[Project, list[str]]:
    """Read a file into a project of its own: the start of every headless command."""
    project = Project()
    return project, open_into(project, opening, progress)


def open_into(project: Project, opening: Opening, progress: Progress = QUIET) -> list[str]:
    """Read a file into a project beside what it holds; give the keys of its scans."""
    scans = read_file(opening.path, opening.options, progress)
    keys = add_scans(project, scans, opening.origin)
    for key in keys if opening.channels else ():
        scan = project.state.scan(key).scan
        project.do(SetChannels(key, name_channels(scan, opening.channels)))
    for key in keys if opening.profile else ():
        _calibrate(project, key, opening, progress)
    for key in keys if opening.corrections else ():
        use_correction_texts(project, key, opening.corrections)
    for key in keys if opening.formulas else ():
        use_formula_texts(project, key, opening.formulas)
    return keys


def _calibrate(project: Project, key: str, opening: Opening, progress: Progress) -> None:
    apply_profile(project, key, opening.profile)
    if opening.partial_hits:
        take_partial_hits(project, key, True)
    if opening.panel and opening.powers:
        raise WrongUse("The laser's power is measured by --panel or given by --power, not both.")
    if opening.powers:
        use_powers(project, key, parse_powers(opening.powers))
    if opening.panel:
        use_powers(project, key, measure_by_label(project, key, opening.panel, progress))


def set_parameters(project: Project, scan: str, **values: Any) -> None:
    """Change parameters of a scan, e.g. ``radius=0.006``; those that are None stay."""
    given = {name: value for name, value in values.items() if value is not None}
    if given:
        project.set_parameters(scan, **given)


def name_channels(scan: Scan, texts: Sequence[str]) -> tuple[Channel, ...]:
    """Channels of a scan after some were named by hand; others stay.

    Raises
    ------
    WrongUse
        A text that is not ``NAME=WAVELENGTH:KIND``, or a name that the file does not hold.
    """
    channels = {channel.name: channel for channel in scan.channels}
    for text in texts:
        channel = _parse_channel(scan, text)
        channels[channel.name] = channel
    return tuple(channels.values())


def _parse_channel(scan: Scan, text: str) -> Channel:
    name, _, rest = text.partition("=")
    wavelength, _, kind = rest.partition(":")
    if name not in scan.attributes:
        raise WrongUse(
            f"{scan.name} has no values named {name!r}.",
            f"It has {', '.join(scan.attributes) or 'nothing but coordinates'}.",
        )
    if (kind or "DN") not in KINDS:
        raise WrongUse(f"{kind!r} is no kind of channel.", f"Kinds: {', '.join(KINDS)}.")
    try:
        nm = float(wavelength) if wavelength else None
    except ValueError as error:
        raise WrongUse(
            f"{text!r} does not say a channel.",
            "Write NAME=WAVELENGTH:KIND, e.g. intensity=1550:dB.",
        ) from error
    return Channel(name, name, nm, KINDS[kind or "DN"])


def given_pose(position: Vector, scan: Scan) -> Pose:
    """The pose of a scanner whose position the user gave.

    Where the position is the one that the scan's own grid speaks for, it stays known as
    assumed: the user accepted it, nobody measured it.
    """
    proposed = propose_pose(scan)
    if proposed is not None and np.allclose(proposed.position, position, rtol=0, atol=1e-3):
        return proposed
    return Pose(position, known_by="given")


def parse_origin(text: str) -> Vector:
    """Read ``X,Y,Z`` in metres; raises `WrongUse` when it is something else."""
    try:
        x, y, z = (float(part) for part in text.replace(";", ",").split(","))
    except ValueError as error:
        raise WrongUse(
            f"--origin takes three numbers in metres, X,Y,Z, not {text!r}.",
            "Example: --origin 0,0,1.6",
        ) from error
    if not np.isfinite((x, y, z)).all():
        raise WrongUse(f"--origin takes finite numbers, not {text!r}.")
    return x, y, z


def propose_pose(scan: Scan) -> Pose | None:
    """A position that the grid of a scan without pose speaks for, to be accepted by the user.

    Returns
    -------
    Pose or None
        The origin of the file's coordinates, `known_by` 'assumed', when rows and columns
        are elevations and azimuths about it; None when nothing can be said.
    """
    if scan.pose is not None or scan.grid is None:
        return None
    fit = fit_spherical(scan.xyz, scan.grid.row, scan.grid.column, np.zeros(3))
    return Pose((0.0, 0.0, 0.0), known_by="assumed") if fit and fit.fits else None
