"""What lies over the picture: counts, axes, and the line that a tool is drawing."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from app.render.camera import Camera
from app.render.legend import INK
from app.render.palettes import Background
from widgets.viewport.tools.tool import Tool

AXES = (("x", QColor(213, 94, 0)), ("y", QColor(0, 158, 115)), ("z", QColor(0, 114, 178)))

PANELS: dict[Background, QColor] = {
    "light": QColor(255, 255, 255, 215),
    "dark": QColor(30, 34, 40, 215),
}


class OverlayWidget(QWidget):
    """Transparent for the mouse. Painting it copies the last frame; nothing is rendered."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.tool: Tool | None = None
        self._text = ""
        self._camera: Camera | None = None
        self._background: Background = "light"

    @property
    def text(self) -> str:
        """The line in the lower left corner."""
        return self._text

    def set_text(self, text: str) -> None:
        """Write a line into the lower left corner."""
        if text != self._text:
            self._text = text
            self.update()

    def set_camera(self, camera: Camera) -> None:
        """Turn the axes as the camera has turned."""
        self._camera = camera
        self.update()

    def set_background(self, background: Background) -> None:
        """Choose the ink."""
        self._background = background
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Paint counts, axes and the tool's line."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        ink = QColor(INK[self._background])
        em = QFontMetricsF(self.font()).height()
        if self._camera is not None:
            self._paint_axes(painter, self._camera, em)
        if self._text:
            width = QFontMetricsF(self.font()).horizontalAdvance(self._text)
            box = QRectF(em, self.height() - 2.4 * em, width + em, 1.6 * em)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(PANELS[self._background])
            painter.drawRoundedRect(box, 0.5 * em, 0.5 * em)
            painter.setPen(ink)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self._text)
        if self.tool is not None:
            self.tool.paint(painter, self.width(), self.height())
        painter.end()

    def _paint_axes(self, painter: QPainter, camera: Camera, em: float) -> None:
        right, up, forward = camera.axes()
        centre = QPointF(3.2 * em, self.height() - 5.8 * em)
        # Far axes first, so that the near ones lie over them.
        for i in sorted(range(3), key=lambda axis: -float(forward[axis])):
            name, colour = AXES[i]
            tip = centre + QPointF(float(right[i]), -float(up[i])) * 1.9 * em
            painter.setPen(QPen(colour, 2.4, c=Qt.PenCapStyle.RoundCap))
            painter.drawLine(centre, tip)
            label = centre + QPointF(float(right[i]), -float(up[i])) * 2.5 * em
            box = QRectF(label.x() - em, label.y() - em, 2 * em, 2 * em)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, name)
