"""The picture itself: shows a part at a size, and tells what hands do to it."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QKeyEvent, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.core.arrays import AnyArray
from app.render.palettes import BACKGROUNDS
from app.render.scan_image.frame import Frame
from app.render.scan_image.image import ScanImage
from app.render.scan_image.paint import Paint, Part
from widgets.common.scan_image.hand import ZOOM_PER_NOTCH, Hand, PointingHand
from widgets.viewport.mouse import Mouse
from widgets.viewport.tools.lasso import Combine, Corner, Lasso
from widgets.viewport.tools.rectangle import Rectangle
from widgets.viewport.tools.tool import Tool

CRISP = 3.0
"""Screen pixels per pixel of the picture from which its edges are to be seen."""
STEP = 0.1
"""Share of the view by which an arrow key moves the picture."""
RING = QColor(236, 0, 140)


class ScanImageView(QWidget):
    """Shows a scan image with its paint; owns no facts but what part is seen.

    Signals
    -------
    hovered(row, column)
        The mouse is over a pixel of the picture; −1, −1 beside it.
    clicked(row, column)
    outlined(corners, combine)
        A contour was drawn: a list of (column, row), and how to combine it.
    tool_changed(name)
    """

    hovered = Signal(int, int)
    clicked = Signal(int, int)
    outlined = Signal(object, str)
    tool_changed = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.image: ScanImage | None = None
        self.paint = Paint()
        self.frame = Frame(0.0, 0.0, 1.0, 1.0)
        self.marked: tuple[int, int] | None = None
        self._fitted = True
        self._drawn: tuple[int, Part, AnyArray, QImage] | None = None
        hand = Hand(self)
        self._tools: dict[str, Tool] = {
            "navigate": hand,
            "pick": PointingHand(self),
            "lasso": Lasso(self, self._note_contour),
            "rectangle": Rectangle(self, self._note_contour),
        }
        self._tool: Tool = hand
        self._mouse = Mouse(self, hand)
        self._mouse.armed.connect(self._note_tool)
        self._mouse.hovered.connect(self._note_place)
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(5 * self.fontMetrics().height())
        self.setAccessibleName(self.tr("Scan image"))

    # What is shown

    def show_image(self, image: ScanImage | None) -> None:
        """Show another picture; one of the same size is seen from where one looked."""
        old, self.image = self.image, image
        if image is not None:
            same = old is not None and old.levels[0].shape == image.levels[0].shape
            self._fitted = self._fitted or not same
            self._settle()
        self.repaint_all()

    def repaint_all(self) -> None:
        """Take the colours anew: the paint has changed."""
        self._drawn = None
        self.update()

    def mark(self, pixel: tuple[int, int] | None) -> None:
        """Put a ring around the point that was picked."""
        self.marked = pixel
        self.update()

    def set_tool(self, name: str) -> None:
        """Arm a tool, by the names of the 3-D view."""
        self._mouse.arm(self._tools[name])

    def refresh_overlay(self) -> None:
        """Paint what lies over the picture again."""
        self.update()

    # What is seen of it

    def fit(self) -> None:
        """Show all of the picture, and go on doing so when the view becomes larger."""
        self._fitted = True
        self._settle()

    def pan(self, x: float, y: float) -> None:
        """Move the picture by logical pixels."""
        self._see(self.frame.move(x, y))

    def zoom(self, factor: float, x: float | None = None, y: float | None = None) -> None:
        """Make the picture larger; a place of the view, else its middle, stays."""
        x = self.width() / 2 if x is None else x
        y = self.height() / 2 if y is None else y
        self._see(self.frame.zoom(factor, x, y))

    def zoom_steps(self, steps: int) -> None:
        """Make the picture larger by steps of the wheel."""
        self.zoom(ZOOM_PER_NOTCH**steps)

    def click(self, x: float, y: float) -> None:
        """Ask for what is at a place."""
        row, column = self.pixel_at(x, y)
        if row >= 0:
            self.clicked.emit(row, column)

    def pixel_at(self, x: float, y: float) -> tuple[int, int]:
        """Row and column at a place of the view; −1, −1 beside the picture."""
        if self.image is not None:
            column, row = self.frame.to_image(x, y)
            layout = self.image.layout
            if 0 <= column < layout.columns and 0 <= row < layout.rows:
                return int(row), int(column)
        return -1, -1

    def place_of(self, row: float, column: float) -> QPointF:
        """Where the middle of a pixel is in the view."""
        return QPointF(*self.frame.to_view(column + 0.5, row + 0.5))

    def _see(self, frame: Frame) -> None:
        if self.image is not None:
            layout, size = self.image.layout, (self.width(), self.height())
            self.frame = frame.keep(layout, size)
            self._fitted = self.frame == Frame.fit(layout, size)
            self.update()

    def _settle(self) -> None:
        if self.image is not None:
            layout, size = self.image.layout, (self.width(), self.height())
            whole = Frame.fit(layout, size)
            self.frame = whole if self._fitted else self.frame.keep(layout, size)
            self.update()

    # Gestures

    def _note_tool(self, tool: Tool) -> None:
        self._tool = tool
        self.setCursor(tool.cursor)
        self.update()
        self.tool_changed.emit(tool.name)

    def _note_place(self, x: float, y: float) -> None:
        self.hovered.emit(*self.pixel_at(x * self.width(), y * self.height()))

    def _note_contour(self, corners: list[Corner], combine: Combine) -> None:
        size = self.width(), self.height()
        places = [self.frame.to_image(x * size[0], y * size[1]) for x, y in corners]
        self.outlined.emit(places, combine)

    # Qt

    def sizeHint(self) -> QSize:  # noqa: N802
        """Wide and low, as panoramas are."""
        em = self.fontMetrics().height()
        return QSize(50 * em, 14 * em)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Go on showing all, where all was shown."""
        super().resizeEvent(event)
        self._settle()

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802
        """Forget the place of the mouse."""
        super().leaveEvent(event)
        self.hovered.emit(-1, -1)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Move with the arrows, zoom with plus and minus, show all with 0."""
        across, down = STEP * self.width(), STEP * self.height()
        moves = {
            Qt.Key.Key_Left: (across, 0.0),
            Qt.Key.Key_Right: (-across, 0.0),
            Qt.Key.Key_Up: (0.0, down),
            Qt.Key.Key_Down: (0.0, -down),
        }
        key = Qt.Key(event.key())
        if key in moves:
            self.pan(*moves[key])
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal, Qt.Key.Key_Minus):
            self.zoom_steps(-1 if key == Qt.Key.Key_Minus else 1)
        elif key == Qt.Key.Key_0:
            self.fit()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Paint the part that is seen, and over it what a tool draws."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(*BACKGROUNDS[self.paint.background][1]))
        if self.image is not None:
            self._paint_image(painter, self.image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.marked is not None and self.image is not None:
            self._paint_ring(painter, self.place_of(*self.marked))
        self._tool.paint(painter, self.width(), self.height())
        painter.end()

    def _paint_image(self, painter: QPainter, image: ScanImage) -> None:
        scale = self.devicePixelRatioF()
        level = self.frame.choose_level(image, scale)
        part = self.frame.find_part(image, level, (self.width(), self.height()))
        if self._drawn is None or self._drawn[:2] != (level, part):
            colours = self.paint.draw(image, level, part)
            height, width = colours.shape
            picture = QImage(
                colours.data.cast("B"), width, height, 4 * width, QImage.Format.Format_RGB32
            )
            self._drawn = level, part, colours, picture  # the picture does not own its colours
        side = min(self.frame.wide, self.frame.high) * 2**level * scale
        smooth = QPainter.RenderHint.SmoothPixmapTransform
        painter.setRenderHint(smooth, side < CRISP)
        painter.drawImage(QRectF(*self.frame.place_part(level, part)), self._drawn[3])
        painter.setPen(self.palette().mid().color())
        layout = image.layout
        corner = QPointF(*self.frame.to_view(layout.columns, layout.rows))
        painter.drawRect(QRectF(QPointF(*self.frame.to_view(0, 0)), corner))

    def _paint_ring(self, painter: QPainter, middle: QPointF) -> None:
        reach = 0.45 * self.fontMetrics().height()
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for colour, width in ((QColor(255, 255, 255, 200), 4.0), (RING, 2.0)):
            painter.setPen(QPen(colour, width))
            painter.drawEllipse(middle, reach, reach)
