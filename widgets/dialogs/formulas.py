"""A user's own indices: write, rename, remove; wavelengths become the nearest channels."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt, QTimer
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.core.arrays import Ints
from app.core.errors import LeafscopeError
from app.core.formula import FUNCTIONS
from app.core.formula_wavelengths import FAR_NM
from app.core.progress import Progress
from app.model.parameters import Formula
from app.services.formula_values import FormulaValues, nearest_channel, try_formula
from app.services.formulas import check_name, pick_channels, put_formula, remove_formula
from widgets.common.aside import copy_aside
from widgets.common.numbers import NumberField, count_decimals, show_count, show_number
from widgets.controller import Controller
from widgets.dialogs.formula_edit import FormulaEdit

LOWEST_NM, HIGHEST_NM = 100.0, 9999.0
PAUSE_MS = 200


class FormulasDialog(QDialog):
    """Own indices of the current scan."""

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("formulas")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Own indices"))
        self._controller, self._scan = controller, controller.current or ""
        self._asked = 0
        self.list = QListWidget(self)
        self.name = QLineEdit(self)
        self.text = FormulaEdit(self)
        self.wavelength = NumberField(LOWEST_NM, HIGHEST_NM, 1, "nm", self)
        self.nearest, self.verdict, self.values = (QLabel(self) for _ in range(3))
        self.insert_button = QPushButton(self.tr("&Insert"), self)
        self.new_button = QPushButton(self.tr("&New"), self)
        self.remove_button = QPushButton(self.tr("&Remove"), self)
        self.save_button = QPushButton(self.tr("&Save"), self)
        self._later = QTimer(self, singleShot=True, interval=PAUSE_MS)
        self._later.timeout.connect(self._try)
        self._explain()
        self._lay_out()
        self._connect()
        self._follow_document()
        self._start()

    @property
    def chosen(self) -> str:
        """Name of the index that is being changed; empty for a new one."""
        item = self.list.currentItem()
        return "" if item is None else str(item.data(Qt.ItemDataRole.UserRole))

    @property
    def formula(self) -> Formula:
        """What is written in the fields."""
        return Formula(self.name.text().strip(), self.text.text().strip())

    def save(self) -> None:
        """Put the index to use, as one step; under another name it is renamed."""
        project, formula, own = self._controller.project, self.formula, self.chosen
        if self._controller.attempt(lambda: put_formula(project, self._scan, formula, own)):
            self._choose(formula.name)

    def remove(self) -> None:
        """Take the chosen index out of use, as one step."""
        project, own = self._controller.project, self.chosen
        if own:
            self._controller.attempt(lambda: remove_formula(project, self._scan, own))

    def new(self) -> None:
        """Begin another index."""
        self.list.setCurrentRow(-1)
        self._show_chosen()
        self.name.setFocus()

    def done(self, result: int) -> None:
        """Stop listening before the window goes."""
        self._later.stop()
        self._asked += 1  # what is still being tried comes too late
        self._controller.document_changed.disconnect(self._follow_document)
        super().done(result)

    def _start(self) -> None:
        state = self._controller.project.state.scan(self._scan)
        known = [nm for nm in state.wavelengths.values() if nm is not None]
        self.wavelength.setValue(known[0] if known else 1064.0)
        self.text.offer([*(channel.name for channel in state.channels), *FUNCTIONS])
        if self.list.count():
            self.list.setCurrentRow(0)
        self._show_chosen()
        self._show_nearest()

    def _follow_document(self, _: object = None) -> None:
        if self._scan not in self._controller.project.state.scans:
            self.reject()
            return
        formulas = self._controller.project.state.scan(self._scan).parameters.formulas
        shown = [(formula.name, f"{formula.name} = {formula.text}") for formula in formulas]
        items = [self.list.item(row) for row in range(self.list.count())]
        if [(i.data(Qt.ItemDataRole.UserRole), i.text()) for i in items] == shown:
            return
        kept = self.chosen
        with QSignalBlocker(self.list):
            self.list.clear()
            for name, text in shown:
                item = QListWidgetItem(text, self.list)
                item.setData(Qt.ItemDataRole.UserRole, name)
                item.setToolTip(text)
        self._choose(kept)

    def _choose(self, name: str) -> None:
        for row in range(self.list.count()):
            if self.list.item(row).data(Qt.ItemDataRole.UserRole) == name:
                self.list.setCurrentRow(row)
        self._show_chosen()

    def _show_chosen(self, *_: object) -> None:
        formulas = self._controller.project.state.scan(self._scan).parameters.formulas
        found = next((f for f in formulas if f.name == self.chosen), Formula("", ""))
        self.name.setText(found.name)
        self.text.setText(found.text)
        self.remove_button.setEnabled(bool(found.name))
        self._check()

    def _show_nearest(self, *_: object) -> None:
        try:
            pick = nearest_channel(self._controller.project, self._scan, self.wavelength.value())
        except LeafscopeError as error:
            self.nearest.setText(error.what)
            self.insert_button.setEnabled(False)
            return
        far = self.tr(", far from it") if pick.distance_nm > FAR_NM else ""
        self.nearest.setText(
            self.tr("{symbol}: nearest is {channel}, {nm} nm, {distance} nm off{far}").format(
                symbol=pick.symbol, channel=pick.channel, nm=f"{pick.nm:g}",
                distance=f"{pick.distance_nm:g}", far=far,
            )
        )  # fmt: skip
        self.insert_button.setEnabled(True)

    def _insert(self) -> None:
        pick = nearest_channel(self._controller.project, self._scan, self.wavelength.value())
        self.text.insert_name(pick.symbol)

    def _check(self, *_: object) -> None:
        """Say what is wrong, or which channels stand for wavelengths; try it on the points."""
        formula, project = self.formula, self._controller.project
        self._asked += 1
        self.values.clear()
        if not formula.text:
            self.verdict.setText(self.tr("Write e.g. (r1063 - r1545) / (r1063 + r1545)."))
            self.save_button.setEnabled(False)
            return
        try:
            picks = pick_channels(project, self._scan, formula.text)
            words = "; ".join(pick.words for pick in picks) or self.tr("The formula is in order.")
            trouble = ""
            self._later.start()
            check_name(project, self._scan, formula.name, self.chosen)
        except LeafscopeError as error:
            trouble = str(error)
            words = f"⚠ {trouble}"
        formulas = project.state.scan(self._scan).parameters.formulas
        self.verdict.setText(words)
        self.save_button.setEnabled(not trouble and formula not in formulas)

    def _try(self) -> None:
        """Values on the current leaf, or the whole scan, in the background."""
        project, text = self._controller.project, self.formula.text
        leaf = project.state.leaves.get(self._controller.view.leaf or "")
        on_leaf = leaf is not None and leaf.scan == self._scan
        points: Ints | None = leaf.members.indices if leaf is not None and on_leaf else None
        where = leaf.name if leaf is not None and on_leaf else self.tr("whole scan")
        aside, asked, scan = copy_aside(project, self._scan), self._asked, self._scan

        def work(progress: Progress) -> FormulaValues | LeafscopeError:
            try:
                return try_formula(aside, scan, text, points, progress)
            except LeafscopeError as error:
                return error

        def done(found: FormulaValues | LeafscopeError) -> None:
            if asked == self._asked:
                self._show_values(where, found)

        self._controller.run(self.tr("Trying {0}").format(text), work, done)

    def _show_values(self, where: str, found: FormulaValues | LeafscopeError) -> None:
        if isinstance(found, LeafscopeError):
            self.values.setText(f"⚠ {found}")
            return
        if not found.count:
            self.values.setText(self.tr("{0}: no point has a value.").format(where))
            return
        decimals = 1 + count_decimals(found.mean, found.sd if np.isfinite(found.sd) else None)
        mean, sd, low, high = (
            show_number(v, decimals) for v in (found.mean, found.sd, found.low, found.high)
        )
        text = self.tr("{where}: mean {mean}, sd {sd}, {low} to {high}; {n} points, {m} without")
        self.values.setText(
            text.format(where=where, mean=mean, sd=sd, low=low, high=high,
                        n=show_count(found.count), m=show_count(found.undefined))
        )  # fmt: skip

    def _explain(self) -> None:
        told = (
            (self.list, self.tr("Own indices"), self.tr("Indices of this scan; choose one to "
                                                        "change it")),
            (self.name, self.tr("Name of the index"),
             self.tr("Letters, digits and _; it becomes a field of that name")),
            (self.text, self.tr("Formula"),
             self.tr("Channels by name, or by wavelength as r1063 or r564_3; + − * / ** and "
                     "functions: {0}").format(", ".join(FUNCTIONS))),
            (self.wavelength, self.tr("Wavelength, nm"),
             self.tr("Wavelength to look for (100–9999 nm)")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)
        self.insert_button.setToolTip(self.tr("Put the wavelength into the formula"))
        self.new_button.setToolTip(self.tr("Begin another index"))
        self.remove_button.setToolTip(self.tr("Take the index out; can be undone"))
        self.save_button.setToolTip(self.tr("Put the index to use or rename it; can be undone"))
        self.save_button.setProperty("primary", "true")
        for label in (self.nearest, self.verdict, self.values):
            label.setWordWrap(True)
            label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        picker = QHBoxLayout()
        picker.addWidget(self.wavelength)
        picker.addWidget(self.insert_button)
        picker.addStretch(1)
        form = QGridLayout()
        form.setColumnStretch(1, 1)
        for row, (title, widget) in enumerate(
            (
                (self.tr("N&ame"), self.name),
                (self.tr("&Formula"), self.text),
                (self.tr("&Wavelength"), self.wavelength),
            )
        ):
            label = QLabel(title, self)
            label.setBuddy(widget)
            form.addWidget(label, row, 0)
        form.addWidget(self.name, 0, 1)
        form.addWidget(self.text, 1, 1)
        form.addLayout(picker, 2, 1)
        for row, told in enumerate((self.nearest, self.verdict, self.values), 3):
            form.addWidget(told, row, 1)
        buttons = QHBoxLayout()
        for button in (self.new_button, self.remove_button):
            buttons.addWidget(button)
        buttons.addStretch(1)
        buttons.addWidget(self.save_button)
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        box.rejected.connect(self.reject)
        for button in self.findChildren(QPushButton):
            button.setAutoDefault(False)  # Enter in a field must not close or remove
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.addWidget(self.list, 1)
        column.addLayout(form)
        column.addLayout(buttons)
        column.addWidget(box)
        self.resize(38 * em, 30 * em)

    def _connect(self) -> None:
        self.list.currentItemChanged.connect(self._show_chosen)
        self.name.textChanged.connect(self._check)
        self.text.textChanged.connect(self._check)
        self.wavelength.valueChanged.connect(self._show_nearest)
        self.insert_button.clicked.connect(self._insert)
        self.new_button.clicked.connect(self.new)
        self.remove_button.clicked.connect(self.remove)
        self.save_button.clicked.connect(self.save)
        self._controller.document_changed.connect(self._follow_document)
