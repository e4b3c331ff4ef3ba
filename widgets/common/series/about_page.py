"""What a series is, and the axis about which its holder turned."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from app.core.arrays import Floats
from app.core.errors import LeafscopeError, WrongUse
from app.core.holder import Axis, FittedAxis
from app.core.progress import Progress
from app.model.project import Project
from app.model.series import HolderAxis, Series
from app.services.series.axis import as_record, parse_axis
from app.services.series.document import fit_series_axis, read_leaves, set_axis, turn_axis
from widgets.common.fact_grid import FactGrid
from widgets.common.series.axis_form import AxisForm
from widgets.common.series.words import list_facts
from widgets.controller import Controller


class AboutPage(QWidget):
    """Facts of a series, and its axis: fitted, picked, typed, or none.

    Signals
    -------
    change_asked(), forget_asked()
        The user wants to change the scans of the series, or to forget it.
    pick_asked()
        Points are to be picked in the picture.
    """

    change_asked = Signal()
    forget_asked = Signal()
    pick_asked = Signal()

    def __init__(self, controller: Controller, parent: QWidget) -> None:
        super().__init__(parent)
        self._controller = controller
        self._key = ""
        self._picked: list[Floats] = []
        self.facts = FactGrid(self)
        self.change_button = QPushButton(self.tr("C&hange…"), self)
        self.forget_button = QPushButton(self.tr("Forget"), self)
        self.axis = AxisForm(self)
        self.change_button.setToolTip(
            self.tr("Other scans, angles, times, or another reference for this series")
        )
        self.forget_button.setToolTip(self.tr("Forget the series; its scans and leaves stay"))
        buttons = QHBoxLayout()
        buttons.addWidget(self.change_button)
        buttons.addWidget(self.forget_button)
        buttons.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.facts)
        layout.addLayout(buttons)
        layout.addWidget(self.axis)
        layout.addStretch(1)
        self.change_button.clicked.connect(self.change_asked)
        self.forget_button.clicked.connect(self.forget_asked)
        self.axis.fit_asked.connect(self.fit_axis)
        self.axis.same_asked.connect(self.use_same_pose)
        self.axis.picking.connect(self._start_picking)
        self.axis.typed.connect(self.use_typed)

    @property
    def series(self) -> Series | None:
        """The series that is shown, as it is now."""
        return self._controller.project.state.series.get(self._key)

    def refresh(self, series: Series) -> None:
        """Show a series."""
        self._key = series.key
        name = self._controller.project.state.scan(series.reference).scan.name
        self.facts.show_facts(list_facts(series, name))
        leaves = bool(self._controller.project.state.leaves_of(series.reference))
        self.axis.setVisible(leaves)
        self.axis.show_series(series, len(self._picked))

    def forget(self) -> None:
        """Let go of a document that is gone."""
        self._picked, self._key = [], ""
        self.axis.pick_button.setChecked(False)

    def fit_axis(self) -> None:
        """Follow the leaves and fit the axis, in the worker."""
        series = self.series
        if series is None:
            return

        def service(aside: Project, progress: Progress) -> FittedAxis:
            reference = read_leaves(aside, series.key)
            return fit_series_axis(aside, series.key, reference, progress=progress)

        self._controller.carry_out(series.reference, self.tr("Fitting the axis"), service)

    def use_same_pose(self) -> None:
        """Carry leaves without turning them."""
        series = self.series
        if series is not None:
            project = self._controller.project
            self._controller.attempt(lambda: set_axis(project, series.key, None))

    def use_typed(self, text: str) -> None:
        """Turn leaves about an axis of six typed numbers."""
        try:
            axis = parse_axis(text)
        except LeafscopeError:
            self._controller.failed.emit(
                WrongUse(
                    self.tr("An axis is six numbers with commas between: x, y, z, dx, dy, dz."),
                    self.tr("Example, a vertical axis: 4, 0, 1.2, 0, 0, 1"),
                )
            )
            return
        self.axis.type_button.setChecked(False)
        self._turn(HolderAxis(axis.point, axis.direction, self.tr("typed")))

    def take_point(self, scan: str, row: int) -> None:
        """Take a picked point for the axis, when one is asked for; the second makes the axis."""
        if self.series is None or not self.axis.pick_button.isChecked():
            return
        self._picked.append(np.array(self._controller.project.state.scan(scan).scan.xyz[row]))
        if len(self._picked) == 2:
            first, second = self._picked
            self.axis.pick_button.setChecked(False)
            found: list[HolderAxis] = []

            def make() -> None:
                found.append(as_record(Axis.through(first, second - first), self.tr("picked")))

            if self._controller.attempt(make):
                self._turn(found[0])
        else:
            self.axis.show_series(self.series, len(self._picked))

    def _turn(self, axis: HolderAxis) -> None:
        series = self.series
        if series is None:
            return

        def service(aside: Project, _: Progress) -> HolderAxis:
            return turn_axis(aside, series.key, axis, read_leaves(aside, series.key))

        self._controller.carry_out(series.reference, self.tr("Turning leaves"), service)

    def _start_picking(self, on: bool) -> None:
        self._picked = []
        if self.series is not None:
            self.axis.show_series(self.series, 0)
        if on:
            self.pick_asked.emit()
