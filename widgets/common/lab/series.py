"""One set of points with its curve, and how it looks in the plots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from PySide6.QtGui import QColor

from app.core.arrays import Floats
from app.core.phase.angular import AngularModel
from app.core.units import to_radians
from app.services.lab.figure import COLOURS
from widgets.common.angular_points import NO_POINTS, AngularPoints

SYMBOLS = ("o", "s", "t1", "d", "t", "+", "x", "p")
"""A shape for each, so that colours need not be told apart; those of the figure on paper."""
MOST_SERIES = 12
"""More curves than these cannot be told apart."""
STEEPEST_DRAWN = 89.9
DRAWN = np.linspace(0.0, STEEPEST_DRAWN, 361)
LEAST_CONTRAST = 3.0


@dataclass(frozen=True, slots=True)
class Shape:
    """A curve: a model with its values; `scatter` is the RMSE where it was fitted."""

    model: AngularModel
    values: Mapping[str, float]
    scatter: float | None = None

    def draw(self, angle_deg: Floats = DRAWN) -> Floats:
        """The curve at angles; NaN where it leaves the numbers."""
        with np.errstate(all="ignore"):
            y = self.model.evaluate(to_radians(angle_deg), self.values)
        return np.where(np.isfinite(y), y, np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """What is drawn of one channel of one set of points; the number chooses how it looks."""

    title: str
    number: int = 0
    points: AngularPoints = NO_POINTS
    shape: Shape | None = None

    @property
    def colour(self) -> str:
        """Its colour on white paper."""
        return COLOURS[self.number % len(COLOURS)]

    @property
    def symbol(self) -> str:
        """Its symbol, as pyqtgraph names it."""
        return SYMBOLS[self.number % len(SYMBOLS)]


def fit_to_paper(colour: str | QColor, paper: QColor) -> QColor:
    """The colour, made lighter or darker until it stands out from the paper."""
    found = QColor(colour)
    for _ in range(12):
        if _contrast(found, paper) >= LEAST_CONTRAST:
            break
        found = found.lighter(112) if paper.lightnessF() < 0.5 else found.darker(108)
    return found


def _contrast(first: QColor, second: QColor) -> float:
    light, dark = sorted((_luminance(first), _luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _luminance(colour: QColor) -> float:
    """Relative luminance as the accessibility guidelines of the web have it."""
    parts = (colour.redF(), colour.greenF(), colour.blueF())
    linear = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
