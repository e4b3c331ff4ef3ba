"""The kinds of parts there are: one line each."""

from __future__ import annotations

from typing import get_args

from app.simulate.parts.branch import BranchPart
from app.simulate.parts.crown import CrownPart
from app.simulate.parts.goniometer import GoniometerPart
from app.simulate.parts.leaf import LeafPart
from app.simulate.parts.leaf_frame import LeafFramePart
from app.simulate.parts.leaf_row import LeafRowPart
from app.simulate.parts.needle_row import NeedleRowPart
from app.simulate.parts.panel import PanelPart
from app.simulate.parts.panel_set import PanelSetPart
from app.simulate.parts.part import Part
from app.simulate.parts.pear_row import PearRowPart
from app.simulate.parts.scatter import ScatterPart
from app.simulate.parts.shoot import ShootPart
from app.simulate.parts.stem import StemPart
from app.simulate.parts.wall import WallPart

AnyPart = (
    BranchPart
    | CrownPart
    | GoniometerPart
    | LeafFramePart
    | LeafPart
    | LeafRowPart
    | NeedleRowPart
    | PanelPart
    | PanelSetPart
    | PearRowPart
    | ScatterPart
    | ShootPart
    | StemPart
    | WallPart
)
KINDS: dict[str, type[Part]] = {str(kind.__struct_config__.tag): kind for kind in get_args(AnyPart)}
