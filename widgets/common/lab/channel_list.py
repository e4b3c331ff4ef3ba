"""The channels of a scan: one is at work, those that are ticked lie over it."""

from __future__ import annotations

from collections.abc import Iterable

import pyqtgraph as pg
from pyqtgraph.graphicsItems.ScatterPlotItem import drawSymbol
from PySide6.QtCore import QEvent, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QPainter, QPixmap
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QWidget

from app.model.scan import Channel
from widgets.common.lab.series import Series, fit_to_paper

NAME = Qt.ItemDataRole.UserRole
LEAST_LINES, MOST_LINES = 1, 4
TICKED, CLEAR = Qt.CheckState.Checked, Qt.CheckState.Unchecked


class ChannelList(QListWidget):
    """The current row is the working channel; it is drawn whether ticked or not.

    Signals
    -------
    changed()
        The user chose another channel or ticked one.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(self.tr("Channels"))
        self.setToolTip(
            self.tr(
                "Click a channel to work on it: its points are drawn and the sliders move its "
                "curve. Tick others to lay their means and curves over it and to fit them along."
            )
        )
        self._offered: tuple[Channel, ...] = ()
        self.currentRowChanged.connect(self._on_row)
        self.itemChanged.connect(self._on_item)

    @property
    def channel(self) -> str:
        """Name of the working channel; empty without one."""
        item = self.currentItem()
        return "" if item is None else str(item.data(NAME))

    @property
    def channels(self) -> tuple[str, ...]:
        """The working channel, then those that are ticked, in the order of the list."""
        ticked = [item for item in self._all() if item.checkState() == TICKED]
        names = [str(item.data(NAME)) for item in ticked]
        return tuple(dict.fromkeys((self.channel, *names))) if self.channel else ()

    def number_of(self, channel: str) -> int:
        """Place of a channel among all: it chooses colour and symbol."""
        names = [c.name for c in self._offered]
        return names.index(channel) if channel in names else 0

    def title_of(self, channel: str) -> str:
        """Name and wavelength of a channel."""
        return next((title_channel(c) for c in self._offered if c.name == channel), channel)

    def offer(self, channels: Iterable[Channel], chosen: str) -> None:
        """List channels; what was chosen and ticked stays so where it is still among them."""
        offered = tuple(channels)
        if offered == self._offered:
            return
        working, ticked = self.channel, set(self.channels)
        self._offered = offered
        with QSignalBlocker(self):
            self.clear()
            for channel in offered:
                self._add(channel, channel.name in ticked)
        names = [channel.name for channel in offered]
        self.choose(working if working in names else chosen)
        lines = min(max(len(offered), LEAST_LINES), MOST_LINES)
        height = max(self.sizeHintForRow(0), self.fontMetrics().height())
        self.setFixedHeight(lines * height + 2 * self.frameWidth() + 2)

    def choose(self, channel: str) -> None:
        """Make a channel the working one, without a signal."""
        with QSignalBlocker(self):
            for item in self._all():
                if item.data(NAME) == channel:
                    self.setCurrentItem(item)
            self._tick_working()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Draw the symbols on the paper of the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            with QSignalBlocker(self):
                for number, item in enumerate(self._all()):
                    item.setIcon(self._draw(number))

    def _all(self) -> list[QListWidgetItem]:
        return [self.item(row) for row in range(self.count())]

    def _add(self, channel: Channel, ticked: bool) -> None:
        item = QListWidgetItem(self._draw(self.count()), title_channel(channel), self)
        item.setData(NAME, channel.name)
        item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(TICKED if ticked else CLEAR)

    def _tick_working(self) -> None:
        item = self.currentItem()
        if item is not None:
            item.setCheckState(TICKED)
        for each in self._all():
            font = each.font()
            font.setBold(each is item)
            each.setFont(font)

    def _draw(self, number: int) -> QIcon:
        """The symbol of a channel in its colour."""
        look = Series("", number)
        size = self.fontMetrics().height()
        picture = QPixmap(QSize(size, size) * self.devicePixelRatioF())
        picture.setDevicePixelRatio(self.devicePixelRatioF())
        picture.fill(Qt.GlobalColor.transparent)
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(size / 2, size / 2)
        ink = fit_to_paper(look.colour, self.palette().base().color())
        drawSymbol(painter, look.symbol, 0.7 * size, pg.mkPen(ink), pg.mkBrush(ink))
        painter.end()
        return QIcon(picture)

    def _on_row(self, _: int) -> None:
        with QSignalBlocker(self):
            self._tick_working()
        self.changed.emit()

    def _on_item(self, item: QListWidgetItem) -> None:
        if item is self.currentItem() and item.checkState() != TICKED:
            with QSignalBlocker(self):
                item.setCheckState(TICKED)  # the working channel cannot be taken off
            return
        self.changed.emit()


def title_channel(channel: Channel) -> str:
    """Name and wavelength."""
    if channel.wavelength_nm is None:
        return channel.name
    return f"{channel.name} ({channel.wavelength_nm:g} nm)"
