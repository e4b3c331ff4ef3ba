"""Page: the spread of an index against the footprint, and the view as a wider beam sees it."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFormLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.services.synthetic_footprints import ERROR, Spread, find_reached
from widgets.common.colour_buttons import ColourButtons
from widgets.common.index.export_button import ExportButton
from widgets.common.index.size_slider import SizeSlider
from widgets.common.index.spread_plot import SpreadPlot
from widgets.common.index.words import tell_spread
from widgets.common.numbers import NumberField


class FootprintPage(QWidget):
    """Shows a spread that was measured; a slider smooths the view.

    Signals
    -------
    measure_asked()
    export_asked(str)
    """

    measure_asked = Signal()
    export_asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.found: Spread | None = None
        self.error = NumberField(0.0001, 1.0, 4, "", self)
        self.error.setValue(ERROR)
        self.measure_button = QPushButton(self.tr("&Measure the spread"), self)
        self.words = QLabel(self)
        self.plot = SpreadPlot(self)
        self.smoothing = SizeSlider(self)
        self.note = QLabel(self)
        self.colours = ColourButtons(2, self)
        self.export = ExportButton(
            (
                ("spread.csv", self.tr("Spread (CSV)…")),
                ("spread.png", self.tr("Picture (PNG)…")),
                ("spread.svg", self.tr("Picture (SVG)…")),
                ("spread.pdf", self.tr("Picture (PDF)…")),
            ),
            self,
        )
        self._lay_out()
        self.error.valueChanged.connect(self._draw)
        self.measure_button.clicked.connect(self.measure_asked)
        self.export.asked.connect(self.export_asked)
        self.show_found(None)

    @property
    def reached_mm(self) -> float | None:
        """Diameter from which on the spread stays below the error; None without one."""
        return None if self.found is None else find_reached(self.found.rows, self.error.value())

    def show_found(self, found: Spread | None) -> None:
        """Show a spread; None when none is measured for what is chosen."""
        self.found = found
        for widget in (self.plot, self.words, self.export):
            widget.setVisible(found is not None)
        self._draw()

    def _draw(self, _: float = 0.0) -> None:
        if self.found is not None:
            error, reached = self.error.value(), self.reached_mm
            self.plot.show_spread(self.found, error, reached)
            self.words.setText(tell_spread(self.found, error, reached))

    def _lay_out(self) -> None:
        self.error.setAccessibleName(self.tr("Error to be reached"))
        self.error.setToolTip(
            self.tr("Standard deviation of the index that is small enough (0.0001–1)")
        )
        self.measure_button.setToolTip(
            self.tr("Average the channels over footprints of 5 to 500 mm, then take the index")
        )
        self.measure_button.setProperty("primary", "true")
        for label in (self.words, self.note):
            label.setWordWrap(True)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        form = QFormLayout()
        form.addRow(self.tr("&Error to reach"), self.error)
        buttons = QHBoxLayout()
        buttons.addWidget(self.measure_button)
        buttons.addWidget(self.export)
        buttons.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(form)
        layout.addLayout(buttons)
        layout.addWidget(self.plot)
        layout.addWidget(self.words)
        layout.addSpacing(self.fontMetrics().height())
        layout.addWidget(self.smoothing)
        layout.addWidget(self.note)
        layout.addWidget(self.colours)
