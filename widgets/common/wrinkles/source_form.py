"""Where the curve comes from: the scan's leaves, one leaf, a goniometer, a species, the lab."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QLabel,
    QPushButton,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.model.parameters import Curve
from app.services.wrinkles.request import (
    SCATTER,
    CurveInUse,
    OwnCurve,
    ScanCurve,
    Source,
    SpeciesSource,
    TableCurve,
)
from app.services.wrinkles.species import find_species_curve, list_species_curves
from widgets.common.numbers import NumberField

SCAN, OWN, TABLE, SPECIES, IN_USE = "scan", "own", "table", "species", "in use"
TIP = int(Qt.ItemDataRole.ToolTipRole)


class SourceForm(QObject):
    """The choice of a curve, and what that choice needs: rows of a form.

    Signals
    -------
    changed()
        The user chose something else.
    file_asked()
        A goniometer table shall be chosen: `take_file` shall be called.
    """

    changed = Signal()
    file_asked = Signal()

    def __init__(self, rows: QFormLayout, parent: QWidget) -> None:
        super().__init__(parent)
        self.path: Path | None = None
        self.touched = False
        self._rows = rows
        self._curve: Curve | None = None
        self._level, self._near = False, True
        self.box = QComboBox(parent)
        self.file_button = QPushButton(self.tr("C&hoose table…"), parent)
        self.species = QComboBox(parent)
        self.reflectance = NumberField(0.0, 2.0, 3, "", parent)
        self.scatter = NumberField(0.0, 99.0, 1, "%", parent)
        self.of_leaf = QCheckBox(self.tr("It is the lea&f's own"), parent)
        self.told = QLabel(parent)
        self._fill()
        self._explain()
        self._lay_out()
        self._connect()
        self._suit()

    @property
    def kind(self) -> str:
        """Which of the five."""
        return str(self.box.currentData())

    @property
    def lack(self) -> str:
        """What is missing before anything can be asked; empty when nothing is."""
        if self.kind == TABLE and self.path is None:
            return self.tr("Choose a goniometer table: CSV with the columns angle (°) and value.")
        if self.kind == SPECIES and not self._near:
            return self.tr("No curve of a species is printed near this channel's wavelength.")
        return ""

    def source(self) -> Source:
        """The source that is chosen."""
        scatter = self.scatter.value() / 100.0
        if self.kind == TABLE and self.path is not None:
            return TableCurve(self.path)
        if self.kind == SPECIES:
            name = str(self.species.currentData())
            return SpeciesSource(name, self.reflectance.value() or None, scatter)
        if self.kind == IN_USE:
            return CurveInUse(self.of_leaf.isChecked(), scatter)
        return OwnCurve() if self.kind == OWN else ScanCurve()

    def take_file(self, path: Path) -> None:
        """Take a goniometer table; it is read when wrinkles are measured."""
        self.path = path
        self._suit()
        self.changed.emit()

    def follow(self, curve: Curve | None, wavelength_nm: float | None, level: bool) -> None:
        """Offer what the scan has: the curve in use, species near the channel's wavelength.

        Where the offset is fitted (`level`), heights of curves are nobody's business.
        """
        self._curve, self._level = curve, level
        _offer(
            self.box, self.box.findData(IN_USE), curve is not None,
            self.tr("No curve is in use: fit one in the Phase lab and press Use this curve")
            if curve is None else self.tr("The curve of the Phase lab"),
        )  # fmt: skip
        wanted = IN_USE if curve is not None else SCAN
        if (curve is None and self.kind == IN_USE) or (
            not self.touched and self.kind in (SCAN, IN_USE)
        ):
            with QSignalBlocker(self.box):
                self.box.setCurrentIndex(self.box.findData(wanted))
        self._offer_species(wavelength_nm)
        self._suit()

    def _offer_species(self, wavelength_nm: float | None) -> None:
        near = []
        for row in range(self.species.count()):
            try:
                found = find_species_curve(str(self.species.itemData(row)), wavelength_nm)
            except LeafscopeError as error:
                _offer(self.species, row, False, str(error))
            else:
                _offer(self.species, row, True, found.title)
                near.append(row)
        self._near = bool(near)
        if near and self.species.currentIndex() not in near:
            with QSignalBlocker(self.species):
                self.species.setCurrentIndex(near[0])

    def _suit(self) -> None:
        """Show what the choice needs, and what it is."""
        kind, known = self.kind, self._level or self.of_leaf.isChecked()
        rows = (
            (self.file_button, kind == TABLE),
            (self.species, kind == SPECIES),
            (self.reflectance, kind == SPECIES and not self._level),
            (self.of_leaf, kind == IN_USE and not self._level),
            (self.scatter, (kind == SPECIES and not self._level) or (kind == IN_USE and not known)),
        )
        for field, shown in rows:
            self._rows.setRowVisible(field, shown)
        self.told.setText(self._tell())
        self._rows.setRowVisible(self.told, bool(self.told.text()))

    def _tell(self) -> str:
        if self.kind == SCAN:
            return self.tr("Fitted to the local planes of all leaves; each leaf keeps its mean.")
        if self.kind == OWN:
            return self.tr("Fitted to each leaf's local planes, which must differ by 10° or more.")
        if self.kind == TABLE:
            return self.path.name if self.path else ""
        if self.kind == SPECIES:
            return "" if self.lack else str(self.species.currentData(TIP) or "")
        curve = self._curve
        return "" if curve is None else f"{curve.model}, {curve.origin}, {curve.channel}"

    def _on_source(self, _: int) -> None:
        self.touched = True
        self._on_change()

    def _on_change(self, *_: object) -> None:
        self._suit()
        self.changed.emit()

    def _fill(self) -> None:
        for title, kind, tip in (
            (self.tr("All leaves"), SCAN,
             self.tr("One curve through all leaves of the scan; needs nothing else")),
            (self.tr("Each leaf"), OWN, self.tr("A curve through the leaf's own points")),
            (self.tr("Goniometer table"), TABLE,
             self.tr("Measured on a leaf of this kind: CSV with columns angle (°) and value")),
            (self.tr("Species"), SPECIES, self.tr("The shape that is published for a species")),
            (self.tr("Curve in use"), IN_USE, self.tr("The curve of the Phase lab")),
        ):  # fmt: skip
            self.box.addItem(title, kind)
            self.box.setItemData(self.box.count() - 1, tip, TIP)
        for name in dict.fromkeys(curve.species for curve in list_species_curves()):
            self.species.addItem(name, name)
        self.scatter.setValue(100.0 * SCATTER)
        self.reflectance.setSpecialValueText(self.tr("from the leaves"))

    def _explain(self) -> None:
        for field, name, tip in (
            (self.box, self.tr("Curve"), self.tr("Where the angular curve comes from")),
            (self.species, self.tr("Species"),
             self.tr("Greyed where nothing is printed within 60 nm of the channel")),
            (self.reflectance, self.tr("Reflectance"),
             self.tr("Of the species at ω = 0, a share from 0.001 to 2; 0: the median of this "
                     "scan's leaves by their planes")),
            (self.scatter, self.tr("Scatter of reflectance"),
             self.tr("How reflectance differs from leaf to leaf, 0 to 99 % of it")),
            (self.of_leaf, self.of_leaf.text().replace("&", ""),
             self.tr("Known for these very leaves, offset and all: ω itself is claimed then")),
            (self.file_button, self.tr("Choose table"),
             self.tr("CSV with the columns angle (0 to 90°) and value (in the channel's unit)")),
        ):  # fmt: skip
            field.setAccessibleName(name)
            field.setToolTip(tip)
        for box in (self.box, self.species):
            box.setMinimumContentsLength(10)
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
        self.told.setWordWrap(True)
        self.told.setProperty("faint", "true")

    def _lay_out(self) -> None:
        self._rows.addRow(self.tr("C&urve"), self.box)
        self._rows.addRow("", self.file_button)
        self._rows.addRow(self.tr("Spec&ies"), self.species)
        self._rows.addRow(self.tr("R&eflectance"), self.reflectance)
        self._rows.addRow("", self.of_leaf)
        self._rows.addRow(self.tr("Scatte&r"), self.scatter)
        self._rows.addRow("", self.told)

    def _connect(self) -> None:
        self.box.activated.connect(self._on_source)
        self.species.activated.connect(self._on_change)
        self.reflectance.valueChanged.connect(self._on_change)
        self.scatter.valueChanged.connect(self._on_change)
        self.of_leaf.toggled.connect(self._on_change)
        self.file_button.clicked.connect(self.file_asked)


def _offer(box: QComboBox, row: int, there: bool, tip: str) -> None:
    """Grey an entry that cannot be had; its tip says why, or what it is."""
    model = box.model()
    if isinstance(model, QStandardItemModel):
        model.item(row).setEnabled(there)
    box.setItemData(row, tip, TIP)
