"""Page: an index against the angle, its range and its amplitude, leaf by leaf."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.core.phase import MODELS
from app.services.index_angle import IndexAngles
from app.services.index_angle_files import OF_SCAN
from widgets.common.fact_table import FactTable
from widgets.common.index.angle_plot import IndexAnglePlot
from widgets.common.index.export_button import ExportButton
from widgets.common.index.words import list_cells, tell_leaf

RIGHT, LEFT = Qt.AlignmentFlag.AlignRight, Qt.AlignmentFlag.AlignLeft
MOST_ROWS = 9


class AnglePage(QWidget):
    """Shows what was found; the row that is chosen in the table is drawn.

    Signals
    -------
    changed()
        Another model was chosen.
    export_asked(str)
    """

    changed = Signal()
    export_asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.found: IndexAngles | None = None
        self.model_box = QComboBox(self)
        for model in MODELS.values():
            self.model_box.addItem(model.title, model.name)
        self.model_box.setCurrentIndex(self.model_box.findData(OF_SCAN))
        self.plot = IndexAnglePlot(self)
        titles = (self.tr("Leaf"), self.tr("Mean"), self.tr("A ± 95 %"), self.tr("> noise"))
        self.table = FactTable(self.tr("Leaves"), titles, self, (LEFT, RIGHT, RIGHT, LEFT))
        self.words = QLabel(self)
        self.export = ExportButton(
            (
                ("rows.csv", self.tr("Leaves (CSV)…")),
                ("curves.csv", self.tr("Curves (CSV)…")),
                ("table.tex", self.tr("Table (LaTeX)…")),
                ("picture.png", self.tr("Picture (PNG)…")),
                ("picture.svg", self.tr("Picture (SVG)…")),
                ("picture.pdf", self.tr("Picture (PDF)…")),
            ),
            self,
        )
        self._explain()
        self._lay_out()
        self.model_box.activated.connect(self._on_model)
        self.table.currentCellChanged.connect(self._draw)
        self.export.asked.connect(self.export_asked)

    @property
    def model(self) -> str:
        """Model that is fitted to the channels."""
        return str(self.model_box.currentData())

    @property
    def leaf(self) -> str:
        """Name of the leaf that is drawn."""
        row = max(self.table.currentRow(), 0)
        if self.found is None or row >= len(self.found.rows):
            return ""
        return str(self.found.rows[row].get("leaf", ""))

    def show_found(self, found: IndexAngles) -> None:
        """Show leaves; the one that was drawn stays if it is still there."""
        before, self.found = self.leaf, found
        names = [str(row.get("leaf", "")) for row in found.rows]
        cells = [list_cells(name, row) for name, row in zip(names, found.rows, strict=True)]
        tips = [tell_leaf(n, found.index.name, row) for n, row in zip(names, found.rows,
                                                                     strict=True)]  # fmt: skip
        with QSignalBlocker(self.table):  # it is drawn once, below
            self.table.show_rows(cells, tips)
        line = self.table.verticalHeader().defaultSectionSize()
        head = self.table.horizontalHeader().sizeHint().height()
        self.table.setFixedHeight(head + min(len(cells), MOST_ROWS) * line + 4)
        with QSignalBlocker(self.table):
            self.table.selectRow(names.index(before) if before in names else 0)
        self._draw()

    def _draw(self, *_: int) -> None:
        if self.found is None or not self.found.rows:
            return
        name = self.leaf
        rows = [row for row in self.found.curves if row.get("leaf", "") == name]
        self.plot.show_curves(rows, self.found.index.name)
        row = self.found.rows[max(self.table.currentRow(), 0)]
        words = [tell_leaf(name, self.found.index.name, row)]
        words += [f"⚠ {text}" for text in self.found.warnings if text.startswith(f"{name}:")]
        self.words.setText("\n".join(words))

    def _explain(self) -> None:
        self.model_box.setAccessibleName(self.tr("Curve"))
        self.model_box.setToolTip(
            self.tr("Fitted to each channel; the index is taken of the fitted channels")
        )
        self.table.explain_columns(
            self.tr("Click a row to draw that leaf"),
            self.tr("Mean of the index of all points"),
            self.tr("Amplitude of y = A·cos 2ω + ν: half the swing from 0° to 90° "
                    "(Hancock 2017, table I), ± half its 95 % interval, as if points were "
                    "independent"),
            self.tr("Whether noise alone gives such an amplitude in fewer than 5 % of cases"),
        )  # fmt: skip
        self.table.setWordWrap(False)
        self.words.setWordWrap(True)
        self.words.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)

    def _lay_out(self) -> None:
        self.model_box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        form = QFormLayout()
        form.addRow(self.tr("C&urve"), self.model_box)
        last = QHBoxLayout()
        last.addWidget(self.export)
        last.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(form)
        layout.addWidget(self.plot)
        layout.addWidget(self.words)
        layout.addWidget(self.table)
        layout.addLayout(last)

    def _on_model(self, _: int) -> None:
        self.changed.emit()
