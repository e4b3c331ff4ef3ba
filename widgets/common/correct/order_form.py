"""What is to be corrected, by which workflow, and where the numbers come from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QWidget,
)

from app.core.workflows.chain import LEAST_BRACKET, WORKFLOWS
from app.core.workflows.published import list_published
from app.model.scan import Channel
from app.services.workflow_preview import Source
from widgets.common.numbers import NumberField
from widgets.common.parameter_rows import label_of

What = Literal["all", "chosen", "leaf", "scan"]
TYPED = {
    "b": (-5.0, 10.0, 1.0, "How steeply intensity falls: 1 as a Lambertian, less is flatter, more "
          "is steeper (−5 to 10, no unit). For WF2; the diffuse part of WF3 is Lambertian"),
    "k_d": (0.0, 1.0, 0.8, "Diffuse share of the return (0–1), for WF3"),
    "m": (0.001, 1.0, 0.3, "Roughness of the surface (0.001–1), for WF3"),
}  # fmt: skip
SHORT = {"wf2": "WF&2", "wf3": "WF&3", "wf3_subtracted": "WF3 by s&ubtraction"}


class OrderForm(QWidget):
    """Choices that make an order for corrections.

    Signals
    -------
    changed()
        The user chose something else.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.channel_box, self.leaves_box, self.source_box = (QComboBox(self) for _ in range(3))
        self.every = QCheckBox(self.tr("Correct all channels &alike"), self)
        self.workflow_boxes = {name: QCheckBox(self.tr(SHORT[name]), self) for name in WORKFLOWS}
        self.least = NumberField(0.01, 1.0, 2, "", self)
        self.typed = {name: NumberField(low, high, 3, "", self)
                      for name, (low, high, _, _) in TYPED.items()}  # fmt: skip
        self._fill()
        self._explain()
        self._lay_out()
        self._connect()
        self._show_typed()

    @property
    def channel(self) -> str:
        """Channel that is shown; empty without one."""
        return str(self.channel_box.currentData() or "")

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that are corrected, the one that is shown first."""
        box = self.channel_box
        rest = [str(box.itemData(i)) for i in range(box.count())] if self.every.isChecked() else []
        return tuple(dict.fromkeys(filter(None, (self.channel, *rest))))

    @property
    def what(self) -> What:
        """Which leaves."""
        found: What = self.leaves_box.currentData()
        return found

    @property
    def workflows(self) -> tuple[str, ...]:
        """Workflows that are ticked."""
        return tuple(name for name, box in self.workflow_boxes.items() if box.isChecked())

    @property
    def source(self) -> Source:
        """Where the numbers come from; the whole scan has one fit."""
        found: Source = self.source_box.currentData()[0]
        return "together" if found == "each" and self.what == "scan" else found

    @property
    def species(self) -> str:
        """Whose published values; empty for others."""
        return str(self.source_box.currentData()[1])

    @property
    def values(self) -> dict[str, float]:
        """Typed numbers; none where they are not asked for."""
        if self.source != "typed":
            return {}
        return {name: field.value() for name, field in self.typed.items()}

    def fill_channels(self, channels: Iterable[Channel], chosen: str) -> None:
        """Offer the channels that are not corrected; keep the one that was chosen."""
        offered = [(c.name, _title(c)) for c in channels if not c.workflow]
        box = self.channel_box
        if [(box.itemData(i), box.itemText(i)) for i in range(box.count())] == offered:
            return
        names = [name for name, _ in offered]
        kept = self.channel if self.channel in names else chosen
        with QSignalBlocker(box):
            box.clear()
            for name, title in offered:
                box.addItem(title, name)
            box.setCurrentIndex(max(box.findData(kept), 0))
        self.every.setVisible(len(offered) > 1)

    def _fill(self) -> None:
        for title, data in (
            (self.tr("All leaves"), "all"),
            (self.tr("Selected leaves"), "chosen"),
            (self.tr("Current leaf"), "leaf"),
            (self.tr("Whole scan, fit per 5°"), "scan"),
        ):
            self.leaves_box.addItem(title, data)
        self.source_box.addItem(self.tr("One fit of all these leaves"), ("together", ""))
        self.source_box.addItem(self.tr("A fit of each leaf"), ("each", ""))
        for species in list_published():
            title = self.tr("Junttila 2016: {0}").format(species)
            self.source_box.addItem(title, ("published", species))
        self.source_box.addItem(self.tr("Typed in"), ("typed", ""))
        for name in ("wf2", "wf3"):
            self.workflow_boxes[name].setChecked(True)
        self.least.setValue(LEAST_BRACKET)
        for name, field in self.typed.items():
            field.setValue(TYPED[name][2])

    def _explain(self) -> None:
        told = (
            (self.channel_box, self.tr("Channel"), self.tr("The channel that is shown below")),
            (self.leaves_box, self.tr("Leaves"),
             self.tr("Which leaves are fitted, corrected and shown")),
            (self.source_box, self.tr("Numbers from"),
             self.tr("Where b, k_d and m come from. Flat leaves hold few angles each: fit them "
                     "together. Published values are for 1550 and 690 nm, ±20 nm")),
            (self.least, self.tr("Least bracket"),
             self.tr("Where 1 − b·(1 − cos ω) is smaller, a point is marked and not corrected, "
                     "for the correction explodes there (0.01–1, no unit)")),
            (self.every, self.tr("Correct all channels alike"),
             self.tr("Correct every channel; each gets numbers of its own when they are fitted")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)
        for name, field in self.typed.items():
            field.setAccessibleName(name)
            field.setToolTip(self.tr(TYPED[name][3]))
        for name, tick in self.workflow_boxes.items():
            chain = WORKFLOWS[name]
            tick.setToolTip(f"{chain.title}\n{chain.formula}\n{chain.source}")
            tick.setAccessibleName(chain.title)

    def _lay_out(self) -> None:
        ticks, fields = QHBoxLayout(), QHBoxLayout()
        for tick in self.workflow_boxes.values():
            ticks.addWidget(tick)
        ticks.addStretch(1)
        self.numbers = QWidget(self)
        for name, field in self.typed.items():
            field.setButtonSymbols(NumberField.ButtonSymbols.NoButtons)
            label = QLabel(label_of(name), self.numbers)
            label.setBuddy(field)
            fields.addWidget(label)
            fields.addWidget(field, 1)
        fields.setContentsMargins(0, 0, 0, 0)
        self.numbers.setLayout(fields)
        form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        for box in (self.channel_box, self.leaves_box, self.source_box):
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.every.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Fixed)
        form.addRow(self.tr("C&hannel"), self.channel_box)
        form.addRow("", self.every)
        form.addRow(self.tr("&Leaves"), self.leaves_box)
        form.addRow(self.tr("Correct by"), ticks)
        form.addRow(self.tr("&Numbers from"), self.source_box)
        form.addRow("", self.numbers)
        form.addRow(self.tr("Least &bracket"), self.least)
        self._form = form

    def _connect(self) -> None:
        for box in (self.channel_box, self.leaves_box, self.source_box):
            box.activated.connect(self._on_change)
        for tick in (self.every, *self.workflow_boxes.values()):
            tick.clicked.connect(self._on_change)
        for field in (self.least, *self.typed.values()):
            field.valueChanged.connect(self._on_change)

    def _show_typed(self) -> None:
        self._form.setRowVisible(self.numbers, self.source == "typed")

    def _on_change(self, _: object = None) -> None:
        self._show_typed()
        self.changed.emit()


def _title(channel: Channel) -> str:
    if channel.wavelength_nm is None or f"{channel.wavelength_nm:g}" in channel.name:
        return channel.name
    return f"{channel.name} ({channel.wavelength_nm:g} nm)"
