"""Table of b, k_d and m, each with its error from the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from app.model.corrections import Correction
from widgets.common.correct.words import list_numbers
from widgets.common.fact_table import FactTable

RIGHT, LEFT = Qt.AlignmentFlag.AlignRight, Qt.AlignmentFlag.AlignLeft
MOST_ROWS = 5


class NumbersTable(FactTable):
    """A row per correction; as high as it needs, up to a few rows."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", ("", "", "b", "k_d", "m"), parent, (LEFT, LEFT, RIGHT, RIGHT, RIGHT))
        self.setAccessibleName(self.tr("Numbers of the corrections"))
        self.setHorizontalHeaderLabels([self.tr("For"), self.tr("By"), "b", "k_d", "m"])
        self.setWordWrap(False)
        self.explain_columns(
            self.tr("The leaf that it is for, or all points"),
            self.tr("Workflow"),
            self.tr("b: how steeply intensity falls with ω; WF3 takes 1, as of a Lambertian"),
            self.tr("k_d: diffuse share of the return"),
            self.tr("m: roughness of the surface"),
        )
        self.setToolTip(self.tr("± is the standard deviation from the fit"))

    def show_corrections(self, corrections: Sequence[Correction], names: Mapping[str, str]) -> None:
        """Show corrections of one channel; `names` are those of leaves."""
        rows, tips = list_numbers(corrections, names)
        self.show_rows(rows, tips)
        self.setVisible(bool(rows))
        self.resizeRowsToContents()
        high = sum(self.rowHeight(k) for k in range(min(len(rows), MOST_ROWS)))
        self.setFixedHeight(self.horizontalHeader().sizeHint().height() + high + 4)
