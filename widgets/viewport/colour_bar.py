"""The colour bar beside the picture: title, unit, histogram, and handles for the limits."""

from __future__ import annotations

from typing import Literal

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.core.arrays import AnyArray, Floats
from app.model.scene import ColourBar
from app.render.legend import ANSWERS, INK, title_of
from app.render.palettes import Background, colour_table, is_categorical, table_rows
from app.render.ticks import label_ticks, round_ticks
from widgets.viewport.histogram import Histogram, count_values
from widgets.viewport.overlay import PANELS

Handle = Literal["low", "high"]
WIDE, NARROW = 9.5, 5.0
"""Widths in heights of the font."""
BREAK = "\u200b"
SMALLEST_SPAN = 0.005  # of the scale: the handles never cross


class ColourBarWidget(QWidget):
    """Says what the colours mean; its handles move the limits.

    Signals
    -------
    limits_changed(low, high, finished)
        `finished` is False while a handle is dragged.
    """

    limits_changed = Signal(float, float, bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bar: ColourBar | None = None
        self._low, self._high = 0.0, 1.0
        self._histogram = Histogram.empty()
        self._background: Background = "light"
        self._held: Handle | None = None
        self._narrow = False
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
        self.setAccessibleName(self.tr("Colour scale"))
        self.setToolTip(self.tr("Drag the handles to change the limits; arrow keys move the upper "
                                "one, with Shift the lower one."))  # fmt: skip
        self.hide()

    @property
    def limits(self) -> tuple[float, float]:
        """The limits that the handles show."""
        return self._low, self._high

    def show_bar(self, bar: ColourBar | None, values: AnyArray | None) -> None:
        """Show what colours mean; None hides the widget. `values` may hold NaN."""
        self._bar = bar
        self.setVisible(bar is not None)
        if bar is None:
            return
        if self._held is None:
            self._low, self._high = bar.low, bar.high
        if values is not None:
            self._histogram = count_values(values, bar.low, bar.high)
        limits = f"{self._low:.4g} – {self._high:.4g}"
        self.setAccessibleDescription(f"{title_of(bar)}: {limits}")
        self.update()

    def set_background(self, background: Background) -> None:
        """Choose ink and panel for a light or dark picture."""
        self._background = background
        self.update()

    def set_narrow(self, narrow: bool) -> None:
        """Leave the histogram out, so that a small picture keeps its room."""
        self._narrow = narrow
        self.update()

    @property
    def narrow(self) -> bool:
        """Whether the histogram is left out."""
        return self._narrow

    def sizeHint(self) -> QSize:  # noqa: N802
        """Wide enough for a title line, as high as the parent gives."""
        em = QFontMetricsF(self.font()).height()
        return QSize(round((NARROW if self._narrow else WIDE) * em), round(22 * em))

    # Geometry

    def scale_rect(self) -> QRectF:
        """Where the coloured strip is, in logical pixels."""
        em = QFontMetricsF(self.font()).height()
        top = 0.8 * em + self._title_height() + 0.9 * em
        return QRectF(
            (0.9 if self._narrow else 4.0) * em, top, 0.9 * em, self.height() - top - 1.2 * em
        )

    def position_of(self, value: float) -> float:
        """Height y of a value in logical pixels."""
        low, high = self._scale()
        strip = self.scale_rect()
        return float(strip.bottom() - (value - low) / (high - low) * strip.height())

    def _scale(self) -> tuple[float, float]:
        low = min(self._histogram.low, self._low)
        high = max(self._histogram.high, self._high)
        return (low, high) if high > low else (low - 0.5, low + 0.5)

    def _value_at(self, y: float) -> float:
        low, high = self._scale()
        strip = self.scale_rect()
        return float(low + (strip.bottom() - y) / max(strip.height(), 1.0) * (high - low))

    def _adjustable(self) -> bool:
        return self._bar is not None and not (
            self._bar.kind in ANSWERS or is_categorical(self._bar.map)
        )

    def _title_height(self) -> float:
        width = self.width() - QFontMetricsF(self.font()).height()
        room = QRectF(0, 0, width, 1000)
        flags = Qt.AlignmentFlag.AlignLeft | self._wrapping
        return QFontMetricsF(self.font()).boundingRect(room, flags, self._title()).height()

    @property
    def _wrapping(self) -> Qt.TextFlag:
        room = self.width() - QFontMetricsF(self.font()).height()
        words = self._title().replace(BREAK, " ").split()
        if all(QFontMetricsF(self.font()).horizontalAdvance(word) <= room for word in words):
            return Qt.TextFlag.TextWordWrap
        return Qt.TextFlag.TextWrapAnywhere

    def _title(self) -> str:
        """Names of fields are long words: they may break behind an underscore."""
        return title_of(self._bar).replace("_", "_" + BREAK) if self._bar is not None else ""

    # Handles

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Take the nearer handle."""
        if event.button() != Qt.MouseButton.LeftButton or not self._adjustable():
            return
        y = event.position().y()
        to_low = abs(y - self.position_of(self._low))
        to_high = abs(y - self.position_of(self._high))
        self._held = "low" if to_low < to_high else "high"

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Drag the handle."""
        self.setCursor(
            Qt.CursorShape.SizeVerCursor if self._adjustable() else Qt.CursorShape.ArrowCursor
        )
        if self._held is not None:
            self._move(self._held, self._value_at(event.position().y()), False)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Let go of the handle."""
        if self._held is not None:
            held, self._held = self._held, None
            self._move(held, self._value_at(event.position().y()), True)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Move a handle by a hundredth of the scale."""
        steps = {Qt.Key.Key_Up: 1, Qt.Key.Key_Down: -1}
        step = steps.get(Qt.Key(event.key()))
        if step is None or not self._adjustable():
            super().keyPressEvent(event)
            return
        low, high = self._scale()
        by = step * (high - low) / 100
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self._move("low", self._low + by, True)
        else:
            self._move("high", self._high + by, True)

    def _move(self, handle: Handle, value: float, finished: bool) -> None:
        low, high = self._scale()
        gap = SMALLEST_SPAN * (high - low)
        if handle == "low":
            self._low = float(np.clip(value, low, self._high - gap))
        else:
            self._high = float(np.clip(value, self._low + gap, high))
        self.update()
        self.limits_changed.emit(self._low, self._high, finished)

    # Paint

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Paint everything."""
        if self._bar is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        ink = QColor(INK[self._background])
        em = QFontMetricsF(self.font()).height()
        panel = QPainterPath()
        panel.addRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 8, 8)
        painter.fillPath(panel, PANELS[self._background])
        painter.setPen(ink)
        room = QRectF(0.5 * em, 0.7 * em, self.width() - em, self._title_height() + 2)
        painter.drawText(room, self._wrapping, self._title())
        if self._bar.kind in ANSWERS:
            self._paint_answers(painter, self._bar, ink)
        elif is_categorical(self._bar.map):
            self._paint_colours(painter, colour_table(self._bar.map)[1:9])
        else:
            self._paint_scale(painter, self._bar, ink)
        painter.end()

    def _paint_scale(self, painter: QPainter, bar: ColourBar, ink: QColor) -> None:
        low, high = self._scale()
        strip = self.scale_rect()
        where = np.linspace(high, low, max(2, round(strip.height() * self.devicePixelRatioF())))
        rows = table_rows(where, self._low, self._high, False)
        colours = colour_table(bar.map)[rows]
        if not self._narrow:
            self._paint_histogram(painter, strip, bar)
        _draw_column(painter, strip, colours)
        faint = QColor(ink)
        faint.setAlpha(110)
        em = QFontMetricsF(self.font()).height()
        ticks = round_ticks(low, high, max(2, int(strip.height() / (2.2 * em))))
        for value, text in zip(ticks, label_ticks(ticks), strict=True):
            y = self.position_of(value)
            painter.setPen(faint)
            painter.drawLine(QPointF(strip.right() + 1, y), QPointF(strip.right() + 5, y))
            painter.setPen(ink)
            painter.drawText(QPointF(strip.right() + 0.9 * em, y + 0.32 * em), text)
        for value in (self._low, self._high):
            _draw_handle(painter, strip, self.position_of(value), ink, em)

    def _paint_histogram(self, painter: QPainter, strip: QRectF, bar: ColourBar) -> None:
        heights, edges = self._histogram.heights, self._histogram.edges
        if not len(heights):
            return
        middles: Floats = (edges[:-1] + edges[1:]) / 2
        colours = colour_table(bar.map)[table_rows(middles, self._low, self._high, False)]
        room = strip.left() - 8
        painter.setPen(Qt.PenStyle.NoPen)
        for height, bottom, top, colour in zip(
            heights, edges[:-1], edges[1:], colours, strict=True
        ):
            y, end = self.position_of(float(top)), self.position_of(float(bottom))
            wide = float(height) * room
            painter.setBrush(QColor(int(colour[0]), int(colour[1]), int(colour[2]), 190))
            painter.drawRect(QRectF(strip.left() - 2 - wide, y, wide, end - y + 0.4))

    def _paint_answers(self, painter: QPainter, bar: ColourBar, ink: QColor) -> None:
        em = QFontMetricsF(self.font()).height()
        table, top = colour_table(bar.map), self.scale_rect().top()
        for i, (row, text) in enumerate(ANSWERS[bar.kind]):
            box = QRectF(0.7 * em, top + 1.7 * em * i, em, em)
            painter.fillRect(box, QColor(*(int(part) for part in table[row])))
            painter.setPen(ink)
            place = QPointF(box.right() + 0.6 * em, box.bottom() - 0.2 * em)
            painter.drawText(place, self.tr(text))

    def _paint_colours(self, painter: QPainter, colours: AnyArray) -> None:
        em = QFontMetricsF(self.font()).height()
        top = self.scale_rect().top()
        for i, colour in enumerate(colours):
            box = QRectF((0.7 + 1.9 * (i % 4)) * em, top + 1.6 * em * (i // 4), 1.4 * em, em)
            painter.fillRect(box, QColor(*(int(part) for part in colour)))


def _draw_column(painter: QPainter, strip: QRectF, colours: AnyArray) -> None:
    column = np.ascontiguousarray(colours[:, None, :])
    height = len(column)
    image = QImage(column.data, 1, height, 4, QImage.Format.Format_RGBA8888)
    painter.drawImage(strip, image)


def _draw_handle(painter: QPainter, strip: QRectF, y: float, ink: QColor, em: float) -> None:
    left, right, half = strip.left() - 3, strip.right() + 3, 0.36 * em
    painter.setPen(QPen(ink, 1.6))
    painter.drawLine(QPointF(left, y), QPointF(right, y))
    painter.setPen(QPen(QColor(255, 255, 255), 1.0))
    painter.setBrush(ink)
    tip = QPolygonF([QPointF(left + 4, y), QPointF(left - half, y - half),
                     QPointF(left - half, y + half)])  # fmt: skip
    painter.drawPolygon(tip)
