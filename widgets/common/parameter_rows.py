"""One row per parameter of an angular model: name, slider, number, error, bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping

from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QSlider, QWidget

from app.core.fitting import Estimate
from app.core.phase import Parameter, PhaseModel
from widgets.common.numbers import NumberField, count_decimals, show_number

STEPS = 1000
UNITS = {"deg": "°"}


class ParameterRow(QObject):
    """Slider and field of one parameter, kept at the same value.

    Signals
    -------
    moved(str), released()
        The value of that name is being changed by hand; it was let go.
    """

    moved = Signal(str)
    released = Signal()

    def __init__(self, parameter: Parameter, size: float, parent: QWidget) -> None:
        super().__init__(parent)
        self.parameter = parameter
        self.low, self.high = slider_range(parameter, size)
        field_low, field_high = field_range(parameter, size)
        step = (self.high - self.low) / STEPS
        unit = UNITS.get(parameter.unit, "")
        self.field = NumberField(
            field_low, field_high, max(count_decimals(None, step), 3), unit, parent
        )
        # The slider beside it does what its buttons would, and needs the room.
        self.field.setButtonSymbols(NumberField.ButtonSymbols.NoButtons)
        self.slider = QSlider(Qt.Orientation.Horizontal, parent)
        self.slider.setRange(0, STEPS)
        self.slider.setPageStep(STEPS // 20)
        self.title = QLabel(label_of(parameter.name), parent)
        self.title.setBuddy(self.field)
        self.error = QLabel(parent)
        self.bounds = QLabel(show_bounds(parameter), parent)
        self.bounds.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        for widget in (self.title, self.slider, self.field):
            widget.setToolTip(f"{parameter.name}: {parameter.meaning}")
        self.slider.setAccessibleName(parameter.meaning)
        self.field.setAccessibleName(f"{parameter.name}, {parameter.meaning}")
        self.slider.valueChanged.connect(self._on_slider)
        self.slider.sliderReleased.connect(self.released)
        self.field.valueChanged.connect(self._on_field)

    @property
    def value(self) -> float:
        """The value shown."""
        return self.field.value()

    def show_value(self, value: float) -> None:
        """Show a value without a signal; NaN rests in the middle."""
        known = value if math.isfinite(value) else (self.low + self.high) / 2
        share = (known - self.low) / (self.high - self.low)
        with QSignalBlocker(self.slider), QSignalBlocker(self.field):
            self.field.setValue(known)
            self.slider.setValue(round(min(max(share, 0.0), 1.0) * STEPS))

    def _on_slider(self, position: int) -> None:
        with QSignalBlocker(self.field):
            self.field.setValue(self.low + (self.high - self.low) * position / STEPS)
        self.moved.emit(self.parameter.name)
        if not self.slider.isSliderDown():
            self.released.emit()  # moved by the keyboard or the wheel

    def _on_field(self, value: float) -> None:
        self.show_value(value)
        self.moved.emit(self.parameter.name)
        self.released.emit()


class ParameterRows(QWidget):
    """All parameters of a model.

    Signals
    -------
    moved(dict)
        Values while one of them is being changed by hand.
    released(dict)
        Values when it was let go.
    grabbed()
        A slider was taken: a new drag begins.
    """

    moved = Signal(object)
    released = Signal(object)
    grabbed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows: dict[str, ParameterRow] = {}
        # Fields round what they show; a value that nobody touched stays exact.
        self._values: dict[str, float] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(1, 1)

    def show_model(self, model: PhaseModel, size: float) -> None:
        """Make the rows of a model for data of this size (their largest value)."""
        self._clear()
        for line, parameter in enumerate(model.parameters):
            row = ParameterRow(parameter, size, self)
            row.moved.connect(self._on_moved)
            row.released.connect(self._on_released)
            row.slider.sliderPressed.connect(self.grabbed)
            row.slider.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            for column, widget in enumerate(
                (row.title, row.slider, row.field, row.error, row.bounds)
            ):
                self._grid.addWidget(widget, line, column)
            self.rows[parameter.name] = row

    @property
    def values(self) -> dict[str, float]:
        """The values shown; NaN for one that a fit left undetermined."""
        return dict(self._values)

    def show_values(
        self, values: Mapping[str, float], estimates: Mapping[str, Estimate] | None = None
    ) -> None:
        """Show values without a signal, with the errors of a fit where there is one."""
        self._values = {name: values.get(name, math.nan) for name in self.rows}
        for name, row in self.rows.items():
            row.show_value(self._values[name])
            row.error.setText(self._describe(row, (estimates or {}).get(name)))

    def _describe(self, row: ParameterRow, estimate: Estimate | None) -> str:
        if estimate is None:
            return ""
        if estimate.value is None:
            return self.tr("undetermined")
        if estimate.at_bound:
            return self.tr("at its bound")
        if estimate.sd is None:
            return self.tr("no error known")
        return f"± {show_number(estimate.sd, count_decimals(estimate.value, estimate.sd))}"

    def _clear(self) -> None:
        for row in self.rows.values():
            for widget in (row.title, row.slider, row.field, row.error, row.bounds):
                self._grid.removeWidget(widget)
                widget.deleteLater()
            row.deleteLater()
        self.rows = {}

    def _on_moved(self, name: str) -> None:
        self._values[name] = self.rows[name].value
        for other, value in self._values.items():
            if not math.isfinite(value):
                self._values[other] = self.rows[other].value
        for row in self.rows.values():
            row.error.clear()
        self.moved.emit(self.values)

    def _on_released(self) -> None:
        self.released.emit(self.values)


def slider_range(parameter: Parameter, size: float) -> tuple[float, float]:
    """Range of a slider: the bounds where they are finite, else about the usual values."""
    scale = size if parameter.scales else 1.0
    low, high = (bound * scale for bound in parameter.typical)
    reach = high - low
    low = parameter.lower if math.isfinite(parameter.lower) else low - reach
    high = parameter.upper if math.isfinite(parameter.upper) else high + reach
    return low, high


def field_range(parameter: Parameter, size: float) -> tuple[float, float]:
    """Range of a field: the bounds, or what no data of this size can need."""
    far = 100.0 * size
    return (
        parameter.lower if math.isfinite(parameter.lower) else -far,
        parameter.upper if math.isfinite(parameter.upper) else far,
    )


def show_bounds(parameter: Parameter) -> str:
    """Bounds of a fit in short."""
    low, high = parameter.lower, parameter.upper
    if math.isfinite(low) and math.isfinite(high):
        return f"{low:g} … {high:g}"
    if math.isfinite(low):
        return f"≥ {low:g}"
    return f"≤ {high:g}" if math.isfinite(high) else ""


def label_of(name: str) -> str:
    """A parameter's name as it is printed: Greek letters and lowered indices."""
    letters = {"mu": "μ", "nu": "ν", "k_d": "k<sub>d</sub>"}
    if name in letters:
        return f"<i>{letters[name]}</i>"
    if len(name) == 2 and name[1].isdigit():
        return f"<i>{name[0]}</i><sub>{name[1]}</sub>"
    return f"<i>{name}</i>"
