"""Three choices: which points, which channel, which model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QSizePolicy, QWidget

from app.core.phase import MODELS
from app.model.scan import Channel
from app.services.curves import DEFAULT_MODEL

What = Literal["leaf", "chosen", "scan"]


@dataclass(frozen=True, slots=True)
class Target:
    """What a curve belongs to; `leaves` is empty for the whole scan."""

    scan: str
    leaves: tuple[str, ...]
    channel: str
    model: str


class CurveChoice(QWidget):
    """Which points, channel and model the phase lab works with.

    Signals
    -------
    changed()
        The user chose something else.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.points_box, self.channel_box, self.model_box = (QComboBox(self) for _ in range(3))
        for title, data in (
            (self.tr("Current leaf"), "leaf"),
            (self.tr("Selected leaves"), "chosen"),
            (self.tr("Whole scan, means per 5°"), "scan"),
        ):
            self.points_box.addItem(title, data)
        for model in MODELS.values():
            self.model_box.addItem(model.title, model.name)
        self.show_model(DEFAULT_MODEL)
        layout = QFormLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for title, box in (
            (self.tr("&Points"), self.points_box),
            (self.tr("&Channel"), self.channel_box),
            (self.tr("&Model"), self.model_box),
        ):
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            box.setAccessibleName(title.replace("&", ""))
            box.activated.connect(self._on_choice)
            layout.addRow(title, box)

    @property
    def what(self) -> What:
        """Which points."""
        found: What = self.points_box.currentData()
        return found

    @property
    def channel(self) -> str:
        """Name of the channel; empty without one."""
        return str(self.channel_box.currentData() or "")

    @property
    def model(self) -> str:
        """Name of the model."""
        return str(self.model_box.currentData())

    def fill_channels(self, channels: Iterable[Channel], chosen: str) -> None:
        """Offer channels; keep the one that was chosen if it is still among them."""
        offered = {channel.name: _title(channel) for channel in channels}
        box = self.channel_box
        if {box.itemData(i): box.itemText(i) for i in range(box.count())} == offered:
            return
        kept = self.channel if self.channel in offered else chosen
        box.clear()
        for name, title in offered.items():
            box.addItem(title, name)
        box.setCurrentIndex(box.findData(kept))

    def show_channel(self, name: str) -> None:
        """Show a channel without a signal."""
        if self.channel_box.findData(name) >= 0:
            self.channel_box.setCurrentIndex(self.channel_box.findData(name))

    def show_model(self, name: str) -> None:
        """Show a model without a signal."""
        self.model_box.setCurrentIndex(self.model_box.findData(name))

    def _on_choice(self, _: int) -> None:
        # `activated` comes from the user only, so showing something tells nobody.
        self.changed.emit()


def _title(channel: Channel) -> str:
    if channel.wavelength_nm is None:
        return channel.name
    return f"{channel.name} ({channel.wavelength_nm:g} nm)"
