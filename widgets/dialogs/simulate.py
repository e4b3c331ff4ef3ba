"""Simulate a scan: which scene, with which instrument, how finely, and where to write it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QSpinBox,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.services.simulation_offers import describe_scene, list_offers
from app.services.simulation_order import Order
from app.simulate.scene_file import read_scene
from app.simulate.virtual_scan import Noise
from widgets.common.numbers import NumberField
from widgets.common.scan_cost import ScanCost
from widgets.controller import Controller
from widgets.dialogs.export import FORMATS
from widgets.dialogs.open_scan import FileDialogs

Then = Callable[[Order, Path, bool], None]
FIRST = "leaf"
LARGEST_SEED = 2**31 - 1
NOISES: tuple[tuple[Noise | None, str], ...] = (
    (None, "As the instrument's"),
    ("none", "None, of range and intensity"),
    ("white", "White: each range for itself"),
    ("filtered", "Filtered: averaged over 3 × 3 neighbours"),
)
SCENE = int(Qt.ItemDataRole.UserRole)


class SimulateDialog(QDialog):
    """Calls `then` with the order, the file to write, and whether to open it."""

    def __init__(
        self,
        controller: Controller,
        dialogs: FileDialogs,
        then: Then,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("simulate")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Simulate a scan"))
        self._dialogs, self._then = dialogs, then
        self._offers = list_offers()
        self._tools = {tool["name"]: tool for tool in self._offers["instruments"]}
        self._scenes: dict[str, dict[str, Any]] = {}
        self.scenes = QTreeWidget(self)
        self.from_file = QPushButton(self.tr("Scene from a &file…"), self)
        self.instrument = QComboBox(self)
        self.step = NumberField(0.0, 90.0, 4, "°", self)
        self.seed = QSpinBox(self)
        self.noise = QComboBox(self)
        self.format = QComboBox(self)
        self.opens = QCheckBox(self.tr("&Open it when it is done"), self)
        self.cost = ScanCost(controller, self)
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel, self)
        accept = QDialogButtonBox.ButtonRole.AcceptRole
        self.start = self.buttons.addButton(self.tr("&Simulate…"), accept)
        self._fill()
        self._explain()
        self._lay_out()
        self._connect()
        self.choose(FIRST)

    def order(self) -> Order:
        """What is asked for."""
        return Order(
            self.scene(),
            self.instrument.currentData(),
            None if self.seed.value() == self._own_seed() else self.seed.value(),
            self.step.value() or None,
            self.noise.currentData(),
        )

    def scene(self) -> str:
        """Name of the ready scene, or the file, that is chosen."""
        item = self.scenes.currentItem()
        return str(item.data(0, SCENE)) if item is not None else FIRST

    def choose(self, scene: str) -> None:
        """Choose a scene of the list."""
        rows = (self.scenes.topLevelItem(row) for row in range(self.scenes.topLevelItemCount()))
        for item in rows:
            if item is not None and item.data(0, SCENE) == scene:
                self.scenes.setCurrentItem(item)
                self.scenes.scrollToItem(item)

    def add_file(self, path: Path) -> None:
        """Put a user's scene on the list and choose it; say what is wrong with a bad one."""
        self._dialogs.folder = path.parent
        try:
            scene = read_scene(path)
        except LeafscopeError as error:
            self.cost.stop()
            self.cost.refuse(error)
            return
        self._add(describe_scene(str(path), scene) | {"title": path.name}, 0)
        self.choose(str(path))

    def accept(self) -> None:
        """Ask for the file; its dialog asks about one that exists."""
        stem = Path(self.scene()).stem
        suggested = self._dialogs.folder / f"{stem}{self.format.currentData()}"
        self._dialogs.ask_save(suggested, self._write, self)

    def done(self, result: int) -> None:
        """Close; nothing more has to be counted."""
        self.cost.stop()
        super().done(result)

    def _write(self, path: Path) -> None:
        order = self.order()
        super().accept()
        self._then(order, path, self.opens.isChecked())

    def _fill(self) -> None:
        for offer in self._offers["scenes"]:
            self._add(offer, self.scenes.topLevelItemCount())
        self.instrument.addItem("", None)
        for tool in self._offers["instruments"]:
            nm = ", ".join(f"{nm:.0f}" for nm in tool["wavelengths_nm"])
            self.instrument.addItem(f"{tool['title']} ({nm} nm)", tool["name"])
            notes = " ".join(tool["notes"])
            self.instrument.setItemData(
                self.instrument.count() - 1, notes, Qt.ItemDataRole.ToolTipRole
            )
        for noise, text in NOISES:
            self.noise.addItem(self.tr(text), noise)
        for suffix, text in FORMATS.items():
            self.format.addItem(self.tr(text), suffix)
        self.seed.setRange(0, LARGEST_SEED)
        self.seed.setKeyboardTracking(False)
        self.seed.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.opens.setChecked(True)
        self.start.setDefault(True)

    def _add(self, offer: dict[str, Any], row: int) -> None:
        self._scenes[offer["name"]] = offer
        item = QTreeWidgetItem([offer.get("title", offer["name"]), offer["description"]])
        item.setData(0, SCENE, offer["name"])
        item.setToolTip(1, offer["description"])
        self.scenes.insertTopLevelItem(row, item)

    def _explain(self) -> None:
        self.scenes.setAccessibleName(self.tr("Scene"))
        self.from_file.setToolTip(
            self.tr("A TOML file of your own; leafscope simulate --show NAME shows one to copy")
        )
        told = (
            (self.instrument, self.tr("Instrument"), self.tr("The scanner: beam, range, noise")),
            (self.step, self.tr("Step between beams, degrees"), self.tr("Step between two beams; "
             "half of it makes four times as many points")),
            (self.seed, self.tr("Seed"), self.tr("The same seed gives the same scan; "
             "another one other leaves and other noise")),
            (self.noise, self.tr("Noise"), self.tr("Noise of the range")),
            (self.format, self.tr("Format"), self.tr("The kind of file to write")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        self.scenes.setHeaderLabels([self.tr("Scene"), self.tr("What there is to see")])
        self.scenes.setRootIsDecorated(False)
        self.scenes.setUniformRowHeights(True)
        self.scenes.setAllColumnsShowFocus(True)
        self.scenes.setMinimumSize(44 * em, 9 * em)
        self.scenes.header().setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        numbers = QHBoxLayout()
        seed = QLabel(self.tr("S&eed"), self)
        seed.setBuddy(self.seed)
        numbers.addWidget(self.step, 1)
        numbers.addSpacing(em)
        numbers.addWidget(seed)
        numbers.addSpacing(em // 2)
        numbers.addWidget(self.seed, 1)
        form = QFormLayout()
        form.setHorizontalSpacing(em)
        form.addRow(self.tr("&Instrument"), self.instrument)
        step = QLabel(self.tr("S&tep"), self)
        step.setBuddy(self.step)
        form.addRow(step, numbers)
        form.addRow(self.tr("&Noise"), self.noise)
        form.addRow(self.tr("Fo&rmat"), self.format)
        form.addRow("", self.opens)
        self.cost.setMinimumHeight(3 * em)  # room for a complaint
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.setSpacing(em // 2)
        column.addWidget(self.scenes, 1)
        column.addWidget(self.from_file, 0, Qt.AlignmentFlag.AlignLeft)
        column.addLayout(form)
        column.addWidget(self.cost)
        column.addWidget(self.buttons)
        self.resize(50 * em, 40 * em)

    def _connect(self) -> None:
        self.scenes.currentItemChanged.connect(self._take_scene)
        self.from_file.clicked.connect(lambda: self._dialogs.ask_scene(self.add_file, self))
        self.instrument.currentIndexChanged.connect(self._follow)
        self.step.valueChanged.connect(self._follow)
        self.seed.valueChanged.connect(self._follow)
        self.noise.currentIndexChanged.connect(self._follow)
        self.cost.settled.connect(self.start.setEnabled)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)

    def _take_scene(self) -> None:
        """Show what the scene itself asks for."""
        own = self._own()
        title = self._tools.get(own["instrument"], {}).get("title", own["instrument"])
        self.instrument.setItemText(0, self.tr("As the scene says: {0}").format(title))
        with QSignalBlocker(self.seed):
            self.seed.setValue(self._own_seed())
        self._follow()

    def _follow(self) -> None:
        """Show the usual step, and work out what the choice costs."""
        own = self._own()
        tool = self._tools.get(self.instrument.currentData() or own["instrument"], {})
        usual = own["step_deg"] or tool.get("step_deg")
        known = f"{usual:.4g} °" if usual else self.tr("the instrument's")
        self.step.setSpecialValueText(self.tr("as usual: {0}").format(known))
        self.start.setEnabled(True)
        self.cost.ask(self.order())

    def _own_seed(self) -> int:
        seed = int(self._own()["seed"])
        return seed if seed <= LARGEST_SEED else 0  # what the box can show

    def _own(self) -> dict[str, Any]:
        return self._scenes[self.scene()]
