"""The OpenGL surface: renders VTK only when something changed, else shows the last frame again."""

from __future__ import annotations

import time

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget
from pyvistaqt.rwi import QVTKRenderWindowInteractor
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkFloatArray
from vtkmodules.vtkRenderingCore import vtkRenderer


class Canvas(QVTKRenderWindowInteractor):  # type: ignore[misc]
    """Shows one VTK renderer; leaves mouse and keys to its parent.

    pyvistaqt's widget renders the whole scene whenever Qt repaints it, also when only
    something that lies over it changed. Here a repaint costs a copy of the last frame.

    Signals
    -------
    rendered(seconds)
        A frame is complete.
    resized()
        The last frame is gone.
    """

    rendered = Signal(float)
    resized = Signal()

    def __init__(self, renderer: vtkRenderer, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAcceptDrops(False)
        self.setMouseTracking(True)
        self._renderer = renderer
        self._stale = True
        self.window_ = self.GetRenderWindow()
        self.window_.SetMultiSamples(0)
        self.window_.AddRenderer(renderer)
        interactor = self.window_.GetInteractor()
        interactor.SetInteractorStyle(None)
        interactor.Initialize()  # one that is not enabled renders nothing

    def draw(self) -> None:
        """Ask for a new frame; several wishes before the next repaint make one frame."""
        self._stale = True
        self.update()

    def device_size(self) -> tuple[int, int]:
        """Width and height in device pixels."""
        scale = self.devicePixelRatioF()
        return max(1, round(self.width() * scale)), max(1, round(self.height() * scale))

    def aspect(self) -> float:
        """Width over height."""
        width, height = self.device_size()
        return width / height

    def read_depth(self, column: int, row: int, radius: int) -> tuple[int, int, float] | None:
        """The nearest drawn pixel around a place.

        Parameters
        ----------
        column, row : int
            Device pixels, row counted from below.
        radius : int

        Returns
        -------
        (column, row, depth) or None
            Depth between 0 and 1; None where nothing is drawn.
        """
        width, height = self.device_size()
        left, right = max(column - radius, 0), min(column + radius, width - 1)
        low, high = max(row - radius, 0), min(row + radius, height - 1)
        if left > right or low > high:
            return None
        self.window_.MakeCurrent()
        read = vtkFloatArray()
        self.window_.GetZbufferData(left, low, right, high, read)
        depths = vtk_to_numpy(read).reshape(high - low + 1, right - left + 1)
        rows, columns = np.nonzero(depths < 1.0)
        if len(rows) == 0:
            return None
        nearest = int(np.hypot(rows + low - row, columns + left - column).argmin())
        i, j = int(rows[nearest]), int(columns[nearest])
        return left + j, low + i, float(depths[i, j])

    def paintGL(self) -> None:  # noqa: N802
        """Render if there is something new; copy the frame to the screen."""
        stale, self._stale = self._stale, False
        # The base class renders unless it believes to be in the middle of a paint.
        self._in_paint = not stale
        start = time.perf_counter()
        try:
            super().paintGL()
        finally:
            self._in_paint = False
        if stale and self.window_ is not None and self.window_.GetReadyForRendering():
            self.window_.WaitForCompletion()
            self.rendered.emit(time.perf_counter() - start)

    def resizeGL(self, w: int, h: int) -> None:  # noqa: N802
        """Take over a new size or scale of the screen."""
        super().resizeGL(w, h)
        self._stale = True
        self.resized.emit()

    def release(self) -> None:
        """Give back everything of the graphics card; the widget shows nothing afterwards."""
        if self.window_ is None:
            return
        self.window_.RemoveRenderer(self._renderer)
        self.close()
        # The signals of Qt may keep this widget a while longer, but not VTK's window.
        self.window_ = self._RenderWindow = self._Iren = None

    # VTK's own mouse and key handling would move the camera behind our back.

    def _leave_to_parent(self, event) -> None:  # type: ignore[no-untyped-def]
        event.ignore()

    mousePressEvent = mouseReleaseEvent = mouseMoveEvent = _leave_to_parent  # noqa: N815
    mouseDoubleClickEvent = wheelEvent = _leave_to_parent  # noqa: N815
    keyPressEvent = keyReleaseEvent = _leave_to_parent  # noqa: N815
    enterEvent = leaveEvent = _leave_to_parent  # noqa: N815
