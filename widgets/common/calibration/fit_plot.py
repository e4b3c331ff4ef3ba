"""Panels and the curve through them, or what the curve leaves over."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from app.core.arrays import Floats
from app.core.radiometry import chain as chains
from app.core.radiometry.calibration import Calibration
from app.core.radiometry.panels import PanelTable
from app.render.palettes import LEAVES
from widgets.common.plots import Plot

What = Literal["reflectance", "range", "residual-range", "residual-reflectance"]
DRAWN = 200
NARROW, SHORT, LINE = 4, 7, 0.16
"""Columns of the legend for names of so few letters, and what a line takes of the height."""
SYMBOLS = "ostdp+hx"
"""A shape for each panel, so that colours need not be told apart."""


class FitPlot(Plot):
    """DN of panels and of the fit, or the difference, against reflectance or range."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "", "", parent)
        self.setAccessibleName(self.tr("Panels and the curve through them"))
        self._shown: tuple[Calibration, What] | None = None
        self._colours: Mapping[str, QColor] = {}
        self._legend = self.addLegend(offset=(-4, 2))

    def show_fit(self, calibration: Calibration, what: What, colours: Mapping[str, QColor]) -> None:
        """Draw a fit; `colours` of panels, by name, where they have some elsewhere."""
        self._shown, self._colours = (calibration, what), colours
        self._draw()

    def restyle(self) -> None:
        """Draw in the new colours."""
        super().restyle()
        if self._built and getattr(self, "_shown", None) is not None:
            self._draw()

    def _draw(self) -> None:
        if self._shown is None:
            return
        calibration, what = self._shown
        for item in list(self.plotItem.items):
            self.removeItem(item)
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        against_range = what.endswith("range")
        self.title_axis(
            "bottom", self.tr("Range (m)") if against_range else self.tr("Reflectance (0–1)")
        )
        wide = what == "range" and _is_wide(calibration.table.distance)
        self.setLogMode(x=wide, y=False)
        self.getAxis("bottom").setTicks(_round_ticks(calibration.table.distance) if wide else None)
        if what.startswith("residual"):
            self._draw_residuals(calibration, against_range)
        elif against_range:
            self._draw_over_range(calibration)
        else:
            self._draw_over_reflectance(calibration)
        self.autoRange(padding=0.08)
        self._make_room(calibration.table)

    def _make_room(self, table: PanelTable) -> None:
        """Leave the legend a strip above the data."""
        panels = table.panels
        if len(panels) > len(SYMBOLS):
            return
        columns = NARROW if max(map(len, panels)) <= SHORT else 2
        self._legend.setColumnCount(columns)
        low, high = self.viewRange()[1]
        lines = -(-len(panels) // columns)
        self.setYRange(low, high + LINE * lines * (high - low), padding=0.0)

    def _draw_over_reflectance(self, calibration: Calibration) -> None:
        reference = calibration.reference_range
        self.title_axis("left", self.tr("DN at {0} m").format(f"{reference:.3g}"))
        table = calibration.table
        low, high = float(table.reflectance.min()), float(table.reflectance.max())
        light = np.linspace(0.5 * low, min(1.15 * high, max(high, 1.0)), DRAWN)
        steps = calibration.fit.found.steps
        self._add_curve(light, chains.respond(steps, light, np.full(DRAWN, reference)))
        at = chains.respond(steps, table.reflectance, np.full(len(table), reference))
        self._add_panels(table, table.reflectance, at + calibration.fit.residual)

    def _draw_over_range(self, calibration: Calibration) -> None:
        self.title_axis("left", self.tr("DN at full power"))
        table, steps = calibration.table, calibration.fit.found.steps
        low, high = float(table.distance.min()), float(table.distance.max())
        metres = np.geomspace(low, high, DRAWN) if high > low else np.full(2, low)
        for panel in table.panels:
            light = np.full(len(metres), table.reflectance[table.panel == panel][0])
            self._add_curve(metres, chains.respond(steps, light, metres), width=1.5)
        at = chains.respond(steps, table.reflectance, table.distance)
        self._add_panels(table, table.distance, at + calibration.fit.residual)

    def _draw_residuals(self, calibration: Calibration, against_range: bool) -> None:
        self.title_axis("left", self.tr("Measured less fitted (DN)"))
        table, fit = calibration.table, calibration.fit
        self.addItem(pg.InfiniteLine(0.0, angle=0, pen=self.pen(self.accent, 1.5)))
        x = table.distance if against_range else table.reflectance
        bars = pg.ErrorBarItem(
            x=x, y=fit.residual, height=2 * fit.sigma, beam=0.0, pen=self.pen(self.ink, 1.0)
        )
        self.addItem(bars)
        self._add_panels(table, x, fit.residual)

    def _add_curve(self, x: Floats, y: Floats, width: float = 2.5) -> None:
        known = np.isfinite(y)
        self.addItem(pg.PlotDataItem(x[known], y[known], pen=self.pen(self.accent, width)))

    def _add_panels(self, table: PanelTable, x: Floats, y: Floats) -> None:
        paper = self.palette().base().color()
        for number, panel in enumerate(table.panels):
            mine = table.panel == panel
            dots = pg.PlotDataItem(
                x[mine],
                y[mine],
                pen=None,
                symbol=SYMBOLS[number % len(SYMBOLS)],
                symbolSize=2.6 * self.dot_size(),
                symbolBrush=self._colours.get(panel, QColor(LEAVES[number % len(LEAVES)])),
                symbolPen=self.pen(paper, 1.0),
            )
            self.addItem(dots)
            if len(table.panels) <= len(SYMBOLS):
                self._legend.addItem(dots, panel)


def _round_ticks(metres: Floats) -> list[list[tuple[float, str]]]:
    """Ticks of a log axis over these ranges, at round numbers."""
    low, high = 0.9 * float(metres.min()), 1.1 * float(metres.max())
    round_ones = [digit * 10.0**power for power in range(-2, 4) for digit in (1, 2, 3, 5)]
    return [[(math.log10(v), f"{v:g}") for v in round_ones if low <= v <= high]]


def _is_wide(metres: Floats) -> bool:
    return float(metres.max()) > 5.0 * float(metres.min())
