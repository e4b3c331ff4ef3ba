"""Means per 5° of the incidence angle before and after corrections."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from app.model.scan import ChannelKind
from app.services.workflow_preview import Steps
from widgets.common.correct.workflow_grid import SHORT
from widgets.common.plots import GREEN, ORANGE, Plot

TICKS = range(0, 91, 15)
HEADROOM = 0.2
"""For the legend."""
LOOKS = {"wf1": ("", "o"), "wf2": (ORANGE, "s"), "wf3": (GREEN, "t1"),
         "wf3_subtracted": ("#cc79a7", "d")}  # fmt: skip
"""Colour and symbol; WF1 is drawn in ink."""


class WorkflowPlot(Plot):
    """A line with bars (one standard deviation) for each workflow."""

    _shown: tuple[Mapping[str, Steps], ChannelKind] | None = None

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "ω (°)", "", parent)
        self.setAccessibleName(self.tr("Means per 5° of the incidence angle, by workflow"))
        self.setToolTip(
            self.tr("Mean ± standard deviation per 5° of ω. A correction that fits makes it flat.")
        )
        self.lines = {workflow: pg.PlotDataItem() for workflow in LOOKS}
        none = np.zeros(0)
        self._bars = {
            workflow: pg.ErrorBarItem(x=none, y=none, height=none, beam=0.8) for workflow in LOOKS
        }
        for item in (*self._bars.values(), *self.lines.values()):
            self.addItem(item)
        self._legend = self.addLegend(offset=(1, 1), colCount=len(LOOKS), labelTextSize="9pt")
        self.getAxis("bottom").setTicks([[(angle, f"{angle}") for angle in TICKS]])
        self.setXRange(0.0, 90.0, padding=0.03)

    def show_steps(self, steps: Mapping[str, Steps], kind: ChannelKind) -> None:
        """Show the means by workflow; `kind` is that of the channel."""
        self._shown = (steps, kind)
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        titles = {
            "DN": self.tr("Intensity (DN)"),
            "dB": self.tr("Intensity (dB)"),
            "linear": self.tr("Intensity (linear)"),
            "reflectance": self.tr("Reflectance (0–1)"),
        }
        self.title_axis("left", titles[kind])
        for shift, (workflow, (colour, symbol)) in enumerate(LOOKS.items()):
            there = workflow in steps and len(steps[workflow].angle) > 0
            self.lines[workflow].setVisible(there)
            self._bars[workflow].setVisible(there)
            if there:
                self._draw(workflow, steps[workflow], colour or self.ink, symbol, 0.5 * shift)
        known = [s for s in steps.values() if len(s.mean)]
        if known:
            top = max(float(np.max(s.mean + s.sd)) for s in known)
            low = min(0.0, min(float(np.min(s.mean - s.sd)) for s in known))
            self.setYRange(low, top + HEADROOM * (top - low), padding=0.05)

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if self._shown is not None:
            self.show_steps(*self._shown)

    def _draw(self, workflow: str, steps: Steps, colour: object, symbol: str, shift: float) -> None:
        """One workflow, set off a little so that bars do not hide each other."""
        pen, x = self.pen(colour, 1.5), steps.angle + shift  # type: ignore[arg-type]
        line = self.lines[workflow]
        self._bars[workflow].setData(x=x, y=steps.mean, height=2 * steps.sd, pen=pen)
        line.setData(
            x, steps.mean, pen=pen, symbol=symbol, symbolSize=2.2 * self.dot_size(),
            symbolBrush=colour, symbolPen=None,
        )  # fmt: skip
        self._legend.addItem(line, SHORT[workflow])
