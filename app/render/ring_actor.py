"""Closed lines in the picture: the borders of footprints, as one actor."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonDataModel import vtkCellArray

from app.core.arrays import Floats
from app.render.local_actor import FORWARD, LocalActor
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


class RingActor(LocalActor):
    """Lines that close; empty until some are given."""

    def __init__(self, colours: Mapping[Background, tuple[float, float, float]] = COLOURS) -> None:
        super().__init__()
        self._colours = colours
        self._mapper.ScalarVisibilityOff()
        self._mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, FORWARD)

    def show(self, corners: Floats | None) -> None:
        """Take other lines.

        Parameters
        ----------
        corners : (k, n, 3) array or None
            World metres, finite; None or an empty one shows nothing.
        """
        if corners is None or len(corners) == 0:
            self._clear()
            return
        self._take_points(corners.reshape(-1, 3))
        self._data.SetLines(_close(len(corners), corners.shape[1]))
        self._data.Modified()

    def style(self, background: Background, scale: float) -> None:
        """Colour for a ground, width for device pixels."""
        look = self.actor.GetProperty()
        look.SetColor(*self._colours[background])
        look.SetLineWidth(WIDTH * scale)


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
