"""What the scan adds to the curve: nothing, a number, or what levels each leaf with its plane."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QWidget

from app.services.wrinkles.request import FitOffset
from app.services.wrinkles.scale import ChannelScale
from widgets.common.numbers import NumberField

NONE, TYPED, FITTED = "none", "typed", "fit"
MOST_ADDED = 100_000.0


class OffsetForm(QWidget):
    """The offset; its unit is that of the channel: DN or dB added, or a factor.

    Signals
    -------
    changed()
        The user chose something else.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.box = QComboBox(self)
        self.added = NumberField(-MOST_ADDED, MOST_ADDED, 1, "DN", self)
        self.factor = NumberField(0.001, 1000.0, 3, "×", self)
        self.factor.setValue(1.0)
        self._log = False
        self._chosen = NONE
        self._fill()
        self._explain()
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for field in (self.box, self.added, self.factor):
            layout.addWidget(field, 1)
        self.box.activated.connect(self._on_change)
        self.added.valueChanged.connect(self._on_change)
        self.factor.valueChanged.connect(self._on_change)
        self._suit()

    @property
    def offset(self) -> FitOffset | float | None:
        """What a request says."""
        kind = self.box.currentData()
        if kind == TYPED:
            return self.added.value() if self._log else self.factor.value()
        return "fit" if kind == FITTED else None

    def follow(self, scale: ChannelScale | None, unit: str, settled: str = "") -> None:
        """Take over the scale of the channel, and what is settled by the curve already.

        Parameters
        ----------
        scale : ChannelScale or None
            None: nobody knows it.
        unit : str
            Of the channel, DN or dB.
        settled : str
            NONE or FITTED: the curve leaves no choice; "": the user's choice counts.
        """
        known = scale is not None and scale.told
        self._log = scale is not None and scale.scale == "log"
        self.added.setSuffix(f" {unit or 'DN'}")
        model = self.box.model()
        if isinstance(model, QStandardItemModel):
            model.item(self.box.findData(TYPED)).setEnabled(known)
        if not known and self._chosen == TYPED:
            self._chosen = NONE
        with QSignalBlocker(self.box):
            self.box.setCurrentIndex(self.box.findData(settled or self._chosen))
        self.setEnabled(not settled)
        self._suit()

    def _suit(self) -> None:
        typed = self.box.currentData() == TYPED
        self.added.setVisible(typed and self._log)
        self.factor.setVisible(typed and not self._log)

    def _on_change(self, *_: object) -> None:
        self._chosen = str(self.box.currentData())
        self._suit()
        self.changed.emit()

    def _fill(self) -> None:
        for title, kind, tip in (
            (self.tr("None"), NONE, self.tr("The curve is that of the scan")),
            (self.tr("Typed"), TYPED,
             self.tr("What the scan adds to the curve, or by which factor it is brighter; needs "
                     "a channel whose scale is known")),
            (self.tr("Fitted to each leaf"), FITTED,
             self.tr("The leaf's mean becomes its plane's angle: only Δω is claimed then")),
        ):  # fmt: skip
            self.box.addItem(title, kind)
            self.box.setItemData(self.box.count() - 1, tip, 3)

    def _explain(self) -> None:
        self.box.setAccessibleName(self.tr("Offset"))
        self.box.setToolTip(self.tr("Between the curve and this scan, e.g. the +50 DN that "
                                    "Balduzzi saw between stage and tree"))  # fmt: skip
        self.box.setMinimumContentsLength(8)
        self.box.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.added.setAccessibleName(self.tr("Offset that is added"))
        self.added.setToolTip(self.tr("Added to the curve by the scan, −100 000 to 100 000 DN "
                                      "or dB: logarithmic channels"))  # fmt: skip
        self.factor.setAccessibleName(self.tr("Factor"))
        self.factor.setToolTip(self.tr("The scan's numbers over the curve's, 0.001 to 1000: "
                                       "linear channels"))  # fmt: skip
