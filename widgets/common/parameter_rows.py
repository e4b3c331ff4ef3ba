"""Two lines per parameter of an angular model: name, slider, number; below error and bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from PySide6.QtCore import QEasingCurve, QObject, QSignalBlocker, Qt, QVariantAnimation, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QSlider, QWidget

from app.core.fitting import Estimate
from app.core.phase import Parameter
from app.core.phase.angular import AngularModel
from widgets.common.numbers import NumberField, count_decimals, show_number

STEPS = 1000
FLIGHT = 160  # milliseconds that the sliders take to the result of a fit
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
        self._flight = QVariantAnimation(self)
        self._flight.setDuration(FLIGHT)
        self._flight.setEasingCurve(QEasingCurve.Type.OutCubic)
        self._flight.valueChanged.connect(self._fly_on)
        self._explain()
        self.slider.valueChanged.connect(self._on_slider)
        self.slider.sliderReleased.connect(self.released)
        self.field.valueChanged.connect(self._on_field)

    def _explain(self) -> None:
        parameter = self.parameter
        for label in (self.error, self.bounds):
            label.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        # As wide as there is room, so that no sentence widens the panel.
        self.error.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.bounds.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.bounds.setToolTip(self.tr("A fit stays within these bounds"))
        meaning = parameter.meaning or parameter.name
        reach = self.tr("slider from {low} to {high}").format(
            low=f"{self.low:.4g}", high=f"{self.high:.4g}"
        )
        for widget in (self.title, self.slider, self.field):
            widget.setToolTip(f"{parameter.name}: {meaning} ({reach})")
        self.slider.setAccessibleName(meaning)
        self.field.setAccessibleName(f"{parameter.name}, {meaning}")

    @property
    def value(self) -> float:
        """The value shown."""
        return self.field.value()

    def show_value(self, value: float, flying: bool = False) -> None:
        """Show a value without a signal; NaN rests in the middle. The slider may fly there."""
        known = value if math.isfinite(value) else (self.low + self.high) / 2
        share = (known - self.low) / (self.high - self.low)
        place = round(min(max(share, 0.0), 1.0) * STEPS)
        self._flight.stop()
        with QSignalBlocker(self.field):
            self.field.setValue(known)
        if flying and self.slider.isVisible():
            self._flight.setStartValue(self.slider.value())
            self._flight.setEndValue(place)
            self._flight.start()
        else:
            self._fly_on(place)

    def _fly_on(self, place: int) -> None:
        with QSignalBlocker(self.slider):
            self.slider.setValue(int(place))

    def _on_slider(self, position: int) -> None:
        self._flight.stop()
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
        self._grid.setVerticalSpacing(0)

    def show_model(self, model: AngularModel, size: float) -> None:
        """Make the rows of a model for data of this size (their largest value)."""
        self._clear()
        for line, parameter in enumerate(model.parameters):
            row = ParameterRow(parameter, size, self)
            row.moved.connect(self._on_moved)
            row.released.connect(self._on_released)
            row.slider.sliderPressed.connect(self.grabbed)
            row.slider.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            for column, widget in enumerate((row.title, row.slider, row.field)):
                self._grid.addWidget(widget, 2 * line, column)
            self._grid.addWidget(row.error, 2 * line + 1, 1)
            self._grid.addWidget(row.bounds, 2 * line + 1, 2)
            self.rows[parameter.name] = row

    @property
    def values(self) -> dict[str, float]:
        """The values shown; NaN for one that a fit left undetermined."""
        return dict(self._values)

    def show_values(
        self,
        values: Mapping[str, float],
        estimates: Mapping[str, Estimate] | None = None,
        sentences: Sequence[str] = (),
        flying: bool = False,
    ) -> None:
        """Show values without a signal, with the errors of a fit where there is one.

        Parameters
        ----------
        values : mapping of str to float
        estimates : mapping of str to Estimate, optional
        sentences : sequence of str
            Warnings of the fit: those that begin with a parameter's name are its own.
        flying : bool
            The sliders may fly there.
        """
        self._values = {name: values.get(name, math.nan) for name in self.rows}
        for name, row in self.rows.items():
            row.show_value(self._values[name], flying)
            row.error.setText(self._describe((estimates or {}).get(name)))
            own = [sentence for sentence in sentences if sentence.startswith(f"{name} ")]
            row.error.setToolTip("\n".join(own))

    def _describe(self, estimate: Estimate | None) -> str:
        if estimate is None:
            return ""
        if estimate.fixed:
            return self.tr("held fixed")
        if estimate.value is None:
            return self.tr("not determined")
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
            if row.error.text():  # else each move of a slider would lay the panel out anew
                row.error.clear()
                row.error.setToolTip("")
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
