"""Normals of steep parts of meshes by the intensity of a scan, where it is calibrated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.intensity_angle import Doubt
from app.core.progress import QUIET, Progress
from app.core.surfaces.steep import turn_steep
from app.core.wrinkling.leaf import Choices
from app.core.wrinkling.validity import Limits
from app.model.project import Project
from app.services.surfaces.meshes import LeafSurface
from app.services.wrinkles.measure import measure_wrinkles
from app.services.wrinkles.request import CurveInUse, Source, TableCurve, WrinkleRequest

STEEPEST = float(np.deg2rad(88.0))
"""Beyond 60° too: that is what is asked for here."""
NEEDED = (
    "Normals from intensity need a curve of intensity against the angle that is known beforehand."
)


def choose_curve(curve: Path | None) -> Source:
    """The curve of a goniometer table; raises `WrongUse` where there is none."""
    if curve is None:
        raise WrongUse(NEEDED, "Give a goniometer table (--curve TABLE).")
    return TableCurve(curve)


def turn_surfaces(
    project: Project, scan: str, surfaces: list[LeafSurface], source: Source | None = None,
    progress: Progress = QUIET,
) -> list[LeafSurface]:  # fmt: skip
    """Take the normals of steep faces from intensity; surfaces without a mesh stay.

    Parameters
    ----------
    source : Source or None
        Where the curve comes from; None: the curve in use of the scan.

    Raises
    ------
    WrongUse
        The scan has no curve in use.
    LeafscopeError
        The intensity cannot be read on the curve.
    """
    state = project.state.scan(scan)
    if source is None and state.parameters.curve is None:
        raise WrongUse(NEEDED, "Fit one in the Phase lab and press Use this curve.")
    scanner = state.scan.scanner("normals from intensity")
    angles = _read_angles(project, scan, surfaces, source or CurveInUse(), progress)
    turned = []
    for surface in surfaces:
        if surface.mesh is not None:
            members = project.state.leaves[surface.key].members.indices
            mesh = turn_steep(surface.mesh, state.scan.xyz, members, scanner, angles)
            surface = replace(surface, mesh=mesh)
        turned.append(surface)
    return turned


def _read_angles(
    project: Project, scan: str, surfaces: list[LeafSurface], source: Source, progress: Progress
) -> Floats:
    """Angles from intensity of all points, (n,) radians; NaN where they are not valid."""
    choices = Choices(limits=Limits(steepest=STEEPEST), index=False)
    request = WrinkleRequest(source, choices=choices)
    keys = [surface.key for surface in surfaces if surface.mesh is not None]
    angles = np.full(len(project.state.scan(scan).scan), np.nan)
    for leaf in measure_wrinkles(project, scan, request, keys, progress).leaves:
        if leaf.judged is not None:
            told = leaf.judged.angles
            angles[leaf.points] = np.where(told.doubt == Doubt.NONE, told.omega, np.nan)
    return angles
