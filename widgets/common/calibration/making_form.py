"""What a calibration is made of: where the panels are, which channel, which model, which limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.core.radiometry.calibration import Wishes
from app.core.radiometry.models import RANGE_EFFECTS, RESPONSES, CalibrationModel
from app.core.radiometry.profile import MOST_MARGIN
from app.services.calibrate import Naming
from widgets.common.numbers import NumberField

From = Literal["scan", "scans", "table"]
LONGEST_NM, FARTHEST, LARGEST_DN = 12_000.0, 10_000.0, 1e7
UNSET = -LARGEST_DN
SENTENCES = {
    "log": "The DN rises by the same step for each tenfold reflectance (FARO). Two panels or more.",
    "linear": "The DN rises in proportion to the reflectance, from an offset on (Leica). Two "
              "panels or more.",
    "proportional": "The DN is a gain times the reflectance (FGI HSL). One panel is enough.",
    "salca": "Steep for dark targets, flat for bright ones, with a knee between (SALCA). Panels "
             "on both sides of the knee.",
    "": "Panels and targets are at one range, or the instrument took the range out itself.",
    "inverse-square": "Light falls with the square of the range, as from an ideal instrument.",
    "polynomial": "Lines or parabolas through the DN of panels at three ranges or more.",
    "spline": "A smooth curve through the DN of panels at three ranges or more.",
    "analytic": "SALCA's formula with an overlap term; a fixed panel in every scan.",
    "analytic-inner": "The same formula, with its power inside the exponential.",
}  # fmt: skip


class MakingForm(QWidget):
    """Asks for a model and what belongs to it.

    Signals
    -------
    changed()
        The user chose something else.
    table_asked()
        A file with a table is wanted.
    """

    changed = Signal()
    table_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.source, self.channel, self.response, self.effect = (QComboBox(self) for _ in range(4))
        self.table_button = QPushButton(self.tr("Choose a ta&ble…"), self)
        self.table_words, self.response_words, self.effect_words = (QLabel(self) for _ in range(3))
        self.wavelength = NumberField(0.0, LONGEST_NM, 1, "nm", self)
        self.more = QToolButton(self)
        self.limits = QWidget(self)
        self.reference = NumberField(0.0, FARTHEST, 3, "m", self)
        self.margin = NumberField(0.0, MOST_MARGIN, 3, "m", self)
        self.dark = NumberField(UNSET, LARGEST_DN, 1, "DN", self)
        self.saturated = NumberField(UNSET, LARGEST_DN, 1, "DN", self)
        self._proposed: dict[NumberField, float] = {}
        self.any_range = QCheckBox(self.tr("It holds at an&y range"), self)
        self.name = QLineEdit(self)
        self._fill()
        self._explain()
        self._lay_out()
        self._connect()
        self._tell()

    @property
    def origin(self) -> From:
        """Where the panels are."""
        found: From = self.source.currentData()
        return found

    @property
    def model(self) -> CalibrationModel:
        """The model that is chosen."""
        effect = self.effect.currentData()
        return CalibrationModel(
            RESPONSES[self.response.currentData()], RANGE_EFFECTS[effect] if effect else None
        )

    @property
    def naming(self) -> Naming:
        """What the profile is called, and where it holds."""
        anywhere = self.any_range.isChecked() and self.any_range.isEnabled()
        name = self.name.text().strip()
        return Naming(name, margin=self.margin.value(), any_range=anywhere)

    @property
    def wishes(self) -> Wishes:
        """Limits and the reference range."""
        return Wishes(
            reference_range=self.reference.value() or None,
            dark=_read(self.dark),
            saturated=_read(self.saturated),
        )

    def offer_channels(self, channels: Sequence[tuple[str, str]]) -> None:
        """Offer channels, names and titles; the one that is chosen stays if it is among them."""
        box = self.channel
        if [(box.itemData(i), box.itemText(i)) for i in range(box.count())] == list(channels):
            return
        kept = box.currentData()
        box.clear()
        for name, title in channels:
            box.addItem(title, name)
        box.setCurrentIndex(max(box.findData(kept), 0))

    def ask_wavelength(self, wanted: bool) -> None:
        """Ask for the wavelength, or not."""
        self._form.setRowVisible(self.wavelength, wanted)

    def show_limits(self, dark: float | None, saturated: float | None) -> None:
        """Put the ends of the instrument's scale, where nobody typed others."""
        for field, value in ((self.dark, dark), (self.saturated, saturated)):
            if field.value() == self._proposed.get(field, UNSET):
                field.setValue(UNSET if value is None else value)
                self._proposed[field] = field.value()

    def show_table(self, words: str) -> None:
        """Say which table was chosen."""
        self.table_words.setText(words)
        self.table_words.setVisible(bool(words) and self.origin == "table")

    def _fill(self) -> None:
        for title, data in (
            (self.tr("Panels drawn in this scan"), "scan"),
            (self.tr("Panels drawn in all open scans"), "scans"),
            (self.tr("A table (CSV)"), "table"),
        ):
            self.source.addItem(title, data)
        for part in RESPONSES.values():
            self.response.addItem(self.tr(part.title), part.name)
        self.effect.addItem(self.tr("None"), "")
        for part in RANGE_EFFECTS.values():
            self.effect.addItem(self.tr(part.title), part.name)
        self.more.setText(self.tr("Limits and reference"))
        self.more.setCheckable(True)
        self.more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._show_limits(False)
        self.wavelength.setSpecialValueText(self.tr("unknown"))
        self.reference.setSpecialValueText(self.tr("as the panels"))
        self.margin.setSpecialValueText(self.tr("none"))
        self.name.setPlaceholderText(self.tr("as the scan or table"))
        for field in (self.dark, self.saturated):
            field.setSpecialValueText(self.tr("no limit"))
            field.setValue(UNSET)

    def _explain(self) -> None:
        told = (
            (self.source, self.tr("Panels from"), self.tr("Where panels of known reflectance are")),
            (self.channel, self.tr("Channel"), self.tr("The raw values that are calibrated")),
            (self.wavelength, self.tr("Wavelength, nm"),
             self.tr("Wavelength of the channel, which names its reflectance, nm")),
            (self.response, self.tr("Response"), self.tr("How the DN follows the light")),
            (self.effect, self.tr("Range effect"), self.tr("How the light follows the range")),
            (self.more, self.tr("Limits and reference"),
             self.tr("Reference range, limits of the scale, ranges where it holds")),
            (self.reference, self.tr("Reference range, m"),
             self.tr("Range at which the range effect is none, m")),
            (self.margin, self.tr("Holds beyond the panels by, m"),
             self.tr("How far beyond the panels' ranges the profile is to hold as well, m; with "
                     "none, points outside are marked and get no value")),
            (self.any_range, self.tr("It holds at any range"),
             self.tr("The instrument has taken the effect of range out itself")),
            (self.dark, self.tr("Dark up to, DN"), self.tr("At and below this DN nothing is told")),
            (self.saturated, self.tr("Saturated from, DN"),
             self.tr("At and above this DN nothing is told")),
            (self.name, self.tr("Name of the profile"), self.tr("What the profile is called")),
            (self.table_button, self.tr("Choose a table"),
             self.tr("Columns: range, DN, reflectance; scan, panel and σ where there are some")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)
        for label in (self.table_words, self.response_words, self.effect_words):
            label.setWordWrap(True)
            label.setProperty("faint", "true")

    def _lay_out(self) -> None:
        for box in (self.source, self.channel, self.response, self.effect):
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            box.setSizeAdjustPolicy(policy)
            box.setMinimumContentsLength(12)
        self._form = QFormLayout()
        self._form.setContentsMargins(0, 0, 0, 0)
        self._form.addRow(self.tr("&From"), self.source)
        self._form.addRow(self.table_button)
        self._form.addRow(self.table_words)
        self._form.addRow(self.tr("&Channel"), self.channel)
        self._form.addRow(self.tr("&Wavelength"), self.wavelength)
        self._form.addRow(self.tr("Re&sponse"), self.response)
        self._form.addRow(self.response_words)
        self._form.addRow(self.tr("Ran&ge"), self.effect)
        self._form.addRow(self.effect_words)
        rows = QFormLayout(self.limits)
        rows.setContentsMargins(0, 0, 0, 0)
        rows.addRow(self.tr("Reference range"), self.reference)
        rows.addRow(self.tr("Holds beyond by"), self.margin)
        rows.addRow(self.any_range)
        rows.addRow(self.tr("Dark up to"), self.dark)
        rows.addRow(self.tr("Saturated from"), self.saturated)
        rows.addRow(self.tr("Name of the profile"), self.name)
        line = QHBoxLayout()
        line.addWidget(self.more)
        line.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(self._form)
        layout.addLayout(line)
        layout.addWidget(self.limits)

    def _connect(self) -> None:
        self.more.toggled.connect(self._show_limits)
        self.table_button.clicked.connect(self.table_asked)
        for box in (self.source, self.channel, self.response, self.effect):
            box.activated.connect(self._on_choice)
        for field in (self.wavelength, self.reference, self.margin, self.dark, self.saturated):
            field.valueChanged.connect(self._on_choice)

    def _show_limits(self, shown: bool) -> None:
        self.limits.setVisible(shown)
        arrows = Qt.ArrowType
        self.more.setArrowType(arrows.DownArrow if shown else arrows.RightArrow)

    def _on_choice(self, _: object) -> None:
        self._tell()
        self.changed.emit()

    def _tell(self) -> None:
        self._form.setRowVisible(self.table_button, self.origin == "table")
        self._form.setRowVisible(self.channel, self.origin != "table")
        self.table_words.setVisible(self.origin == "table" and bool(self.table_words.text()))
        self.any_range.setEnabled(not self.model.fits_range)
        for box, label in (
            (self.response, self.response_words),
            (self.effect, self.effect_words),
        ):
            data = box.currentData()
            label.setText(self.tr(SENTENCES[data]))
            part = RESPONSES.get(data) or RANGE_EFFECTS.get(data)
            label.setToolTip("" if part is None else f"{part.formula}\n{part.source}")


def _read(field: NumberField) -> float | None:
    return None if field.value() == UNSET else field.value()
