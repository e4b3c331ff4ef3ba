"""Selections as expressions that are stored with what they made and can be evaluated again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import msgspec
import numpy as np

from app.core.arrays import Bools, Floats
from app.core.screen import View, select_in_lasso
from app.model.points import PointSet

LassoMode = Literal["visible", "through"]


class Lasso(msgspec.Struct, frozen=True, tag=True):
    """Points inside a freehand contour, seen from a view.

    `polygon` holds fractions of the viewport (0 to 1, y down); `tolerance` is the
    depth in metres within which a point counts as visible.
    """

    view: View
    polygon: tuple[tuple[float, float], ...]
    mode: LassoMode
    tolerance: float


class FieldRange(msgspec.Struct, frozen=True, tag=True):
    """Points whose field lies within closed limits; NaN never does."""

    field: str
    low: float
    high: float


class Explicit(msgspec.Struct, frozen=True, tag=True):
    """Points named one by one, by picking or by another program's labels."""

    points: PointSet


class Complement(msgspec.Struct, frozen=True, tag=True):
    """All points that are not deleted and not in the other selection."""

    of: Selection


class Union(msgspec.Struct, frozen=True, tag=True):
    """Points of any of the selections."""

    of: tuple[Selection, ...]


class Difference(msgspec.Struct, frozen=True, tag=True):
    """Points of the first selection that are not in the second."""

    of: Selection
    less: Selection


class Intersection(msgspec.Struct, frozen=True, tag=True):
    """Points that all of the selections hold: angles and intensities brushed in a plot."""

    of: tuple[Selection, ...]


Selection = Lasso | FieldRange | Explicit | Complement | Union | Difference | Intersection
ReadField = Callable[[str], Floats]


def evaluate(selection: Selection, xyz: Floats, allowed: Bools, read_field: ReadField) -> PointSet:
    """Find the points that an expression means.

    Parameters
    ----------
    selection : Selection
    xyz : (n, 3) float64 array
    allowed : (n,) bool array
        Points that may be selected: finite and not deleted.
    read_field : callable
        Gives a field by name as (n,) values; asked only by `FieldRange`.
    """
    match selection:
        case Lasso():
            found = select_in_lasso(
                xyz,
                allowed,
                selection.view,
                np.array(selection.polygon),
                selection.mode,
                selection.tolerance,
            )
            return PointSet(found.indices)
        case FieldRange():
            values = read_field(selection.field)
            inside = (values >= selection.low) & (values <= selection.high)
            return PointSet.from_mask(inside & allowed)
        case Explicit():
            return PointSet(selection.points.indices[allowed[selection.points.indices]])
        case Complement():
            inner = evaluate(selection.of, xyz, allowed, read_field)
            return PointSet.from_mask(allowed & ~inner.mask(len(xyz)))
        case Difference():
            kept = evaluate(selection.of, xyz, allowed, read_field)
            return kept - evaluate(selection.less, xyz, allowed, read_field)
        case Union():
            parts = [evaluate(part, xyz, allowed, read_field).indices for part in selection.of]
            return PointSet(np.concatenate(parts) if parts else ())
        case Intersection():
            shared = allowed.copy()  # of nothing: no condition, so everything
            for part in selection.of:
                shared &= evaluate(part, xyz, allowed, read_field).mask(len(xyz))
            return PointSet.from_mask(shared)
