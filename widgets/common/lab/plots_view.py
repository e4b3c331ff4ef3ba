"""Plot and tool row as one."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QVBoxLayout, QWidget

from widgets.common.angular_plot import AngularPlot
from widgets.common.lab.brush import BrushKind
from widgets.common.lab.series import Series, Shape
from widgets.common.lab.tool_row import ToolRow

KINDS: dict[str, BrushKind] = {"angles": "angles", "values": "values", "both": "both"}


class PlotsView(QWidget):
    """Shows series; moves the curve of the first and nothing else when a slider asks for it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.tools = ToolRow(self)
        self.plot = AngularPlot(self.tr("Intensity against incidence angle"), self)
        self.series: tuple[Series, ...] = ()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(self.fontMetrics().height() // 4)
        layout.addWidget(self.tools)
        layout.addWidget(self.plot, 1)
        self.tools.strip_toggled.connect(self.plot.show_strip)
        self.tools.all_asked.connect(self.plot.show_all)
        self.tools.cleared.connect(self.plot.cleared)
        self.tools.armed.connect(self._arm)

    def show_series(self, series: Sequence[Series], title: str) -> None:
        """Show series; `title` names their values with the unit."""
        self.series = tuple(series)
        self.plot.title_axis("left", title)
        self.plot.show_series(series)

    def move_curve(self, shape: Shape | None) -> None:
        """Draw another curve for the first series."""
        self.plot.move_curve(shape)

    def _arm(self, kind: str) -> None:
        self.plot.box.arm(KINDS.get(kind))
