"""A slider for the size of the synthetic footprint that smooths the view; off at zero."""

from __future__ import annotations

import math
from uuid import uuid4

from PySide6.QtCore import QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSlider, QWidget

from widgets.common.numbers import NumberField

STEPS, LARGEST_MM = 90, 1000.0
PAUSE_MS = 100


class SizeSlider(QWidget):
    """Slider (logarithmic, 1 mm to 1 m) and field at the same value, mm; zero is off.

    Signals
    -------
    moved(float, str)
        Diameter in mm, at most ten times a second while it is dragged, and the word that all
        steps of the drag share.
    """

    moved = Signal(float, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.slider.setRange(0, STEPS)
        self.slider.setPageStep(STEPS // 9)
        self.field = NumberField(0.0, LARGEST_MM, 1, "mm", self)
        self.field.setSpecialValueText(self.tr("off"))
        tip = self.tr("Diameter over which channels are averaged, across the beam "
                      "(1–1000 mm; 0 is off)")  # fmt: skip
        for widget in (self.slider, self.field):
            widget.setToolTip(tip)
        self.slider.setAccessibleName(self.tr("Footprint that smooths the view"))
        self.field.setAccessibleName(self.tr("Footprint that smooths the view, mm"))
        label = QLabel(self.tr("S&mooth the view"), self)
        label.setBuddy(self.field)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(label)
        layout.addWidget(self.slider, 1)
        layout.addWidget(self.field)
        self._drag = uuid4().hex
        self._later = QTimer(self, singleShot=True, interval=PAUSE_MS)
        self._later.timeout.connect(self._tell)
        self.slider.sliderPressed.connect(self._grab)
        self.slider.valueChanged.connect(self._on_slider)
        self.slider.sliderReleased.connect(self._on_release)
        self.field.valueChanged.connect(self._on_field)

    def show_size(self, mm: float) -> None:
        """Show a size without a signal; a slider that is being dragged is left alone."""
        if self.slider.isSliderDown() or self._later.isActive():
            return
        with QSignalBlocker(self.slider), QSignalBlocker(self.field):
            self.field.setValue(mm)
            self.slider.setValue(to_step(mm))

    def _grab(self) -> None:
        self._drag = uuid4().hex

    def _on_slider(self, step: int) -> None:
        with QSignalBlocker(self.field):
            self.field.setValue(to_size(step))
        if not self._later.isActive():
            self._later.start()

    def _on_release(self) -> None:
        self._later.stop()
        self._tell()
        self._drag = uuid4().hex

    def _on_field(self, mm: float) -> None:
        with QSignalBlocker(self.slider):
            self.slider.setValue(to_step(mm))
        self._later.stop()
        self._tell()

    def _tell(self) -> None:
        self.moved.emit(self.field.value(), f"footprint {self._drag}")


def to_size(step: int) -> float:
    """Diameter of a step, mm."""
    return 0.0 if step == 0 else round(LARGEST_MM ** ((step - 1) / (STEPS - 1)), 1)


def to_step(mm: float) -> int:
    """The nearest step of a diameter."""
    if mm <= 0.0:
        return 0
    return 1 + round(math.log(max(mm, 1.0)) / math.log(LARGEST_MM) * (STEPS - 1))
