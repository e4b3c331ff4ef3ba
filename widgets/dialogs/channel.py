"""Say that an attribute of the file is an intensity: its wavelength and what its numbers mean."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from PySide6.QtCore import QLocale, Qt
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from app.model.operations import SetChannels
from app.model.scan import Channel, ChannelKind
from widgets.controller import Controller

LONGEST_NM = 12_000.0
KINDS: tuple[ChannelKind, ...] = get_args(ChannelKind)
MEANINGS = {
    "DN": "DN: counts of the instrument",
    "dB": "dB: decibel",
    "linear": "linear: proportional to power",
    "reflectance": "reflectance: 0 to 1",
}


class ChannelDialog(QDialog):
    """Names one channel of the current scan, new or known."""

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("channel")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Name a channel"))
        self._controller = controller
        self._key = controller.current or ""
        self._scan = controller.project.state.scan(self._key).scan
        self.attribute = QComboBox(self)
        self.name = QLineEdit(self)
        self.wavelength = QDoubleSpinBox(self)
        self.kind = QComboBox(self)
        self._fill()
        self._lay_out()
        self.attribute.currentTextChanged.connect(self._show)
        self._show(self.attribute.currentText())

    def channel(self) -> Channel:
        """The channel that the dialog describes."""
        attribute = self.attribute.currentText()
        nm = self.wavelength.value()
        known = self._known(attribute) or Channel(attribute, attribute)
        return replace(
            known,
            name=self.name.text().strip() or attribute,
            wavelength_nm=nm if nm > 0 else None,
            kind=KINDS[self.kind.currentIndex()],
        )

    def show_channel(self, name: str) -> None:
        """Begin with a channel of that name, if there is one."""
        for channel in self._scan.channels:
            if channel.name == name:
                self.attribute.setCurrentText(channel.attribute)

    def accept(self) -> None:
        """Take the channel over, as one step of the history."""
        if self.attribute.currentText():
            new = self.channel()
            others = [c for c in self._scan.channels if c.attribute != new.attribute]
            if not self._controller.do(SetChannels(self._key, (*others, new))):
                return
        super().accept()

    def _fill(self) -> None:
        numbers = [n for n, v in self._scan.attributes.items() if v.dtype.kind in "iuf"]
        self.attribute.addItems(numbers)
        self.kind.addItems([self.tr(MEANINGS[kind]) for kind in KINDS])
        self.wavelength.setLocale(QLocale.c())
        self.wavelength.setRange(0.0, LONGEST_NM)
        self.wavelength.setDecimals(1)
        self.wavelength.setSuffix(" nm")
        self.wavelength.setSpecialValueText(self.tr("unknown"))

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        form = QFormLayout()
        form.addRow(self.tr("&Values"), self.attribute)
        form.addRow(self.tr("&Name"), self.name)
        form.addRow(self.tr("&Wavelength"), self.wavelength)
        form.addRow(self.tr("&Kind"), self.kind)
        standard = QDialogButtonBox.StandardButton
        buttons = QDialogButtonBox(standard.Ok | standard.Cancel, self)
        buttons.button(standard.Ok).setEnabled(self.attribute.count() > 0)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.addLayout(form)
        column.addStretch()
        column.addWidget(buttons)
        self.setMinimumWidth(26 * em)

    def _known(self, attribute: str) -> Channel | None:
        return next((c for c in self._scan.channels if c.attribute == attribute), None)

    def _show(self, attribute: str) -> None:
        known = self._known(attribute) or Channel(attribute, attribute)
        self.name.setText(known.name)
        self.wavelength.setValue(known.wavelength_nm or 0.0)
        self.kind.setCurrentIndex(KINDS.index(known.kind))
