"""A strip of colours with words below: what the colours of a map mean."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QLinearGradient, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.render.palettes import colour_table

STOPS = 33


class ColourStrip(QWidget):
    """Colours from the low to the high limit; three texts name both ends and the middle."""

    def __init__(self, palette: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._table = colour_table(palette)
        self._texts = ("", "", "")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def show_texts(self, low: str, middle: str, high: str) -> None:
        """Name the ends and the middle."""
        self._texts = (low, middle, high)
        self.setAccessibleName(", ".join(self._texts))
        self.update()

    def sizeHint(self) -> QSize:  # noqa: N802
        """As high as the strip with a line of text."""
        line = self.fontMetrics().height()
        return QSize(20 * line, 2 * line)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """As `sizeHint`, but narrow."""
        return QSize(self.sizeHint().width() // 2, self.sizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Draw the strip and its texts."""
        painter = QPainter(self)
        line = float(self.fontMetrics().height())
        gradient = QLinearGradient(0.0, 0.0, float(self.width()), 0.0)
        for i in range(STOPS):
            share = i / (STOPS - 1)
            r, g, b, _ = (int(c) for c in self._table[round(share * 255)])
            gradient.setColorAt(share, QColor(r, g, b))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(gradient)
        painter.drawRoundedRect(QRectF(0.0, 0.0, self.width(), 0.7 * line), 3.0, 3.0)
        painter.setPen(self.palette().color(QPalette.ColorRole.Text))
        below = QRectF(0.0, 0.85 * line, self.width(), 1.1 * line)
        flags = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter)
        for text, flag in zip(self._texts, (*flags, Qt.AlignmentFlag.AlignRight), strict=True):
            painter.drawText(below, int(flag | Qt.AlignmentFlag.AlignTop), text)
        painter.end()
