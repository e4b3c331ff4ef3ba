"""Triangles in the picture, each in the colour of a value, as one actor."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLPolyDataMapper

from app.core.arrays import Floats, Ints
from app.render.palettes import Background, colours
from app.render.ring_actor import FORWARD

PALETTE, HIGHEST = "viridis", 90.0
"""Colours of the angles of incidence, from 0 to so many degrees."""
EDGE, EDGE_OPACITY = (0.05, 0.05, 0.05), 0.3
EDGE_WIDTH = 0.5


class MeshActor:
    """Triangles; empty until some are given."""

    def __init__(self) -> None:
        self._data = vtkPolyData()
        self._origin: Floats = np.zeros(3)
        self._box: Floats | None = None
        mapper = vtkOpenGLPolyDataMapper()
        mapper.SetInputData(self._data)
        mapper.SetScalarModeToUseCellData()
        mapper.SetVBOShiftScaleMethod(0)  # the coordinates are local already
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, FORWARD)
        self.actor = vtkActor()
        self.actor.SetMapper(mapper)
        self.actor.PickableOff()
        self.actor.VisibilityOff()
        look = self.actor.GetProperty()
        look.LightingOff()
        look.EdgeVisibilityOn()
        look.SetEdgeColor(*EDGE)
        look.SetEdgeOpacity(EDGE_OPACITY)

    def show(self, vertices: Floats | None, faces: Ints, omega: Floats) -> None:
        """Take other triangles.

        Parameters
        ----------
        vertices : (v, 3) array or None
            World metres, finite; None or an empty one shows nothing.
        faces : (f, 3) int64
        omega : (f,) degrees
        """
        there = vertices is not None and len(faces) > 0
        self.actor.SetVisibility(there)
        if vertices is None or not there:
            self._data.Initialize()
            self._box = None
            return
        self._box = np.stack((vertices.min(axis=0), vertices.max(axis=0)))
        self._origin = np.round(self._box.mean(axis=0))
        points = vtkPoints()
        points.SetData(numpy_to_vtk((vertices - self._origin).astype(np.float32), deep=True))
        cells = vtkCellArray()
        ends = np.arange(len(faces) + 1, dtype=np.int64) * 3
        cells.SetData(
            numpy_to_vtkIdTypeArray(ends, deep=True),
            numpy_to_vtkIdTypeArray(np.ascontiguousarray(faces, np.int64).ravel(), deep=True),
        )
        self._data.SetPoints(points)
        self._data.SetPolys(cells)
        table = colours(omega, 0.0, HIGHEST, PALETTE)
        self._data.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(table), deep=True))
        self._data.Modified()

    def place(self, stage_origin: Floats) -> None:
        """Put the triangles where they belong, seen from the origin of the stage."""
        self.actor.SetPosition(*(self._origin - stage_origin))

    def style(self, _: Background, scale: float) -> None:
        """Width of the edges for device pixels; they look alike on every ground."""
        self.actor.GetProperty().SetLineWidth(EDGE_WIDTH * scale)

    def bounds(self) -> Floats | None:
        """Corners (2, 3) around the triangles, world metres; None without any."""
        return self._box
