"""How a curve is fitted: to points, to means, or to their upper edge."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QSizePolicy, QWidget

from app.model.fit_method import WHOLE_SCAN, Method
from widgets.common.numbers import NumberField

WAYS = {
    "points": Method(),
    "huber": Method(loss="huber"),
    "tukey": Method(loss="tukey"),
    "bins": Method("bins"),
    "edge": Method("edge"),
}


class MethodChoice(QWidget):
    """A list of ways with the one number that some of them need beside it.

    Signals
    -------
    changed()
        The user chose something else.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.box = QComboBox(self)
        self.width_field = NumberField(0.5, 45.0, 1, "°", self)
        self.quantile = NumberField(0.5, 0.999, 3, "", self)
        self._whole = False
        self._fill()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for widget in (self.box, self.width_field, self.quantile):
            row.addWidget(widget)
        row.setStretch(0, 1)
        self._show_number()
        self.box.activated.connect(self._on_way)
        self.width_field.valueChanged.connect(self._on_number)
        self.quantile.valueChanged.connect(self._on_number)

    @property
    def method(self) -> Method:
        """The way that is chosen, with its number."""
        way = str(self.box.currentData())
        if way == "bins":
            angles = WHOLE_SCAN.angles if self._whole else Method().angles
            return Method("bins", width=self.width_field.value(), angles=angles)
        if way == "edge":
            return Method("edge", tau=self.quantile.value())
        return WAYS[way]

    def suit(self, whole: bool) -> None:
        """Propose means for a whole scan, points for leaves; without a signal."""
        if whole == self._whole:
            return
        self._whole = whole
        if str(self.box.currentData()) in ("points", "bins"):
            self.box.setCurrentIndex(self.box.findData("bins" if whole else "points"))
            self._show_number()

    def _fill(self) -> None:
        for title, way, tip in (
            (self.tr("Points"), "points", self.tr("Every point counts alike: least squares")),
            (self.tr("Points, Huber"), "huber",
             self.tr("Points far from the curve count less: for some stray points")),
            (self.tr("Points, Tukey"), "tukey",
             self.tr("Points far from the curve do not count: for many stray points")),
            (self.tr("Means per step"), "bins",
             self.tr("Means per step of the angle, weighted by how well each is known")),
            (self.tr("Upper edge"), "edge",
             self.tr("The curve that leaves a share of the points below it")),
        ):  # fmt: skip
            self.box.addItem(title, way)
            self.box.setItemData(self.box.count() - 1, tip, 3)
        self.box.setAccessibleName(self.tr("How it is fitted"))
        self.box.setToolTip(self.tr("What the curve is fitted to, and how far points count"))
        self.box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        for field, value, step, name, tip in (
            (self.width_field, 5.0, 1.0, self.tr("Width of a step, degrees"),
             self.tr("Width of a step of the angle, 0.5° to 45°")),
            (self.quantile, 0.95, 0.01, self.tr("Share of the points below the edge"),
             self.tr("Share of the points below the edge, 0.5 to 0.999")),
        ):  # fmt: skip
            field.setStepType(NumberField.StepType.DefaultStepType)
            field.setSingleStep(step)
            field.setValue(value)
            field.setAccessibleName(name)
            field.setToolTip(tip)

    def _show_number(self) -> None:
        self.width_field.setVisible(self.box.currentData() == "bins")
        self.quantile.setVisible(self.box.currentData() == "edge")

    def _on_way(self, _: int) -> None:
        self._show_number()
        self.changed.emit()

    def _on_number(self, _: float) -> None:
        self.changed.emit()
