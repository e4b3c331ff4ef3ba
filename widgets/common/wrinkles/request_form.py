"""What is asked of the leaves of a scan: channel, curve, offset, limits."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.core.units import to_degrees, to_radians
from app.core.wrinkling.leaf import Choices
from app.core.wrinkling.validity import USUAL, Limits
from app.model.scan import Channel
from app.model.state import ScanState
from app.services.beams import name_instrument
from app.services.wrinkles.request import WrinkleRequest
from app.services.wrinkles.scale import ChannelScale, find_scale
from app.simulate.instrument import list_instruments
from widgets.common.numbers import NumberField
from widgets.common.wrinkles.offset_form import FITTED, NONE, OffsetForm
from widgets.common.wrinkles.source_form import IN_USE, OWN, SCAN, SourceForm

SETTLED = {OWN: NONE, SCAN: FITTED}
"""Offsets that follow from where the curve comes from."""


class RequestForm(QWidget):
    """All that a request holds.

    Signals
    -------
    changed()
        The user chose something else.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows = QFormLayout(self)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.channel = QComboBox(self)
        self.instrument = QComboBox(self)
        self._rows.addRow(self.tr("Cha&nnel"), self.channel)
        self._rows.addRow(self.tr("Instru&ment"), self.instrument)
        self.source = SourceForm(self._rows, self)
        self.offset = OffsetForm(self)
        self.steepest = NumberField(1.0, 90.0, 0, "°", self)
        self.largest_sigma = NumberField(0.1, 90.0, 1, "°", self)
        self.means = QCheckBox(self.tr("Means over the &beam's footprint"), self)
        self._state: ScanState | None = None
        self._fill()
        self._explain()
        self._lay_out()
        self._connect()

    @property
    def lack(self) -> str:
        """What is missing before anything can be asked; empty when nothing is."""
        return self.source.lack

    def request(self) -> WrinkleRequest:
        """What is asked."""
        in_use = self.source.kind == IN_USE
        limits = Limits(
            float(to_radians(self.steepest.value())), float(to_radians(self.largest_sigma.value()))
        )
        return WrinkleRequest(
            self.source.source(),
            self.offset.offset,
            None if in_use else self.channel.currentData(),
            self._instrument,
            None,
            Choices(means=self.means.isChecked(), limits=limits),
        )

    def follow(self, state: ScanState) -> None:
        """Take over what the scan has: channels, curve, instrument."""
        self._state = state
        self._offer_channels(state.channels)
        self._suit()

    @property
    def _instrument(self) -> str | None:
        """Only where the scan names none itself."""
        return self.instrument.currentData() if self._needs_instrument else None

    @property
    def _needs_instrument(self) -> bool:
        channel = self._channel
        unnamed = self._state is not None and name_instrument(self._state.scan) is None
        return unnamed and channel is not None and channel.kind == "DN"

    @property
    def _channel(self) -> Channel | None:
        """The channel that is read: that of the curve in use, or the one chosen."""
        if self._state is None:
            return None
        curve = self._state.parameters.curve
        wanted = self.channel.currentData()
        if self.source.kind == IN_USE and curve is not None:
            wanted = curve.channel
        return next((each for each in self._state.channels if each.name == wanted), None)

    def _offer_channels(self, channels: Sequence[Channel]) -> None:
        names = [channel.name for channel in channels]
        shown = [self.channel.itemData(row) for row in range(self.channel.count())]
        if names == shown:
            return
        kept = self.channel.currentData()
        with QSignalBlocker(self.channel):
            self.channel.clear()
            for channel in channels:
                nm = channel.wavelength_nm
                more = "" if nm is None or f"{nm:g}" in channel.name else f", {nm:g} nm"
                self.channel.addItem(f"{channel.name}{more}", channel.name)
            self.channel.setCurrentIndex(max(self.channel.findData(kept), 0))

    def _suit(self) -> None:
        """Show what the choices need."""
        state = self._state
        if state is None:
            return
        chosen = next((c for c in state.channels if c.name == self.channel.currentData()), None)
        self.source.follow(
            state.parameters.curve,
            None if chosen is None else chosen.wavelength_nm,
            self.offset.offset == "fit",
        )
        channel, kind = self._channel, self.source.kind
        self.channel.setEnabled(kind != IN_USE)
        self._rows.setRowVisible(self.instrument, self._needs_instrument)
        unit = "" if channel is None else channel.kind
        self.offset.follow(self._scale(channel, state), unit, SETTLED.get(kind, ""))

    def _scale(self, channel: Channel | None, state: ScanState) -> ChannelScale | None:
        if channel is None:
            return None
        try:
            return find_scale(channel, state.scan, self._instrument)
        except LeafscopeError:
            return None  # the service says so when it is asked

    def _on_change(self, *_: object) -> None:
        self._suit()
        self.changed.emit()

    def _fill(self) -> None:
        self.instrument.addItem(self.tr("Unknown"), None)
        for known in list_instruments():
            self.instrument.addItem(known.title, known.name)
        self.steepest.setValue(float(to_degrees(USUAL.steepest)))
        self.largest_sigma.setValue(float(to_degrees(USUAL.largest_sigma)))
        self.means.setChecked(True)

    def _explain(self) -> None:
        for field, name, tip in (
            (self.channel, self.tr("Channel"),
             self.tr("Whose intensity is read; a calibrated one does not depend on the range")),
            (self.instrument, self.tr("Instrument"),
             self.tr("The scan names none; it says what the DN are and where they end")),
            (self.steepest, self.tr("Steepest valid angle"),
             self.tr("Angles beyond are not valid, 1 to 90°; Balduzzi 2011: 60°")),
            (self.largest_sigma, self.tr("Largest valid σ"),
             self.tr("Angles less certain than this are not valid, 0.1 to 90°")),
            (self.means, self.means.text().replace("&", ""),
             self.tr("Neighbours see the same surface: their mean has less noise and no less "
                     "detail. Full hits of the same leaf only")),
        ):  # fmt: skip
            field.setAccessibleName(name)
            field.setToolTip(tip)
        for box in (self.channel, self.instrument):
            box.setMinimumContentsLength(10)
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )

    def _lay_out(self) -> None:
        rows = self._rows
        limits = QWidget(self)
        inner = QHBoxLayout(limits)
        inner.setContentsMargins(0, 0, 0, 0)
        sigma = QLabel(self.tr("σ u&p to"), limits)
        sigma.setBuddy(self.largest_sigma)
        for part, stretch in ((self.steepest, 1), (sigma, 0), (self.largest_sigma, 1)):
            inner.addWidget(part, stretch)
        for title, field, buddy in (
            (self.tr("&Offset"), self.offset, self.offset.box),
            (self.tr("&Valid up to"), limits, self.steepest),
        ):
            label = QLabel(title, self)
            label.setBuddy(buddy)
            rows.addRow(label, field)
        rows.addRow("", self.means)

    def _connect(self) -> None:
        self.channel.activated.connect(self._on_change)
        self.instrument.activated.connect(self._on_change)
        self.source.changed.connect(self._on_change)
        self.offset.changed.connect(self._on_change)
        self.steepest.valueChanged.connect(self._on_change)
        self.largest_sigma.valueChanged.connect(self._on_change)
        self.means.toggled.connect(self._on_change)
