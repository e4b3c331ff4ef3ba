"""Closed lines in the picture: the borders of footprints, as one actor."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLPolyDataMapper

from app.core.arrays import Floats
from app.render.palettes import Background

COLOURS: dict[Background, tuple[float, float, float]] = {
    "light": (0.72, 0.11, 0.36),
    "dark": (1.0, 0.72, 0.30),
}
MARKS: dict[Background, tuple[float, float, float]] = {
    "light": (0.05, 0.25, 0.80),
    "dark": (0.45, 0.85, 1.0),
}
WIDTH = 1.4
FORWARD = -40.0
"""Steps of the depth buffer towards the viewer: noise of the points would hide half of a line."""


class RingActor:
    """Lines that close; empty until some are given."""

    def __init__(self, colours: Mapping[Background, tuple[float, float, float]] = COLOURS) -> None:
        self._colours = colours
        self._data = vtkPolyData()
        self._origin: Floats = np.zeros(3)
        self._box: Floats | None = None
        mapper = vtkOpenGLPolyDataMapper()
        mapper.SetInputData(self._data)
        mapper.ScalarVisibilityOff()
        mapper.SetVBOShiftScaleMethod(0)  # the coordinates are local already
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, FORWARD)
        self.actor = vtkActor()
        self.actor.SetMapper(mapper)
        self.actor.PickableOff()
        self.actor.VisibilityOff()
        self.actor.GetProperty().LightingOff()

    def show(self, corners: Floats | None) -> None:
        """Take other lines.

        Parameters
        ----------
        corners : (k, n, 3) array or None
            World metres, finite; None or an empty one shows nothing.
        """
        there = corners is not None and len(corners) > 0
        self.actor.SetVisibility(there)
        if corners is None or not there:
            self._data.Initialize()
            self._box = None
            return
        flat = corners.reshape(-1, 3)
        self._box = np.stack((flat.min(axis=0), flat.max(axis=0)))
        self._origin = np.round(self._box.mean(axis=0))
        points = vtkPoints()
        points.SetData(numpy_to_vtk((flat - self._origin).astype(np.float32), deep=True))
        self._data.SetPoints(points)
        self._data.SetLines(_close(len(corners), corners.shape[1]))
        self._data.Modified()

    def place(self, stage_origin: Floats) -> None:
        """Put the lines where they belong, seen from the origin of the stage."""
        self.actor.SetPosition(*(self._origin - stage_origin))

    def style(self, background: Background, scale: float) -> None:
        """Colour for a ground, width for device pixels."""
        look = self.actor.GetProperty()
        look.SetColor(*self._colours[background])
        look.SetLineWidth(WIDTH * scale)

    def bounds(self) -> Floats | None:
        """Corners (2, 3) around the lines, world metres; None without any."""
        return self._box


def _close(count: int, corners: int) -> vtkCellArray:
    """Lines of so many corners, each with its first corner again at the end."""
    rows = np.arange(count * corners, dtype=np.int64).reshape(count, corners)
    closed = np.concatenate([rows, rows[:, :1]], axis=1).ravel()
    ends = np.arange(count + 1, dtype=np.int64) * (corners + 1)
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(ends, deep=True), numpy_to_vtkIdTypeArray(closed, deep=True)
    )
    return cells
