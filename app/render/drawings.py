"""What is drawn over the points of a stage: footprints, marks, seeds and the mesh of a leaf."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkRenderer

from app.core.arrays import Floats, Ints
from app.render.mesh_actor import MeshActor
from app.render.palettes import Background
from app.render.ring_actor import MARKS, RingActor

Triangles = tuple[Floats, Ints, Floats]
"""Corners (v, 3) in world metres, faces (f, 3), angle of incidence of each face in degrees."""


class Drawings:
    """Actors beside those of the clouds; the stage fits its clipping to them."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._origin: Floats = np.zeros(3)
        self._rings, self._marks, self._mesh = RingActor(), RingActor(MARKS), MeshActor()
        self._seeds = RingActor(MARKS)
        self._all = (self._rings, self._marks, self._seeds, self._mesh)

    def show_rings(self, corners: Floats | None) -> None:
        """Draw closed lines, (k, n, 3) world metres; None takes them away."""
        self._rings.show(corners)
        self._follow(self._rings)

    def show_marks(self, corners: Floats | None) -> None:
        """Draw closed lines of another colour, which point something out."""
        self._marks.show(corners)
        self._follow(self._marks)

    def show_seeds(self, corners: Floats | None) -> None:
        """Draw closed lines around seeds of leaves."""
        self._seeds.show(corners)
        self._follow(self._seeds)

    def show_mesh(self, triangles: Triangles | None) -> None:
        """Draw triangles, coloured by their angle; None takes them away."""
        none: Triangles = (np.empty((0, 3)), np.empty((0, 3), np.int64), np.empty(0))
        self._mesh.show(*(none if triangles is None else triangles))
        self._follow(self._mesh)

    def place(self, origin: Floats) -> None:
        """Follow the origin of the stage."""
        self._origin = origin
        for one in self._all:
            one.place(origin)

    def style(self, background: Background, scale: float) -> None:
        """Colours for a ground, widths for device pixels."""
        for one in self._all:
            one.style(background, scale)

    def bounds(self) -> list[Floats | None]:
        """Corners (2, 3) around each, world metres; None where there is nothing."""
        return [one.bounds() for one in self._all]

    def clear(self) -> None:
        """Take everything away."""
        self.show_rings(None)
        self.show_marks(None)
        self.show_seeds(None)
        self.show_mesh(None)

    def _follow(self, one: RingActor | MeshActor) -> None:
        one.place(self._origin)
        if one.bounds() is not None:
            self._renderer.AddActor(one.actor)  # a second time changes nothing
        else:
            self._renderer.RemoveActor(one.actor)
            one.actor.ReleaseGraphicsResources(self._renderer.GetRenderWindow())
