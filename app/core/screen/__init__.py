"""Selection on the screen: projection, lasso, visibility, picking; always on all points."""

from app.core.screen.lasso import lasso_mask, rasterise_polygon
from app.core.screen.picking import pick
from app.core.screen.projection import Projected, View, project
from app.core.screen.selection import LassoResult, choose_tolerance, select_in_lasso
from app.core.screen.visibility import visible_mask

__all__ = [
    "LassoResult",
    "Projected",
    "View",
    "choose_tolerance",
    "lasso_mask",
    "pick",
    "project",
    "rasterise_polygon",
    "select_in_lasso",
    "visible_mask",
]
