"""The beam of the scanner: of an instrument that is known, or two numbers from its data sheet."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QLabel, QWidget

from app.core.units import to_degrees, to_mm
from app.model.parameters import Beam
from app.services.beams import TYPED, list_beams, typed_beam
from widgets.common.numbers import NumberField

LARGEST_EXIT = 100.0
LARGEST_HALF = 5.0


class BeamForm(QWidget):
    """Shows a beam and lets another one be chosen or typed.

    Signals
    -------
    changed(Beam or None)
        The user wants this beam; None is unknown.
    """

    changed = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._ready = list_beams()
        self._beams: list[Beam | None] = []
        self._shown: tuple[Beam | None, Beam | None] | None = None
        self.source = QComboBox(self)
        self.exit = NumberField(0.0, LARGEST_EXIT, 3, "mm", self)
        self.half = NumberField(0.0, LARGEST_HALF, 5, "°", self)
        self.full = QLabel(self)
        self._explain()
        self._lay_out()
        self.source.activated.connect(self._choose)
        self.exit.valueChanged.connect(self._type)
        self.half.valueChanged.connect(self._type)

    def show_beam(self, beam: Beam | None, proposed: Beam | None = None) -> None:
        """Show a beam without a signal; `proposed` is what the scan says of itself."""
        if (beam, proposed) == self._shown:
            return  # a number that is half typed, or a list that is open, stays
        self._shown = (beam, proposed)
        rows: list[tuple[str, Beam | None]] = [(self.tr("Unknown"), None)]
        if proposed is not None:
            rows.append((self.tr("As the scan says: {0}").format(self._title(proposed)), proposed))
        rows += self._ready
        if beam is not None and beam not in [known for _, known in rows]:
            typed = self.tr("Typed in") if beam.origin == TYPED else beam.origin
            rows.append((typed, beam))
        self._beams = [known for _, known in rows]
        with QSignalBlocker(self.source), QSignalBlocker(self.exit), QSignalBlocker(self.half):
            self.source.clear()
            self.source.addItems([title for title, _ in rows])
            self.source.setCurrentIndex(self._beams.index(beam))
            self.source.setToolTip(self.source.currentText())  # which may be too long to see
            self.exit.setValue(0.0 if beam is None else to_mm(2.0 * beam.radius))
            self.half.setValue(0.0 if beam is None else to_degrees(beam.half_divergence))
        self._tell_full()

    def _title(self, beam: Beam) -> str:
        shape = (beam.radius, beam.half_divergence)
        same = [title for title, b in self._ready if (b.radius, b.half_divergence) == shape]
        named = [t for t, b in self._ready if beam.origin.startswith(f"{b.origin},") and t in same]
        return (named or same or [beam.origin])[0]

    def _choose(self, row: int) -> None:
        self.changed.emit(self._beams[row])

    def _type(self) -> None:
        self._tell_full()
        if self.exit.value() > 0.0 and self.half.value() > 0.0:
            self.changed.emit(typed_beam(self.exit.value(), self.half.value()))

    def _tell_full(self) -> None:
        full = 2.0 * self.half.value()
        self.full.setText(
            self.tr("HALF of the full divergence: the beam opens by {0}° in all.").format(
                f"{full:.5g}"
            )
            if full
            else self.tr("HALF of the full divergence, which data sheets often state.")
        )

    def _explain(self) -> None:
        told = (
            (self.source, self.tr("Beam"), self.tr("Whose beam made this scan")),
            (self.exit, self.tr("Exit diameter of the beam, mm"),
             self.tr("Diameter of the beam where it leaves the scanner, mm")),
            (self.half, self.tr("Half divergence of the beam, degrees"),
             self.tr("Angle between the middle of the beam and its edge: HALF of the full "
                     "divergence, degrees")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)
        for field in (self.exit, self.half):
            field.setSpecialValueText(self.tr("unknown"))
        self.full.setWordWrap(True)
        self.full.setProperty("faint", "true")

    def _lay_out(self) -> None:
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.source.setSizeAdjustPolicy(policy)
        self.source.setMinimumContentsLength(12)
        form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.tr("&Beam"), self.source)
        form.addRow(self.tr("E&xit diameter"), self.exit)
        form.addRow(self.tr("&Half divergence"), self.half)
        form.addRow(self.full)
