"""How leaves get from the reference to the other scans: same pose, or turned about an axis."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QLineEdit, QPushButton, QVBoxLayout, QWidget

from app.model.series import Series
from widgets.common.series.words import describe_motion


class AxisForm(QWidget):
    """The axis in words, and four ways to another one.

    Signals
    -------
    fit_asked(), same_asked()
    picking(bool)
        Points of the axis are (no longer) to be picked in the picture.
    typed(str)
        Six numbers, as they were typed.
    """

    fit_asked = Signal()
    same_asked = Signal()
    picking = Signal(bool)
    typed = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = QLabel(self)
        self.words.setWordWrap(True)
        self.fit_button = QPushButton(self.tr("&Fit axis"), self)
        self.same_button = QPushButton(self.tr("Same &pose"), self)
        self.pick_button = QPushButton(self.tr("Pic&k 2 points"), self)
        self.type_button = QPushButton(self.tr("&Type axis"), self)
        self.line = QLineEdit(self)
        self.line.setPlaceholderText("x, y, z, dx, dy, dz")
        self.line.setAccessibleName(self.tr("Axis as six numbers"))
        self.line.setVisible(False)
        for widget, tip in (
            (self.fit_button, self.tr("Follow the leaves from scan to scan and find the axis that "
                                      "turns them; needs the angles of the holder")),
            (self.same_button, self.tr("Nothing turned: leaves are looked for where they were")),
            (self.pick_button, self.tr("Click two points on the axis in the 3-D view")),
            (self.type_button, self.tr("Type a point of the axis and its direction")),
            (self.line, self.tr("A point in metres, x, y, z, then the direction dx, dy, dz (of any "
                                "length); Enter puts it to use")),
        ):  # fmt: skip
            widget.setToolTip(tip)
        self.pick_button.setCheckable(True)
        self.type_button.setCheckable(True)
        buttons = QGridLayout()
        four = (self.fit_button, self.same_button, self.pick_button, self.type_button)
        for place, button in enumerate(four):
            buttons.addWidget(button, place // 2, place % 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.words)
        layout.addLayout(buttons)
        layout.addWidget(self.line)
        self.fit_button.clicked.connect(self.fit_asked)
        self.same_button.clicked.connect(self.same_asked)
        self.pick_button.toggled.connect(self.picking)
        self.type_button.toggled.connect(self.line.setVisible)
        self.line.returnPressed.connect(self._on_typed)

    def show_series(self, series: Series, picked: int) -> None:
        """Show the axis of a series, and how many points have been picked."""
        words = describe_motion(series)
        if self.pick_button.isChecked():
            words = self.tr("Click two points on the axis in the picture; {n} of 2 there.").format(
                n=picked
            )
        self.words.setText(words)
        angles = {entry.angle_deg for entry in series.entries} - {None}
        self.fit_button.setEnabled(len(angles) > 1)
        self.same_button.setEnabled(series.axis is not None)

    def _on_typed(self) -> None:
        self.typed.emit(self.line.text().replace(";", ",").strip())
