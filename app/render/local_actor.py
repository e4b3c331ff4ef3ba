"""An actor whose points lie about an origin of their own, near the viewer's side of surfaces."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLPolyDataMapper

from app.core.arrays import Floats

FORWARD = -40.0
"""Steps of the depth buffer towards the viewer: noise of the points would hide half of a line."""


class LocalActor:
    """Shapes that are not lit and not picked; empty until some points are given."""

    def __init__(self) -> None:
        self._data = vtkPolyData()
        self._origin: Floats = np.zeros(3)
        self._box: Floats | None = None
        self._mapper = vtkOpenGLPolyDataMapper()
        self._mapper.SetInputData(self._data)
        self._mapper.SetVBOShiftScaleMethod(0)  # the coordinates are local already
        self._mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self.actor = vtkActor()
        self.actor.SetMapper(self._mapper)
        self.actor.PickableOff()
        self.actor.VisibilityOff()
        self.actor.GetProperty().LightingOff()

    def place(self, stage_origin: Floats) -> None:
        """Put the shapes where they belong, seen from the origin of the stage."""
        self.actor.SetPosition(*(self._origin - stage_origin))

    def bounds(self) -> Floats | None:
        """Corners (2, 3) around the shapes, world metres; None without any."""
        return self._box

    def _clear(self) -> None:
        self.actor.VisibilityOff()
        self._data.Initialize()
        self._box = None

    def _take_points(self, corners: Floats) -> None:
        """Take (k, 3) points, world metres, as those of all shapes."""
        self.actor.VisibilityOn()
        self._box = np.stack((corners.min(axis=0), corners.max(axis=0)))
        self._origin = np.round(self._box.mean(axis=0))
        points = vtkPoints()
        points.SetData(numpy_to_vtk((corners - self._origin).astype(np.float32), deep=True))
        self._data.SetPoints(points)
