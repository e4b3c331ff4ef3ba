"""How the user wants to look at the document; nothing of it changes a number."""

from __future__ import annotations

from typing import Literal

import msgspec

from app.model.points import PointSet
from app.model.scan import Vector

Theme = Literal["system", "light", "dark"]


class ColourRange(msgspec.Struct, frozen=True):
    """Limits of a colour bar; `locked` ones stay when the scan changes."""

    low: float
    high: float
    locked: bool = False


class Preview(msgspec.Struct, frozen=True):
    """Points shown in the colour of a leaf though they are not (yet) its members.

    Attributes
    ----------
    scan : str
        Key of the scan whose points they are.
    leaf : str
        Key that gives the colour, e.g. of the leaf that was carried here from another scan.
    members : PointSet
    """

    scan: str
    leaf: str
    members: PointSet


class ViewState(msgspec.Struct, frozen=True):
    """Intention of the user: which scan, coloured by what, from where.

    Attributes
    ----------
    current : str or None
        Key of the scan that panels and tools work on.
    hidden : tuple of str
        Keys of scans that are not drawn.
    colour : str
        Field that colours the points; empty for plain points.
    ranges : dict of str to ColourRange
        Limits chosen by hand, by field; others follow the data.
    maps : dict of str to str
        Colour maps chosen by hand, by field.
    point_size : float
        Pixels, before the screen's scale.
    show_leaves, show_ghosts : bool
        Overlays of leaf colours and of points marked as ghosts.
    show_footprints : bool
        Whether the beam's footprint is drawn at selected points, or at some of the leaf.
    show_mesh : bool
        Whether the mesh of the leaf is drawn.
    footprint_step : int
        Rows and columns of a leaf from one footprint to the next.
    leaf : str or None
        Key of the leaf that panels work on.
    previewed : tuple of Preview
        Leaves to be shown beside those of the document; no session file keeps them.
    camera : tuple of three vectors or None
        Position, focal point, view up in world metres; None shows everything.
    view_angle : float
        Degrees from the lower to the upper border of a view in perspective.
    parallel_scale : float or None
        Half height of the view in metres when it is orthographic, else None.
    """

    current: str | None = None
    hidden: tuple[str, ...] = ()
    colour: str = ""
    ranges: dict[str, ColourRange] = {}
    maps: dict[str, str] = {}
    point_size: float = 2.0
    show_leaves: bool = False
    show_ghosts: bool = True
    show_footprints: bool = False
    show_mesh: bool = False
    footprint_step: int = 8
    leaf: str | None = None
    previewed: tuple[Preview, ...] = ()
    theme: Theme = "system"
    camera: tuple[Vector, Vector, Vector] | None = None
    view_angle: float = 30.0
    parallel_scale: float | None = None
