"""The row of tools above the plot: brushes, what is shown, what leaves the window."""

from __future__ import annotations

from PySide6.QtCore import QEvent, Signal
from PySide6.QtWidgets import QButtonGroup, QHBoxLayout, QMenu, QToolButton, QWidget

from widgets.common.lab.brush import BrushKind
from widgets.icons import draw_icon


class ToolRow(QWidget):
    """Small buttons; the brushes exclude one another, and none means: move the plot.

    Signals
    -------
    armed(str)
        Kind of the brush, empty for none.
    cleared(), all_asked(), strip_toggled(bool), map_toggled(bool)
    """

    armed = Signal(str)
    cleared = Signal()
    all_asked = Signal()
    strip_toggled = Signal(bool)
    map_toggled = Signal(bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hand = self._button("ph.hand", self.tr("Move the plot"))
        self.angles = self._button(
            "ph.arrows-out-line-horizontal", self.tr("Select a range of angles")
        )
        self.values = self._button(
            "ph.arrows-out-line-vertical", self.tr("Select a range of intensities")
        )
        self.both = self._button("ph.selection", self.tr("Select a rectangle"))
        self.clear = self._button("ph.selection-slash", self.tr("Select nothing"), False)
        self.all = self._button("ph.corners-out", self.tr("Show all"), False)
        self.strip = self._button("ph.rows", self.tr("Residuals"))
        self.map = self._button("ph.cube", self.tr("Residuals in 3-D"))
        self.export = self._button("ph.export", self.tr("Export"), False)
        self._explain()
        self.menu = QMenu(self.export)
        self.export.setMenu(self.menu)
        self.export.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._group = QButtonGroup(self)
        self._arrange()
        self._connect()
        self._dress()

    def arm(self, kind: BrushKind | None) -> None:
        """Show which brush is in hand."""
        button = {"angles": self.angles, "values": self.values, "both": self.both}.get(kind or "")
        (button or self.hand).setChecked(True)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Draw the symbols in the colours of the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _button(self, icon: str, name: str, checkable: bool = True) -> QToolButton:
        button = QToolButton(self)
        button.setProperty("symbol", icon)
        button.setAccessibleName(name)
        button.setCheckable(checkable)
        return button

    def _explain(self) -> None:
        keys = self.tr(" Shift adds, Ctrl takes away, Esc or a double click clears.")
        angles = self.tr("Drag over a range of angles: its points are selected everywhere.")
        values = self.tr("Drag over a range of intensities: its points are selected everywhere.")
        both = self.tr("Drag a rectangle: its points are selected everywhere.")
        for button, tip in (
            (self.hand, self.tr(
                "Drag moves the plot; the wheel zooms at the cursor, over an axis along it alone. "
                "With a brush in hand the right or the middle button moves the plot. Home shows "
                "all."
            )),
            (self.angles, angles + keys),
            (self.values, values + keys),
            (self.both, both + keys),
            (self.clear, self.tr("Select nothing (Esc, or a double click on the plot)")),
            (self.all, self.tr("Show all points and 0° to 90° (Home)")),
            (self.strip, self.tr("Show below the plot what the means leave over from the curve")),
            (self.map, self.tr(
                "Colour the 3-D view by what each point leaves over from the curve in use. The "
                "curve shown here is put to use for it."
            )),
            (self.export, self.tr("Copy or write the figure and the fits")),
        ):  # fmt: skip
            button.setToolTip(tip)

    def _arrange(self) -> None:
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        brushes = (self.hand, self.angles, self.values, self.both)
        for number, button in enumerate(brushes):
            button.setProperty("segment", "first" if number == 0 else "middle")
            self._group.addButton(button)
            row.addWidget(button)
        self.both.setProperty("segment", "last")
        self.hand.setChecked(True)
        self.strip.setChecked(True)
        for button in (self.clear, self.all):
            row.addWidget(button)
        row.addStretch(1)
        for button in (self.strip, self.map, self.export):
            row.addWidget(button)

    def _connect(self) -> None:
        self._group.buttonClicked.connect(self._on_brush)
        self.clear.clicked.connect(self.cleared)
        self.all.clicked.connect(self.all_asked)
        self.strip.toggled.connect(self.strip_toggled)
        self.map.clicked.connect(self.map_toggled)

    def _on_brush(self, button: QToolButton) -> None:
        kinds = {self.angles: "angles", self.values: "values", self.both: "both"}
        self.armed.emit(kinds.get(button, ""))

    def _dress(self) -> None:
        for button in self.findChildren(QToolButton):
            button.setIcon(draw_icon(button.property("symbol")))
