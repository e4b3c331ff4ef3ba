"""Where the picture gets its arrays from."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.model.fields import Values
from app.model.project import Project
from app.model.view_state import ViewState
from app.render.overlay import LeafMark, Overlay
from app.render.palettes import colour_table


class PictureSource(Protocol):
    """Gives the arrays that a scene names; asked only for what differs."""

    def xyz(self, scan: str) -> Floats:
        """World coordinates, (n, 3)."""

    def alive(self, scan: str) -> Bools:
        """Points that are drawn, (n,)."""

    def values(self, scan: str, field: str) -> Values | None:
        """Values of a field as far as they are known."""

    def overlay(self, scan: str) -> Overlay:
        """What lies over the colours."""


class ProjectSource:
    """Reads a project as one view state wants to see it; computes nothing."""

    def __init__(self, project: Project, view: ViewState) -> None:
        self.project = project
        self.view = view

    def xyz(self, scan: str) -> Floats:
        """World coordinates, (n, 3)."""
        return self.project.state.scan(scan).scan.xyz

    def alive(self, scan: str) -> Bools:
        """Points that are drawn, (n,)."""
        return self.project.state.scan(scan).alive

    def values(self, scan: str, field: str) -> Values | None:
        """Values of a field as far as they are known."""
        return self.project.known_field(scan, field)

    def overlay(self, scan: str) -> Overlay:
        """Selection, leaves, previews and ghosts, as far as the view wants to see them."""
        state = self.project.state.scan(scan)
        leaves = self.project.state.leaves_of(scan) if self.view.show_leaves else ()
        shown = [(leaf.key, leaf.members) for leaf in leaves]
        shown += [(one.leaf, one.members) for one in self.view.previewed if one.scan == scan]
        return Overlay(
            selection=state.selection.indices,
            leaves=[LeafMark(key, points.indices, leaf_colour(key)) for key, points in shown],
            ghosts=state.marks if self.view.show_ghosts else None,
            current=self.view.leaf,
        )


def leaf_colour(key: str) -> tuple[int, int, int]:
    """Colour of a leaf in the picture and in tables: the same as in the field ``leaf``."""
    number = int(key.rpartition("-")[2])
    red, green, blue, _ = colour_table("leaves")[number % 256]
    return int(red), int(green), int(blue)


def known_values(values: Values | None) -> AnyArray | None:
    """Values with NaN where they were not computed yet; None when there are none at all."""
    if values is None or values.complete:
        return values.values if values is not None else None
    return np.where(values.have, values.values, np.nan)
