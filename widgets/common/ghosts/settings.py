"""How strict the search for ghosts is: three steps for a start, every number behind them."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QSlider,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.core.ghosts import SURE
from app.services.cleanup.answers import SETTINGS, Uncertain
from widgets.common.beam_form import BeamForm
from widgets.common.numbers import NumberField, show_number

STEPS = 100
LEAST = 1.0 / STEPS
"""A threshold of 0 would call all points ghosts."""


class GhostSettings(QWidget):
    """Three steps, and behind a disclosure threshold, confidence, beam and the uncertain.

    Signals
    -------
    threshold_moved(float)
        Another threshold is tried out.
    threshold_set(float)
        The user settles for it.
    grabbed()
        A drag of the threshold begins.
    answers_changed()
        Confidence, or what becomes of those that cannot be corrected.
    """

    threshold_moved = Signal(float)
    threshold_set = Signal(float)
    grabbed = Signal()
    answers_changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.steps = QSlider(Qt.Orientation.Horizontal, self)
        self.step_words = QLabel(self)
        self.more = QToolButton(self)
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.field = NumberField(LEAST, 1.0, 2, "", self)
        self.sure_field = NumberField(0.0, 1.0, 2, "", self)
        self.uncertain_box = QComboBox(self)
        self._chosen = False
        self.beam = BeamForm(self)
        self.box = QWidget(self)
        self._lay_out()
        self._explain()
        self._connect()

    @property
    def threshold(self) -> float:
        """The threshold that is shown."""
        return self.field.value()

    @property
    def sure(self) -> float:
        """Confidence from which a ghost is corrected."""
        return self.sure_field.value()

    @property
    def uncertain(self) -> Uncertain:
        """What becomes of ghosts that cannot be corrected."""
        return "delete" if self.uncertain_box.currentIndex() == 0 else "mark"

    def suggest(self, uncertain: Uncertain) -> None:
        """What becomes of ghosts that cannot be corrected, as long as the user has not chosen."""
        if not self._chosen:
            with QSignalBlocker(self.uncertain_box):
                self.uncertain_box.setCurrentIndex(0 if uncertain == "delete" else 1)

    def show_threshold(self, threshold: float) -> None:
        """Show a threshold without a signal."""
        with QSignalBlocker(self.slider), QSignalBlocker(self.field), QSignalBlocker(self.steps):
            self.slider.setValue(round(threshold * STEPS))
            self.field.setValue(threshold)
            nearest = min(range(3), key=lambda k: abs(list(SETTINGS.values())[k] - threshold))
            self.steps.setValue(nearest)
        self.step_words.setText(self._describe(threshold))

    def _describe(self, threshold: float) -> str:
        words = {
            "careful": self.tr("Few good points are lost; some ghosts stay."),
            "normal": self.tr("As many as possible are judged right."),
            "strict": self.tr("Few ghosts stay; more good points are lost at borders."),
        }
        for name, value in SETTINGS.items():
            if abs(value - threshold) < 0.005:
                return words[name]
        return self.tr("An own threshold: {0}").format(show_number(threshold))

    def _lay_out(self) -> None:
        self.steps.setRange(0, len(SETTINGS) - 1)
        self.steps.setPageStep(1)
        self.steps.setTickPosition(QSlider.TickPosition.TicksBelow)
        self.slider.setRange(1, STEPS)
        self.slider.setPageStep(STEPS // 20)
        for field in (self.field, self.sure_field):
            field.setSingleStep(0.05)
        self.sure_field.setValue(SURE)
        self.uncertain_box.addItems([self.tr("are deleted"), self.tr("stay, marked")])
        names = (self.tr("careful"), self.tr("normal"), self.tr("strict"))
        sides = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter,
                 Qt.AlignmentFlag.AlignRight)  # fmt: skip
        grid = QGridLayout()
        grid.setVerticalSpacing(0)
        grid.addWidget(self.steps, 0, 0, 1, 3)
        for column, (name, side) in enumerate(zip(names, sides, strict=True)):
            grid.addWidget(QLabel(name, self), 1, column, side)
            grid.setColumnStretch(column, 1)
        self.step_words.setWordWrap(True)
        self.step_words.setProperty("faint", "true")
        self.more.setText(self.tr("A&ll settings"))
        self.more.setCheckable(True)
        self.more.setArrowType(Qt.ArrowType.RightArrow)
        self.more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        row = QHBoxLayout()
        row.addWidget(self.slider, 1)
        row.addWidget(self.field)
        form = QFormLayout()
        form.addRow(self.tr("&Threshold"), row)
        label = form.labelForField(row)
        if isinstance(label, QLabel):
            label.setBuddy(self.field)
        form.addRow(self.tr("Correct if s&urer than"), self.sure_field)
        form.addRow(self.tr("&Others"), self.uncertain_box)
        inner = QVBoxLayout(self.box)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addLayout(form)
        inner.addWidget(self.beam)
        self.box.hide()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(grid)
        layout.addWidget(self.step_words)
        layout.addWidget(self.more, 0, Qt.AlignmentFlag.AlignLeft)
        layout.addWidget(self.box)

    def _explain(self) -> None:
        told = (
            (self.steps, self.tr("How strict: careful, normal or strict"),
             self.tr("Threshold of the score: careful 0.8, normal 0.5, strict 0.2")),
            (self.slider, self.tr("Ghost threshold, 0.01 to 1"),
             self.tr("Points with this score or more count as ghosts (0.01–1)")),
            (self.field, self.tr("Ghost threshold, 0.01 to 1"),
             self.tr("Points with this score or more count as ghosts (0.01–1)")),
            (self.sure_field, self.tr("Confidence from which a ghost is corrected, 0 to 1"),
             self.tr("Probability that a corrected point lies right, from which it is put back on "
                     "a surface (0–1)")),
            (self.uncertain_box, self.tr("Ghosts that cannot be corrected"),
             self.tr("What is proposed for ghosts that no surface is sure enough for")),
            (self.more, self.tr("All settings"),
             self.tr("Threshold, confidence, beam of the scanner, and what to do with the rest")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)

    def _connect(self) -> None:
        self.steps.valueChanged.connect(self._on_step)
        self.slider.sliderPressed.connect(self.grabbed)
        self.slider.valueChanged.connect(self._on_slider)
        self.slider.sliderReleased.connect(self._settle)
        self.field.valueChanged.connect(self._on_field)
        self.sure_field.valueChanged.connect(self.answers_changed)
        self.uncertain_box.currentIndexChanged.connect(self._on_uncertain)
        self.more.toggled.connect(self._show_all)

    def _on_step(self, step: int) -> None:
        self.grabbed.emit()
        self._try(list(SETTINGS.values())[step])
        self._settle()

    def _on_slider(self, position: int) -> None:
        self._try(position / STEPS)
        if not self.slider.isSliderDown():
            self._settle()  # moved by the keyboard or the wheel

    def _on_field(self, value: float) -> None:
        self.grabbed.emit()
        self._try(value)
        self._settle()

    def _try(self, threshold: float) -> None:
        self.show_threshold(threshold)
        self.threshold_moved.emit(self.threshold)

    def _settle(self) -> None:
        self.threshold_set.emit(self.threshold)

    def _on_uncertain(self, _: int) -> None:
        self._chosen = True
        self.answers_changed.emit()

    def _show_all(self, shown: bool) -> None:
        self.box.setVisible(shown)
        arrows = Qt.ArrowType
        self.more.setArrowType(arrows.DownArrow if shown else arrows.RightArrow)
