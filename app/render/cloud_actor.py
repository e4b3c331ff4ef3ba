"""One cloud on the graphics card: a few fixed actors, uploaded once."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLPolyDataMapper

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.render.lod import shuffle_points, split_blocks
from app.render.overlay import Overlay, number_marks
from app.render.shading import MARK, NO_VALUE, VALUE, Shading, connect_attributes, encode_values

SAMPLE = 8192


class CloudActor:
    """Points of one scan in blocks of a shuffled order.

    Parameters
    ----------
    xyz : (n, 3) float64 array
        World metres; rows that are not finite are never drawn.

    Attributes
    ----------
    origin : (3,) float64
        What was taken off before the coordinates were cut to float32.
    actors : tuple of vtkActor
        One per block, placed relative to the stage by `place`.
    """

    def __init__(self, xyz: Floats) -> None:
        self.size = len(xyz)
        self.shading = Shading()
        self.order = shuffle_points(self.size)
        self.blocks = split_blocks(self.size)
        self.origin = _choose_origin(xyz[self.order[: self.blocks[0][1]]] if self.blocks else xyz)
        parts = (xyz.take(self._rows(i), axis=0) for i in range(len(self.blocks)))
        self._data = tuple(_make_block(part - self.origin) for part in parts)
        self.actors = tuple(_make_actor(data, self.shading) for data in self._data)
        self._box = self._measure()

    def set_mask(self, alive: Bools) -> None:
        """Choose the points that are drawn; only lists of row numbers are sent again."""
        for i, data in enumerate(self._data):
            data.SetVerts(_vertices(np.flatnonzero(alive.take(self._rows(i)))))
        self._box = self._measure()

    def set_values(self, values: AnyArray | None) -> None:
        """Give each point its value; None for plain points. Points are not touched."""
        for i, data in enumerate(self._data):
            rows = self._rows(i)
            coded = (
                np.full(len(rows), NO_VALUE) if values is None else encode_values(values.take(rows))
            )
            _put(data, VALUE, coded)

    def set_overlay(self, overlay: Overlay) -> None:
        """Lay selection, leaves and ghosts over the colours."""
        codes, table = number_marks(overlay, self.size)
        self.shading.set_marks(table)
        for i, data in enumerate(self._data):
            _put(data, MARK, codes.take(self._rows(i)).astype(np.float32))

    def place(self, stage_origin: Floats) -> None:
        """Put the cloud where it belongs, seen from the origin of the stage."""
        for actor in self.actors:
            actor.SetPosition(*(self.origin - stage_origin))

    def show_blocks(self, start: int, stop: int) -> int:
        """Draw these blocks only; return how many points that is."""
        drawn = 0
        for i, (actor, data) in enumerate(zip(self.actors, self._data, strict=True)):
            actor.SetVisibility(start <= i < stop)
            if start <= i < stop:
                drawn += data.GetVerts().GetNumberOfConnectivityIds()
        return drawn

    def bounds(self) -> Floats | None:
        """Corners (2, 3) around the points that are drawn, world metres; None without any."""
        return self._box

    def _measure(self) -> Floats | None:
        # From the points that cells use: those that are deleted do not count.
        boxes = [_cell_bounds(data) for data in self._data if data.GetNumberOfVerts()]
        if not boxes:
            return None
        stacked = np.array(boxes)
        return np.stack((stacked[:, 0].min(axis=0), stacked[:, 1].max(axis=0))) + self.origin

    def sample(self) -> Floats:
        """Some thousand of the points that are drawn, in world metres, (k, 3)."""
        for data in self._data:
            if data.GetNumberOfVerts():
                return _used_points(data, SAMPLE) + self.origin
        return np.empty((0, 3))

    def _rows(self, block: int) -> Ints:
        # For `take`: it gathers five times faster than indexing does.
        start, stop = self.blocks[block]
        return self.order[start:stop]


def _choose_origin(sample: Floats) -> Floats:
    finite = sample[np.isfinite(sample).all(axis=1)]
    # Whole metres: nobody wonders about odd numbers in a stored view.
    return np.round(np.median(finite, axis=0)) if len(finite) else np.zeros(3)


def _make_block(local: Floats) -> vtkPolyData:
    # One infinite point breaks VTK's bounds, even when no cell uses it.
    local[~np.isfinite(local).all(axis=1)] = 0.0
    points = vtkPoints()
    points.SetData(numpy_to_vtk(local.astype(np.float32)))
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetVerts(_vertices(np.arange(len(local))))
    _put(data, VALUE, _no_values(len(local)))
    _put(data, MARK, np.zeros(len(local), np.float32))
    return data


def _make_actor(data: vtkPolyData, shading: Shading) -> vtkActor:
    mapper = vtkOpenGLPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    mapper.SetVBOShiftScaleMethod(0)  # the coordinates are local already
    connect_attributes(mapper)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.SetProperty(shading.property)
    actor.SetShaderProperty(shading.shader)
    actor.PickableOff()
    return actor


def _vertices(rows: Ints) -> vtkCellArray:
    """All points as one cell: a cell for each would cost sixteen bytes more a point."""
    cells = vtkCellArray()
    if len(rows):
        ends = np.array([0, len(rows)], np.int64)
        cells.SetData(numpy_to_vtkIdTypeArray(ends), numpy_to_vtkIdTypeArray(rows))
    return cells


def _put(data: vtkPolyData, name: str, values: AnyArray) -> None:
    array = numpy_to_vtk(np.ascontiguousarray(values))
    array.SetName(name)
    data.GetPointData().AddArray(array)


def _no_values(count: int) -> AnyArray:
    return np.full(count, NO_VALUE)


def _cell_bounds(data: vtkPolyData) -> Floats:
    box = [0.0] * 6
    data.GetCellsBounds(box)
    return np.array(box).reshape(3, 2).T


def _used_points(data: vtkPolyData, most: int) -> Floats:
    rows = vtk_to_numpy(data.GetVerts().GetConnectivityArray())[:most]
    points: Floats = vtk_to_numpy(data.GetPoints().GetData())[rows].astype(np.float64)
    return points
