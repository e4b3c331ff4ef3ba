"""Triangles in the picture, each in the colour of a value, as one actor."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonDataModel import vtkCellArray

from app.core.arrays import Floats, Ints
from app.render.local_actor import FORWARD, LocalActor
from app.render.palettes import Background, colours

PALETTE, HIGHEST = "viridis", 90.0
"""Colours of the angles of incidence, from 0 to so many degrees."""
EDGE, EDGE_OPACITY = (0.05, 0.05, 0.05), 0.3
EDGE_WIDTH = 0.5


class MeshActor(LocalActor):
    """Triangles; empty until some are given."""

    def __init__(self) -> None:
        super().__init__()
        self._mapper.SetScalarModeToUseCellData()
        self._mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, FORWARD)
        look = self.actor.GetProperty()
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
        if vertices is None or len(faces) == 0:
            self._clear()
            return
        self._take_points(vertices)
        cells = vtkCellArray()
        ends = np.arange(len(faces) + 1, dtype=np.int64) * 3
        cells.SetData(
            numpy_to_vtkIdTypeArray(ends, deep=True),
            numpy_to_vtkIdTypeArray(np.ascontiguousarray(faces, np.int64).ravel(), deep=True),
        )
        self._data.SetPolys(cells)
        table = colours(omega, 0.0, HIGHEST, PALETTE)
        self._data.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(table), deep=True))
        self._data.Modified()

    def style(self, _: Background, scale: float) -> None:
        """Width of the edges for device pixels; they look alike on every ground."""
        self.actor.GetProperty().SetLineWidth(EDGE_WIDTH * scale)
