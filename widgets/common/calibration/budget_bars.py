"""What makes a reflectance unsure, as bars: one per part, and all together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from widgets.common.plots import Plot, mix

LINES = 9


class BudgetBars(Plot):
    """Lying bars in percent of reflectance, the total in the accent colour."""

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        super().__init__(name, "", "", parent)
        self.title_axis("bottom", self.tr("σ of the reflectance (%)"))
        self.setMinimumHeight(self.fontMetrics().height() * LINES)
        self.setMouseEnabled(x=False, y=False)
        self.shares: dict[str, float] = {}
        self._bars = pg.BarGraphItem(x0=[0.0], y=[0.0], height=0.6, width=[0.0])
        self._labels: list[pg.TextItem] = []
        self.addItem(self._bars)

    def show_parts(self, parts: Mapping[str, float], total: float) -> None:
        """Show σ of each part, a fraction, with their titles; the total comes last."""
        self.shares = {name: 100.0 * value for name, value in parts.items()}
        self.shares[self.tr("all together")] = 100.0 * total
        self._draw()

    def restyle(self) -> None:
        """Draw in the new colours."""
        super().restyle()
        if getattr(self, "shares", None):
            self._draw()

    def _draw(self) -> None:
        names, values = list(self.shares), np.array(list(self.shares.values()))
        places = np.arange(len(names))[::-1].astype(float)
        quiet = mix(self.ink, self.palette().base().color(), 0.45)
        brushes = [pg.mkBrush(quiet)] * (len(names) - 1) + [pg.mkBrush(QColor(self.accent))]
        self._bars.setOpts(
            x0=np.zeros(len(names)),
            y=places,
            width=np.nan_to_num(values),
            height=0.62,
            brushes=brushes,
            pen=None,
        )
        axis = self.getAxis("left")
        axis.setTicks([list(zip(places, names, strict=True))])
        top = max(float(np.nanmax(values, initial=0.0)), 1e-9)
        self.setXRange(0.0, 1.28 * top, padding=0.0)
        self.setYRange(-0.6, len(names) - 0.4, padding=0.0)
        for label in self._labels:
            self.removeItem(label)
        self._labels = [
            pg.TextItem(self._write(value), self.ink, anchor=(0, 0.5)) for value in values
        ]
        for label, value, place in zip(self._labels, values, places, strict=True):
            label.setPos(float(np.nan_to_num(value)), float(place))
            self.addItem(label)

    def _write(self, percent: float) -> str:
        if not np.isfinite(percent):
            return str(self.tr("unknown"))
        return f"{percent:#.2g}" if percent else "0"
