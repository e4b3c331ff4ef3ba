"""What a plan is asked: instrument or own beam, leaf, ranges, and what counts as usable."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QGridLayout, QLabel, QWidget

from app.core.mixing import PulseMixing
from app.core.planning import Limits
from app.core.units import MM_PER_M, to_degrees, to_mm
from app.services.beams import typed_beam
from app.services.plan_texts import choose_step, spread
from app.services.planning import STEEPEST, PlanOrder, Tool, describe_tool, typed_tool
from app.simulate.instrument import list_instruments
from widgets.common.numbers import NumberField

START = "ls880"
ANGLE_STEP, ABOUT = 5.0, 12
HALF, FULL = 0, 1
OWN_ROWS = (1, 2, 3)
"""Rows of the form that only an own beam needs."""
PHASE, PULSED = 0, 1
USUAL = Limits()


class PlanForm(QWidget):
    """Fields of a plan. `changed` is emitted when the user, or the scan, gives another value.

    Signals
    -------
    changed()
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._tools = [describe_tool(known) for known in list_instruments()]
        self._names = [known.name for known in list_instruments()]
        self._make_fields()
        self._explain()
        self._lay_out()
        self._connect()
        self.instrument.setCurrentIndex(self._names.index(START))
        self._take_tool(self._names.index(START))

    def _make_fields(self) -> None:
        self.instrument = QComboBox(self)
        self.instrument.addItems([*(tool.title for tool in self._tools), self.tr("Own beam")])
        self.exit = NumberField(0.1, 100.0, 3, "mm", self)
        self.divergence = NumberField(0.0, 10.0, 5, "°", self)
        self.angle_kind = QComboBox(self)
        self.angle_kind.addItems([self.tr("half angle"), self.tr("full angle")])
        self.step = NumberField(0.0001, 5.0, 4, "°", self)
        self.ranging = QComboBox(self)
        self.ranging.addItems([self.tr("Phase shift"), self.tr("Pulsed")])
        self.pulse = NumberField(0.001, 10.0, 3, "m", self)
        self.pulse.setValue(0.15)
        self.length = NumberField(1.0, 2000.0, 1, "mm", self)
        self.width_field = NumberField(1.0, 2000.0, 1, "mm", self)
        self.nearest = NumberField(0.1, 1000.0, 2, "m", self)
        self.farthest = NumberField(0.1, 1000.0, 2, "m", self)
        self.position = NumberField(0.1, 1000.0, 2, "m", self)
        self.behind = NumberField(0.0, 1000.0, 2, "m", self)
        self.most_footprint = NumberField(1.0, 500.0, 0, "%", self)
        self.full_hits = NumberField(0.0, 1e6, 0, "", self)
        self.most_ghosts = NumberField(1.0, 100.0, 0, "%", self)
        self.behind.setSpecialValueText(self.tr("nothing"))
        starts = (
            (self.length, 80.0), (self.width_field, 45.0), (self.nearest, 2.0),
            (self.farthest, 12.0), (self.position, 4.0), (self.behind, 1.0),
            (self.most_footprint, 100 * USUAL.footprint), (self.full_hits, USUAL.full_hits),
            (self.most_ghosts, 100 * USUAL.ghosts),
        )  # fmt: skip
        for field, value in starts:
            field.setValue(value)

    @property
    def own(self) -> bool:
        """Whether the beam is typed in."""
        return self.instrument.currentIndex() == len(self._tools)

    @property
    def tool(self) -> Tool:
        """The instrument with the step that is shown."""
        if not self.own:
            known = self._tools[self.instrument.currentIndex()]
            return Tool(
                known.title, known.beam, self.step.value(), known.mixing, known.nearest,
                known.farthest,
            )  # fmt: skip
        beam = typed_beam(self.exit.value(), self.half_divergence)
        pulsed = self.ranging.currentIndex() == PULSED
        return typed_tool(beam, self.step.value(), self.pulse.value() if pulsed else None)

    @property
    def half_divergence(self) -> float:
        """HALF of the full divergence, degrees."""
        full = self.angle_kind.currentIndex() == FULL
        return self.divergence.value() / (2.0 if full else 1.0)

    def order(self) -> PlanOrder:
        """What is asked; the position is one of the ranges."""
        low, high = self.nearest.value(), max(self.farthest.value(), self.nearest.value())
        here = self.position.value()
        around = {*spread(low, high, choose_step(high - low, ABOUT)), here}
        return PlanOrder(
            self.tool,
            self.length.value() / MM_PER_M,
            self.width_field.value() / MM_PER_M,
            tuple(sorted(around)),
            (*spread(0.0, 85.0, ANGLE_STEP), STEEPEST),
            self.behind.value() or None,
            1.0,
            Limits(
                self.most_footprint.value() / 100.0,
                self.full_hits.value(),
                self.most_ghosts.value() / 100.0,
            ),
        )

    def take_position(self, distance: float) -> None:
        """Take the range of a point or of a leaf of the scan."""
        self.position.setValue(distance)

    def take_leaf(self, length: float, width: float) -> None:
        """Take the size of a leaf, metres."""
        self.length.setValue(to_mm(length))
        self.width_field.setValue(to_mm(width))

    def take_instrument(self, name: str) -> None:
        """Choose the instrument that a scan names."""
        if name in self._names and self.instrument.currentIndex() != self._names.index(name):
            self.instrument.setCurrentIndex(self._names.index(name))
            self._take_tool(self.instrument.currentIndex())

    def _take_tool(self, row: int) -> None:
        """Show the numbers of an instrument; own ones stay as they are."""
        own = row == len(self._tools)
        if not own:
            tool = self._tools[row]
            mixing, half = tool.mixing, to_degrees(tool.beam.half_divergence)
            full = self.angle_kind.currentIndex() == FULL
            pulsed = isinstance(mixing, PulseMixing)
            fields = (self.exit, self.divergence, self.step, self.ranging, self.pulse)
            blockers = [QSignalBlocker(field) for field in fields]
            self.exit.setValue(to_mm(2.0 * tool.beam.radius))
            self.divergence.setValue(2.0 * half if full else half)
            self.step.setValue(tool.step_deg)
            self.ranging.setCurrentIndex(PULSED if pulsed else PHASE)
            if isinstance(mixing, PulseMixing):
                self.pulse.setValue(mixing.blend)
            del blockers
        self._settle()
        self.changed.emit()

    def _settle(self) -> None:
        """Only what can be chosen is open; the divergence is told both ways."""
        for row in OWN_ROWS:
            self._form.setRowVisible(row, self.own)
        self.pulse.setVisible(self.own and self.ranging.currentIndex() == PULSED)
        half, ranging = self.half_divergence, self.ranging.currentText().lower()
        self.told.setText(
            self.tr(
                "{0} mm at exit; HALF divergence {1}° (the beam opens by {2}° in all); {3}."
            ).format(f"{self.exit.value():.4g}", f"{half:.4g}", f"{2.0 * half:.4g}", ranging)
        )

    def _type(self) -> None:
        self._settle()
        self.changed.emit()

    def _connect(self) -> None:
        self.instrument.activated.connect(self._take_tool)
        self.angle_kind.activated.connect(self._type)
        self.ranging.activated.connect(self._type)
        for field in self._numbers:
            field.valueChanged.connect(self._type)

    @property
    def _numbers(self) -> tuple[NumberField, ...]:
        return (
            self.exit, self.divergence, self.step, self.pulse, self.length, self.width_field,
            self.nearest, self.farthest, self.position, self.behind, self.most_footprint,
            self.full_hits, self.most_ghosts,
        )  # fmt: skip

    def _explain(self) -> None:
        self.told = QLabel(self)
        self.told.setWordWrap(True)
        self.told.setProperty("faint", "true")
        told = (
            (self.instrument, self.tr("Instrument"),
             self.tr("Whose beam, step and ranging are planned with; own beam: type them in")),
            (self.exit, self.tr("Exit diameter of the beam, mm"),
             self.tr("Diameter of the beam where it leaves the scanner, 0.1–100 mm")),
            (self.divergence, self.tr("Divergence of the beam, degrees"),
             self.tr("How fast the beam widens, 0–10°; whether half or full is said beside it")),
            (self.angle_kind, self.tr("Half or full divergence"),
             self.tr("Half: from the middle of the beam to its edge. Full: from edge to edge, as "
                     "many data sheets state it")),
            (self.step, self.tr("Step between beams, degrees"),
             self.tr("Angle between neighbouring beams, 0.0001–5°: a setting of the scan")),
            (self.ranging, self.tr("Ranging"),
             self.tr("How ranges are measured: it decides which partial hits become ghosts")),
            (self.pulse, self.tr("Pulse length, metres"),
             self.tr("Length of the pulse as range, c·τ/2, 0.001–10 m: nearer surfaces blend")),
            (self.length, self.tr("Length of the leaf, mm"),
             self.tr("Length of the leaf, 1–2000 mm; the longer side counts as the length")),
            (self.width_field, self.tr("Width of the leaf, mm"),
             self.tr("Width of the leaf, 1–2000 mm")),
            (self.nearest, self.tr("Nearest range, metres"),
             self.tr("Where the table begins, 0.1–1000 m")),
            (self.farthest, self.tr("Farthest range, metres"),
             self.tr("Where the table ends, 0.1–1000 m")),
            (self.position, self.tr("Position: range of the leaf, metres"),
             self.tr("The range that the sentence speaks of, 0.1–1000 m; a click on a point of "
                     "the scan fills it in")),
            (self.behind, self.tr("Distance to what stands behind the leaf, metres"),
             self.tr("From the leaf to what stands behind it, 0–1000 m; 0: nothing, and no "
                     "ghosts")),
            (self.most_footprint, self.tr("Largest footprint, percent of the width"),
             self.tr("The footprint may be so long, 1–500 % of the leaf's width")),
            (self.full_hits, self.tr("Fewest full hits"),
             self.tr("So many beams must fall wholly on the leaf, 0–1 000 000")),
            (self.most_ghosts, self.tr("Largest share of ghosts, percent"),
             self.tr("So many of the leaf's points may be ghosts, 1–100 %")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)

    def _lay_out(self) -> None:
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.instrument.setSizeAdjustPolicy(policy)
        self.instrument.setMinimumContentsLength(10)
        form = self._form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.tr("&Instrument"), self.instrument)
        form.addRow(self.tr("E&xit diameter"), self.exit)
        self._add_pair(form, self.tr("Di&vergence"), self.divergence, self.angle_kind)
        self._add_pair(form, self.tr("Ran&ging"), self.ranging, self.pulse)
        form.addRow(self.told)
        form.addRow(self.tr("&Step"), self.step)
        self._add_pair(form, self.tr("&Leaf"), self.length, self.width_field, "×")
        self._add_pair(form, self.tr("&Ranges"), self.nearest, self.farthest, "–")
        form.addRow(self.tr("P&osition"), self.position)
        form.addRow(self.tr("&Behind it"), self.behind)

    def limits_form(self, parent: QWidget) -> QWidget:
        """The three limits, for a place of their own."""
        box = QWidget(parent)
        form = QFormLayout(box)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.tr("&Footprint up to"), self.most_footprint)
        form.addRow(self.tr("Full &hits from"), self.full_hits)
        form.addRow(self.tr("Ghosts &up to"), self.most_ghosts)
        return box

    def _add_pair(
        self, form: QFormLayout, title: str, one: QWidget, other: QWidget, between: str = ""
    ) -> None:
        row = QWidget(self)
        inner = QGridLayout(row)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addWidget(one, 0, 0)
        if between:
            inner.addWidget(QLabel(between, row), 0, 1)
        inner.addWidget(other, 0, 2)
        inner.setColumnStretch(0, 1)
        inner.setColumnStretch(2, 1)
        label = QLabel(title, self)
        label.setBuddy(one)
        form.addRow(label, row)
