"""Where the scanner stood: proposed by the grid, given by the user, or unknown."""

from __future__ import annotations

from PySide6.QtCore import QLocale, Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QLabel,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from app.model.scan import Pose, Vector
from app.services.opening import propose_pose
from widgets.controller import Controller
from widgets.documents import Documents

FARTHEST = 1e8  # metres; national grids reach some 10⁷
KNOWN_BY = {
    "file": "said by the file",
    "given": "given by hand",
    "assumed": "assumed from the grid",
}


class OriginDialog(QDialog):
    """Sets the scanner position of the current scan."""

    def __init__(
        self,
        controller: Controller,
        documents: Documents,
        proposed: Pose | None = None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("origin")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._documents = documents
        self._key = controller.current or ""
        scan = controller.project.state.scan(self._key).scan
        self._proposed = proposed or propose_pose(scan)
        self.setWindowTitle(self.tr("Scanner position of {0}").format(scan.name))
        self.at = [self._coordinate(axis) for axis in "XYZ"]
        self.by_grid = QRadioButton(self._describe_proposal(), self)
        self.by_hand = QRadioButton(self.tr("At this place, in metres:"), self)
        self.unknown = QRadioButton(self.tr("Unknown"), self)
        self._lay_out(scan.pose)
        self._choose(scan.pose)

    def position(self) -> Vector:
        """What the three boxes say."""
        x, y, z = (box.value() for box in self.at)
        return x, y, z

    def accept(self) -> None:
        """Take the answer over, as one step of the history."""
        if self.by_grid.isChecked() and self._proposed is not None:
            self._documents.accept_pose(self._key, self._proposed)
        elif self.by_hand.isChecked():
            self._documents.set_origin(self._key, self.position())
        else:
            self._documents.set_origin(self._key, None)
        super().accept()

    def _choose(self, pose: Pose | None) -> None:
        if pose is not None:
            for box, value in zip(self.at, pose.position, strict=True):
                box.setValue(value)
        self.by_grid.setVisible(self._proposed is not None)
        by_grid = pose is None and self._proposed is not None
        (self.by_grid if by_grid else self.by_hand).setChecked(True)
        self.by_hand.toggled.connect(self._enable)
        self._enable(self.by_hand.isChecked())
        if not by_grid:
            self.at[0].setFocus()
            self.at[0].selectAll()

    def _enable(self, on: bool) -> None:
        for box in self.at:
            box.setEnabled(on)

    def _describe_proposal(self) -> str:
        if self._proposed is None:
            return ""
        place = ", ".join(f"{value:g}" for value in self._proposed.position)
        return self.tr(
            "At {0}, as the grid suggests: its rows and columns are\n"
            "angles about this place. It will be recorded as assumed."
        ).format(place)

    def _coordinate(self, axis: str) -> QDoubleSpinBox:
        box = QDoubleSpinBox(self)
        box.setLocale(QLocale.c())  # the same text as in files and on the command line
        box.setRange(-FARTHEST, FARTHEST)
        box.setDecimals(4)
        box.setSuffix(" m")
        box.setAccessibleName(self.tr("{0} of the scanner, metres").format(axis))
        return box

    def _lay_out(self, pose: Pose | None) -> None:
        em = self.fontMetrics().height()
        now = QLabel(self._describe(pose), self)
        now.setWordWrap(True)
        now.setMinimumWidth(26 * em)
        now.setProperty("faint", "true")
        form = QFormLayout()
        form.setContentsMargins(2 * em, 0, 0, 0)
        for axis, box in zip("XYZ", self.at, strict=True):
            form.addRow(axis, box)
        standard = QDialogButtonBox.StandardButton
        buttons = QDialogButtonBox(standard.Ok | standard.Cancel, self)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.setSpacing(em // 2)
        column.addWidget(now)
        for choice in (self.by_grid, self.by_hand):
            column.addWidget(choice)
        column.addLayout(form)
        column.addWidget(self.unknown)
        column.addStretch()
        column.addWidget(buttons)

    def _describe(self, pose: Pose | None) -> str:
        if pose is None:
            return self.tr(
                "The position is unknown. Range, incidence angle and ghost score need it."
            )
        place = ", ".join(f"{value:g}" for value in pose.position)
        return self.tr("Now: {0} m, {1}.").format(place, self.tr(KNOWN_BY[pose.known_by]))
