"""The footprint against the angle, with the leaf's width drawn in (Balduzzi's figure 7)."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from app.core.footprint import footprint_axis
from app.core.units import to_mm, to_radians
from app.services.planning import SHARES, Plan
from widgets.common.plots import ORANGE, Plot, mix

STEEPEST, TOP = 85.0, 1.3
BLUE, PINK = "#56b4e9", "#cc79a7"
LINES = ("SolidLine", "DashLine", "DashDotLine", "DotLine")


class PlanPlot(Plot):
    """Curves of a few ranges; the one of the position is the strong one."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "", "", parent)
        self.setAccessibleName(self.tr("Footprint against the angle of incidence"))
        self.title_axis("bottom", self.tr("Incidence angle ω (°)"))
        self.title_axis("left", self.tr("Footprint (mm)"))
        self.setMouseEnabled(x=False, y=False)
        self._legend = self.add_legend_above(4)
        self._plan: Plan | None = None
        self._here = 0.0

    def show_plan(self, plan: Plan, position: float) -> None:
        """Show a plan; `position` is the range that matters, metres."""
        self._plan, self._here = plan, position
        self._draw()

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if getattr(self, "_plan", None) is not None:
            self._draw()

    def _draw(self) -> None:
        plan = self._plan
        if plan is None:
            return
        self.clear()
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        width = to_mm(min(plan.order.length, plan.order.width))
        self._draw_width(width)
        for number, k in enumerate(self._choose(plan)):
            self._draw_range(plan, k, number)
        self.setXRange(0.0, STEEPEST, padding=0.0)
        self.setYRange(0.0, TOP * width, padding=0.0)

    def _choose(self, plan: Plan) -> list[int]:
        """The position first, then the nearest and the farthest range and one between."""
        ranges = [row.range_m for row in plan.rows]
        here = int(np.argmin(np.abs(np.array(ranges) - self._here)))
        return list(dict.fromkeys([here, 0, len(ranges) // 2, len(ranges) - 1]))[: len(LINES)]

    def _draw_width(self, width: float) -> None:
        paper = self.palette().color(self.backgroundRole())
        faint = mix(self.ink, paper, 0.35)
        for share in SHARES:
            line = pg.InfiniteLine(
                share * width, angle=0, pen=self.pen(faint, 1.0),
                label=self.tr("leaf's width") if share == 1.0 else f"{100 * share:g} %",
                labelOpts={"position": 0.02, "color": self.ink, "anchors": [(0, 1), (0, 1)]},
            )  # fmt: skip
            self.addItem(line)

    def _draw_range(self, plan: Plan, k: int, number: int) -> None:
        row, beam = plan.rows[k], plan.order.tool.beam
        angle = np.linspace(0.0, STEEPEST, 341)
        axis = footprint_axis(row.range_m, to_radians(angle), beam.radius, beam.half_divergence)
        colour = self._colour(number)
        style = getattr(Qt.PenStyle, LINES[number])
        pen = pg.mkPen(colour, width=3.0 if number == 0 else 1.8, style=style)
        curve = pg.PlotDataItem(angle, np.minimum(to_mm(axis), 1e6), pen=pen)
        self.addItem(curve)
        self._legend.addItem(pg.PlotDataItem(pen=pen), f"{row.range_m:g} m")
        if row.largest_deg is not None:
            dot = pg.ScatterPlotItem(
                [row.largest_deg], [row.footprint_mm], symbol="o", size=3.0 * self.dot_size(),
                brush=pg.mkBrush(colour), pen=pg.mkPen(self.ink, width=1.0),
            )  # fmt: skip
            self.addItem(dot)

    def _colour(self, number: int) -> QColor:
        return (self.accent, QColor(ORANGE), QColor(BLUE), QColor(PINK))[number]
