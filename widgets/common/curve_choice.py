"""What the phase lab works on: points, channels, model, and how it is fitted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QLabel, QSizePolicy, QWidget

from app.core.fitting.single import AnyModel
from app.model.fit_method import Method
from app.model.scan import Channel
from widgets.common.lab.channel_list import ChannelList
from widgets.common.lab.method_choice import MethodChoice
from widgets.common.lab.model_choice import ModelChoice

USUAL = Method()
What = Literal["leaf", "chosen", "each", "scan"]


@dataclass(frozen=True, slots=True)
class Target:
    """What a curve belongs to; `leaves` is empty for the whole scan."""

    scan: str
    leaves: tuple[str, ...]
    channel: str
    model: str
    method: Method = USUAL


class CurveChoice(QWidget):
    """Which points, channels and model the phase lab works with, and how it fits.

    Signals
    -------
    changed()
        The user chose something else.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.points_box = QComboBox(self)
        self.channel_list = ChannelList(self)
        self.models = ModelChoice(self)
        self.how = MethodChoice(self)
        self._fill_points()
        self._lay_out()
        self.points_box.activated.connect(self._on_points)
        self.channel_list.changed.connect(self.changed)
        self.models.changed.connect(self.changed)
        self.how.changed.connect(self.changed)

    @property
    def model_box(self) -> QComboBox:
        """The list of models."""
        return self.models.box

    @property
    def what(self) -> What:
        """Which points."""
        found: What = self.points_box.currentData()
        return found

    @property
    def channel(self) -> str:
        """Name of the channel at work; empty without one."""
        return self.channel_list.channel

    @property
    def channels(self) -> tuple[str, ...]:
        """The channel at work, then those that are ticked."""
        return self.channel_list.channels

    @property
    def model(self) -> AnyModel:
        """The model."""
        return self.models.model

    @property
    def method(self) -> Method:
        """How it is fitted."""
        return self.how.method

    def fill_channels(self, channels: Iterable[Channel], chosen: str) -> None:
        """Offer channels; keep those that were chosen if they are still among them."""
        self.channel_list.offer(channels, chosen)

    def show_channel(self, name: str) -> None:
        """Show a channel without a signal."""
        if name != self.channel:
            self.channel_list.choose(name)

    def _fill_points(self) -> None:
        for title, data, tip in (
            (self.tr("Current leaf"), "leaf", self.tr("The leaf that all panels work on")),
            (self.tr("Selected leaves"), "chosen",
             self.tr("The leaves selected in the Leaves panel, their points taken together")),
            (self.tr("Each selected leaf"), "each",
             self.tr("The leaves selected in the Leaves panel, a curve for each")),
            (self.tr("Whole scan"), "scan",
             self.tr("All points of the scan; fitted on means per step of the angle")),
        ):  # fmt: skip
            self.points_box.addItem(title, data)
            self.points_box.setItemData(self.points_box.count() - 1, tip, 3)
        self.points_box.setAccessibleName(self.tr("Points"))
        self.points_box.setToolTip(self.tr("Whose points are drawn and fitted"))

    def _lay_out(self) -> None:
        layout = QFormLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self.points_box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        for title, widget, buddy in (
            (self.tr("&Points"), self.points_box, self.points_box),
            (self.tr("&Channels"), self.channel_list, self.channel_list),
            (self.tr("&Model"), self.models, self.models.box),
            (self.tr("Fitted &to"), self.how, self.how.box),
        ):
            label = QLabel(title, self)
            label.setBuddy(buddy)
            layout.addRow(label, widget)

    def _on_points(self, _: int) -> None:
        # `activated` comes from the user only, so showing something tells nobody.
        self.how.suit(self.what == "scan")
        self.changed.emit()
