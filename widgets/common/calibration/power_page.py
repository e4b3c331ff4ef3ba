"""The laser's power in this scan, from a leaf that lies on a panel of known reflectance."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.core.progress import Progress
from app.model.fields import Same
from app.model.parameters import ScanPower
from app.services.laser_power import power_from_panel, use_powers
from app.services.scan_panels import guess_reflectance
from widgets.common.aside import copy_aside
from widgets.common.calibration.profile_words import is_power
from widgets.common.fact_grid import FactGrid
from widgets.common.leaf_table import colour_of_leaf
from widgets.common.notice import Notice
from widgets.common.numbers import NumberField, show_with_sd
from widgets.controller import Controller


class PowerPage(QWidget):
    """Measures the power from a panel; a button puts it to use."""

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._measured: tuple[ScanPower, ...] = ()
        self._measured_for: tuple[object, ...] = ()
        self._shown_leaf = ""
        self.notice = Notice(self)
        self.in_use = FactGrid(self)
        self.leaf = QComboBox(self)
        self.rho = NumberField(0.0, 1.5, 4, "", self)
        self.sigma = NumberField(0.0, 1.0, 4, "", self)
        self.measure_button = QPushButton(self.tr("&Measure power"), self)
        self.found = FactGrid(self)
        self.use_button = QPushButton(self.tr("&Use this power"), self)
        self.reset_button = QPushButton(self.tr("&Back to 1"), self)
        self._explain()
        self._lay_out()
        self.leaf.activated.connect(self._choose_leaf)
        self.rho.valueChanged.connect(self._forget)
        self.sigma.valueChanged.connect(self._forget)
        self.measure_button.clicked.connect(self.measure)
        self.use_button.clicked.connect(self.use)
        self.reset_button.clicked.connect(self.reset)

    def refresh(self) -> None:
        """Show the powers in use, and the leaves that can be panels."""
        state, key = self._controller.scan, self._controller.current
        leaves = self._controller.project.state.leaves_of(key) if key is not None else ()
        missing = self._find_missing(len(leaves))
        self.notice.say(missing)
        self.body.setVisible(not missing)
        if state is None or missing:
            return
        profile = state.parameters.profile
        said = {power.channel: power for power in state.parameters.powers}
        names = [c.name for c in profile.channels if any(map(is_power, c.steps))] if profile else []
        self.in_use.show_facts((name, self._tell(said.get(name))) for name in names)
        self.reset_button.setEnabled(bool(said))
        self._fill([(leaf.key, leaf.name) for leaf in leaves])
        mark = (
            key,
            Same(profile),
            Same(state.scan),
            Same(state.deleted),
            state.parameters.beam,
            state.parameters.partial_hits,
        )
        if mark != self._measured_for:
            self._measured_for = mark
            self._forget()

    def measure(self) -> None:
        """Find the power in the background."""
        controller, key = self._controller, self._controller.current
        leaf = controller.project.state.leaves.get(str(self.leaf.currentData()))
        if key is None or leaf is None:
            return
        aside, points = copy_aside(controller.project, key), leaf.members.indices
        rho, sigma, name = self.rho.value(), self.sigma.value(), leaf.name
        mark = self._measured_for

        def work(progress: Progress) -> tuple[ScanPower, ...]:
            return power_from_panel(aside, key, points, rho, sigma, name, progress)

        def done(powers: tuple[ScanPower, ...]) -> None:
            if mark == self._measured_for and (rho, sigma) == (
                self.rho.value(),
                self.sigma.value(),
            ):
                self._measured = powers
                self._show_measured()

        controller.run(self.tr("Measuring the laser's power"), work, done)

    def use(self) -> None:
        """Put the measured powers to use, as one step."""
        self._put(self._measured)

    def reset(self) -> None:
        """Go back to the power at which the profile was made."""
        self._put(())

    def _put(self, powers: tuple[ScanPower, ...]) -> None:
        key = self._controller.current
        if key is not None:
            self._controller.attempt(lambda: use_powers(self._controller.project, key, powers))

    def _find_missing(self, leaves: int) -> str:
        state = self._controller.scan
        profile = None if state is None else state.parameters.profile
        if profile is None:
            return self.tr("The laser's power is told against a profile: open or make one first.")
        if not any(is_power(step) for c in profile.channels for step in c.steps):
            return self.tr("The profile in use was made without the power of the laser.")
        if leaves == 0:
            return self.tr(
                "Draw around a panel of known reflectance with the lasso: it becomes a leaf, and "
                "tells the laser's power in this scan."
            )
        return ""

    def _fill(self, leaves: Sequence[tuple[str, str]]) -> None:
        box = self.leaf
        if [(box.itemData(i), box.itemText(i)) for i in range(box.count())] == leaves:
            return
        kept = box.currentData()
        with QSignalBlocker(box):
            box.clear()
            for key, name in leaves:
                box.addItem(name, key)
                box.setItemData(
                    box.count() - 1, colour_of_leaf(key), Qt.ItemDataRole.DecorationRole
                )
            wanted = kept if box.findData(kept) >= 0 else self._controller.view.leaf
            box.setCurrentIndex(max(box.findData(wanted), 0))
        self._choose_leaf()

    def _choose_leaf(self, _: int = 0) -> None:
        """A name that tells a reflectance puts it into the field."""
        if str(self.leaf.currentData()) == self._shown_leaf:
            return
        self._shown_leaf = str(self.leaf.currentData())
        guess = guess_reflectance(self.leaf.currentText())
        if guess is not None:
            self.rho.setValue(guess)
        self._forget()

    def _forget(self, _: object = None) -> None:
        self._measured = ()
        self._show_measured()

    def _show_measured(self) -> None:
        self.found.show_facts((power.channel, self._tell(power)) for power in self._measured)
        self.found.setVisible(bool(self._measured))
        self.use_button.setEnabled(bool(self._measured))
        self.measure_button.setEnabled(self.rho.value() > 0.0)

    def _tell(self, power: ScanPower | None) -> str:
        if power is None:
            return self.tr("1, as when the profile was made")
        text = show_with_sd(power.value, power.sigma)
        return f"{text} ({power.origin})" if power.origin else text

    def _explain(self) -> None:
        told = (
            (self.leaf, self.tr("Reference panel"),
             self.tr("A leaf of this scan that lies on the panel")),
            (self.rho, self.tr("Reflectance of the panel"),
             self.tr("Known reflectance of the panel as a fraction (0–1.5)")),
            (self.sigma, self.tr("σ of the panel's reflectance"),
             self.tr("How sure the reflectance of the panel is (0–1)")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)
        self.measure_button.setToolTip(self.tr("Mean over the panel's full hits"))
        self.use_button.setToolTip(self.tr("Divide this power out; can be undone"))
        self.reset_button.setToolTip(self.tr("Take the power for that of the profile again"))
        self.use_button.setProperty("primary", "true")

    def _lay_out(self) -> None:
        self.leaf.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        heading = QLabel(self.tr("In use"), self)
        form = QFormLayout()
        form.addRow(self.tr("&Panel"), self.leaf)
        form.addRow(self.tr("&Reflectance"), self.rho)
        form.addRow(self.tr("± &σ"), self.sigma)
        buttons = QHBoxLayout()
        for button in (self.use_button, self.reset_button):
            buttons.addWidget(button)
        buttons.addStretch(1)
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addWidget(heading)
        inner.addWidget(self.in_use)
        inner.addLayout(form)
        inner.addWidget(self.measure_button)
        inner.addWidget(self.found)
        inner.addLayout(buttons)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.notice)
        layout.addWidget(self.body)
