"""Where there are too many points to draw: their density, in one ink."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor

from app.core.arrays import AnyArray
from widgets.common.angular_points import WIDEST, Cells

FAINTEST, STRONGEST = 0.08, 0.6


class InkDensity(pg.ImageItem):  # type: ignore[misc]
    """Counts per cell as strength of one colour, on a log scale; empty cells stay clear."""

    def __init__(self) -> None:
        super().__init__(axisOrder="row-major")

    def show_counts(
        self, counts: AnyArray, cells: Cells, ink: QColor, most: float | None = None
    ) -> None:
        """Show (rows, columns) counts; `most` is the count that gets the full strength."""
        top = np.log1p(counts.max() if most is None else most)
        level = np.log1p(counts) / max(float(top), 1e-12)
        strength = FAINTEST + (STRONGEST - FAINTEST) * np.minimum(level, 1.0)
        rgba = np.empty((*counts.shape, 4), np.uint8)
        rgba[..., :3] = (ink.red(), ink.green(), ink.blue())
        rgba[..., 3] = np.where(counts > 0, 255.0 * strength, 0.0).astype(np.uint8)
        self.setImage(rgba, levels=(0, 255))
        self.setRect(QRectF(0.0, cells.low, WIDEST, cells.high - cells.low))
