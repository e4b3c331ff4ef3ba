"""The strip under the scan image: what is under the mouse, what no return looks like, zoom."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QColor, QPixmap, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget

from app.render.palettes import Background
from app.render.scan_image.paint import SILENT
from widgets.common.scan_image.line import Line
from widgets.icons import draw_icon

NARROW = 30
"""Width in heights of the font below which the line needs the room of the legend."""


class Foot(QWidget):
    """One line of text with a small legend and three buttons.

    Signals
    -------
    zoomed(steps)
    fitted()
    """

    zoomed = Signal(int)
    fitted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._silence = False
        self.line = Line(self.tr("Under the mouse"), self)
        self.swatch = QLabel(self)
        self.legend = QLabel(self.tr("no return"), self)
        self.legend.setToolTip(self.tr("Beams of which the file records that nothing came back"))
        self.swatch.setToolTip(self.legend.toolTip())
        self.larger = self._button(self.tr("Zoom in"), self.tr("Zoom in (+, wheel)"))
        self.smaller = self._button(self.tr("Zoom out"), self.tr("Zoom out (−, wheel)"))
        self.whole = self._button(
            self.tr("Show all"), self.tr("Show all of the picture (0, double click)")
        )
        row = QHBoxLayout(self)
        em = self.fontMetrics().height()
        row.setContentsMargins(em // 2, 0, em // 4, 0)
        row.setSpacing(em // 3)
        row.addWidget(self.line, 1)
        for widget in (self.swatch, self.legend, self.smaller, self.larger, self.whole):
            row.addWidget(widget)
        self.larger.clicked.connect(self._zoom_in)
        self.smaller.clicked.connect(self._zoom_out)
        self.whole.clicked.connect(self.fitted)
        self.explain_silence(False)

    def explain_silence(self, there: bool) -> None:
        """Show what beams without a return look like, if there are some."""
        self._silence = there
        self.swatch.setVisible(there)
        self._make_room()

    def recolour(self, background: Background) -> None:
        """Follow the theme."""
        side = round(0.8 * self.fontMetrics().height())
        patch = QPixmap(side, side)
        patch.fill(QColor(*SILENT[background]))
        self.swatch.setPixmap(patch)
        self.larger.setIcon(draw_icon("ph.magnifying-glass-plus"))
        self.smaller.setIcon(draw_icon("ph.magnifying-glass-minus"))
        self.whole.setIcon(draw_icon("ph.corners-out"))

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Leave the words of the legend to its tooltip where there is little room."""
        super().resizeEvent(event)
        self._make_room()

    def _make_room(self) -> None:
        roomy = self.width() >= NARROW * self.fontMetrics().height()
        self.legend.setVisible(self._silence and roomy)

    def _button(self, name: str, tip: str) -> QToolButton:
        button = QToolButton(self)
        button.setAutoRaise(True)
        button.setText(name)
        button.setAccessibleName(name)
        button.setToolTip(tip)
        return button

    def _zoom_in(self) -> None:
        self.zoomed.emit(1)

    def _zoom_out(self) -> None:
        self.zoomed.emit(-1)
