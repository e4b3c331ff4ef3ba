"""The table of a plan: a row per range, at the largest angle that is usable there."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHeaderView, QWidget

from app.core.planning import BOUNDS
from app.services.plan_texts import tell_range
from app.services.planning import Plan, RangePlan
from widgets.common.fact_table import FactTable
from widgets.common.numbers import UNKNOWN, show_count, show_number

BINDS = " *"
"""Behind the number whose limit a steeper leaf exceeds first."""


class PlanTable(FactTable):
    """Ranges with angle, footprint, points, full hits and ghosts; the position stands out."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", (), parent, ())
        right = Qt.AlignmentFlag.AlignRight
        titles = (
            self.tr("Range\n(m)"), self.tr("ω ≤\n(°)"), self.tr("D\n(mm)"), self.tr("Points"),
            self.tr("Full\nhits"), self.tr("Ghosts\n(%)"),
        )  # fmt: skip
        self.setAccessibleName(self.tr("Largest usable angle at each range"))
        self.title_columns(titles, (right,) * len(titles))
        self.explain_columns(
            self.tr("Distance from the scanner to the leaf, metres"),
            self.tr("Largest usable angle of incidence, degrees; the rest of the row is there"),
            self.tr("Major axis of the beam's footprint on the leaf, mm"),
            self.tr("Beams whose middle falls on the leaf"),
            self.tr("Beams that fall wholly on the leaf"),
            self.tr("Share of ghosts among the leaf's points, %"),
        )
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.setWordWrap(False)
        # The panel scrolls: a table that scrolls within would hide half of its rows.
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def show_plan(self, plan: Plan, here: RangePlan) -> None:
        """Show a plan; `here` is the row of the position."""
        rows = [_list_texts(row, row is here) for row in plan.rows]
        self.show_rows(rows, [tell_range(row) for row in plan.rows])
        self._mark(plan.rows.index(here))
        head = self.horizontalHeader().sizeHint().height()
        below = sum(self.rowHeight(row) for row in range(self.rowCount()))
        self.setFixedHeight(head + below + 2 * self.frameWidth())

    def _mark(self, row: int) -> None:
        """Bold, not only in another colour."""
        self.selectRow(row)
        for column in range(self.columnCount()):
            item = self.item(row, column)
            if item is not None:
                font = item.font()
                font.setBold(True)
                item.setFont(font)


def _list_texts(row: RangePlan, here: bool) -> tuple[str, ...]:
    binds = {bound: BINDS if bound == row.bound else "" for bound in BOUNDS}
    return (
        show_number(row.range_m, 2 if here else 1),
        UNKNOWN if row.largest_deg is None else f"{int(row.largest_deg + 1e-9)}",
        show_number(row.footprint_mm, 1) + binds["footprint"],
        show_count(round(row.points)),
        show_count(round(row.full_hits)) + binds["full hits"],
        show_number(100.0 * row.ghosts, 0) + binds["ghosts"],
    )
