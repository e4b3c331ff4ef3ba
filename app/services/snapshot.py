"""A picture of a scan coloured by a field, without a window."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import MissingScanner, WrongUse
from app.core.progress import QUIET, Progress
from app.formats.atomic import atomic_path, refuse_target
from app.model.project import Project
from app.model.scene import resolve
from app.model.view_state import ColourRange, ViewState
from app.services.opening import Opening, open_file
from app.services.preparation import prepare

Theme = Literal["light", "dark"]
View = Literal["3d", "image"]


def snapshot_file(
    opening: Opening,
    colour: str,
    out: Path,
    size: tuple[int, int] = (1280, 800),
    theme: Theme = "light",
    limits: tuple[float, float] | None = None,
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
    seen: View = "3d",
    footprints: int | None = None,
) -> None:
    """Make a PNG of a file, seen from its scanner where that is known.

    Parameters
    ----------
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    seen : {'3d', 'image'}
        All scans in perspective, or the scan image of the first.
    footprints : int or None
        Draw the footprints of every so many rows and columns of the first scan; 3d only.

    Raises
    ------
    MissingScanner
        A scan image without the scanner's position.
    WrongUse
        A field that does not exist, or footprints in a scan image.
    BadInput
        The file cannot be read, or lacks what the field needs.
    """
    if footprints is not None and (seen == "image" or footprints < 1):
        raise WrongUse("--footprints takes 1 or more rows and columns, and needs --view 3d.")
    if out.suffix.lower() != ".png":
        raise WrongUse(f"A picture is a .png file, not {out.name}.")
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    for key in keys:
        prepare(project, key, (colour,), parameters or {}, progress)
        project.field(key, colour, None, progress.part(0.4, 0.8))
    ranges = {colour: ColourRange(*limits)} if limits else {}
    view = ViewState(current=keys[0] if keys else None, colour=colour, ranges=ranges)
    if seen == "image" and view.current is not None:
        write_scan_image(project, view, view.current, out, size, theme, overwrite, progress)
    else:
        rings = _ring_points(project, view, footprints, progress)
        write_picture(project, view, out, size, theme, overwrite, rings)


def _ring_points(
    project: Project, view: ViewState, every: int | None, progress: Progress
) -> Floats | None:
    if every is None or view.current is None:
        return None
    from app.services.footprint_rings import make_rings, thin

    state = project.state.scan(view.current)
    rows, _ = thin(state, np.flatnonzero(state.alive), every)
    return make_rings(state, rows, progress.part(0.8, 1.0))


def write_picture(
    project: Project,
    view: ViewState,
    out: Path,
    size: tuple[int, int],
    theme: Theme,
    overwrite: bool = False,
    rings: Floats | None = None,
) -> None:
    """Draw what a view shows of a project, from the scanner of its current scan."""
    from app.render.picture import ProjectSource
    from app.render.snapshot import png_bytes, render_snapshot

    scanner = None
    if view.current is not None:
        try:
            scanner = project.state.scan(view.current).scan.scanner("the view")
        except MissingScanner:
            scanner = None  # an unknown position only means another view
    source = ProjectSource(project, view)
    image = render_snapshot(resolve(project, view), source, size, theme, None, scanner, rings=rings)
    with atomic_path(out, overwrite) as temporary:
        temporary.write_bytes(png_bytes(image, Title=view.colour, Software="Leafscope"))


def write_scan_image(
    project: Project,
    view: ViewState,
    scan: str,
    out: Path,
    size: tuple[int, int],
    theme: Theme,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> None:
    """Draw what the scanner of one scan saw: azimuth to the right, elevation upwards.

    Raises
    ------
    MissingScanner
        The position of the scanner is unknown.
    """
    from app.render.picture import ProjectSource
    from app.render.scan_image.image import make_image
    from app.render.scan_image.layout import lay_out
    from app.render.scan_image.picture import render_scan_image
    from app.render.snapshot import png_bytes

    state = project.state.scan(scan)
    image = make_image(lay_out(state.scan, progress.part(0.8, 1.0)), state.alive)
    source = ProjectSource(project, view)
    drawn = render_scan_image(resolve(project, view), source, scan, image, size, theme)
    with atomic_path(out, overwrite) as temporary:
        temporary.write_bytes(png_bytes(drawn, Title=view.colour, Software="Leafscope"))


def parse_size(text: str) -> tuple[int, int]:
    """Read ``WxH`` in pixels; raises `WrongUse` when it is something else."""
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise WrongUse(f"--size takes WxH in pixels, e.g. 1280x800, not {text!r}.") from error
    if not (64 <= width <= 16_384 and 64 <= height <= 16_384):
        raise WrongUse(f"--size must lie between 64x64 and 16384x16384, not at {text}.")
    return width, height


def parse_limits(text: str) -> tuple[float, float]:
    """Read ``LOW,HIGH``; raises `WrongUse` when it is something else."""
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError as error:
        raise WrongUse(f"--limits takes two numbers, LOW,HIGH, not {text!r}.") from error
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise WrongUse(f"--limits needs finite numbers, LOW below HIGH, not {text}.")
    return low, high
