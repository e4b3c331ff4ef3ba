"""Numbers as people read and type them."""

from __future__ import annotations

import math

from PySide6.QtCore import QLocale, Qt
from PySide6.QtWidgets import QAbstractSpinBox, QDoubleSpinBox, QWidget

from app.core.units import group_digits

MINUS = "−"
UNKNOWN = "–"


class NumberField(QDoubleSpinBox):
    """A field for one number with its unit; the C locale, since the number feeds a fit."""

    def __init__(
        self,
        low: float,
        high: float,
        decimals: int,
        unit: str = "",
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setLocale(QLocale.c())
        self.setRange(low, high)
        self.setDecimals(decimals)
        self.setSuffix(f" {unit}" if unit else "")
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        # A half typed number must not start a computation.
        self.setKeyboardTracking(False)
        self.setStepType(QAbstractSpinBox.StepType.AdaptiveDecimalStepType)


def show_number(value: float | None, decimals: int = 2) -> str:
    """A number in the language of the user; a dash when there is none."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    text = QLocale().toString(float(value), "f", decimals)
    return text.replace("-", MINUS)


def show_count(count: int) -> str:
    """A whole number with separated thousands."""
    return group_digits(count)


def show_signed(value: float | None, decimals: int = 1) -> str:
    """A number with its sign, also when it is positive."""
    text = show_number(value, decimals)
    return text if text.startswith((MINUS, UNKNOWN)) else f"+{text}"


def show_with_sd(value: float | None, sd: float | None, least: int = 0) -> str:
    """Mean ± sd, rounded to the two leading digits of the sd."""
    decimals = max(count_decimals(value, sd), least)
    if value is None or not math.isfinite(value):
        return UNKNOWN
    if sd is None or not math.isfinite(sd):
        return show_number(value, decimals)
    return f"{show_number(value, decimals)} ± {show_number(sd, decimals)}"


def count_decimals(value: float | None, sd: float | None) -> int:
    """Decimals worth showing: two digits of the sd, or four of the value without one."""
    if sd is not None and math.isfinite(sd) and sd > 0.0:
        return min(max(1 - math.floor(math.log10(sd)), 0), 8)
    if value is None or not math.isfinite(value) or value == 0.0:
        return 2
    return min(max(3 - math.floor(math.log10(abs(value))), 0), 8)
