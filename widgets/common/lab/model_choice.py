"""Which angular model: those of the papers, then the user's own formulas."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QMenu, QSizePolicy, QToolButton, QWidget

from app.core.fitting.single import AnyModel
from app.core.phase import MODELS, PhaseModel
from app.core.phase.angular import AngularModel
from app.core.phase.formula_model import FormulaModel
from app.services.curves import DEFAULT_MODEL
from widgets.icons import draw_icon

NEW = ""
TOOL_TIP = 3


class ModelChoice(QWidget):
    """A list of models with a menu for the user's own.

    Signals
    -------
    changed()
        The user chose another model.
    new_asked()
    edit_asked(FormulaModel), delete_asked(FormulaModel)
        Something shall happen to a formula of the user.
    """

    changed = Signal()
    new_asked = Signal()
    edit_asked = Signal(object)
    delete_asked = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._models: dict[str, AnyModel] = {}
        self._own: dict[str, AnyModel] = {}
        self.box = QComboBox(self)
        self.more = QToolButton(self)
        self.menu = QMenu(self.more)
        self.box.setAccessibleName(self.tr("Model"))
        self.box.setToolTip(self.tr("The formula of the curve"))
        self.box.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.new = self.menu.addAction(self.tr("&New formula model…"))
        self.edit = self.menu.addAction(self.tr("&Edit this formula…"))
        self.delete = self.menu.addAction(self.tr("&Delete this formula"))
        self.more.setMenu(self.menu)
        self.more.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.more.setAccessibleName(self.tr("Formula models"))
        self.more.setToolTip(self.tr("Make, edit and delete your own formula models"))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.box, 1)
        row.addWidget(self.more)
        self.box.activated.connect(self._on_activated)
        self.new.triggered.connect(self.new_asked)
        self.edit.triggered.connect(self._on_edit)
        self.delete.triggered.connect(self._on_delete)
        self._dress()
        self._name = DEFAULT_MODEL
        self.offer({})

    @property
    def model(self) -> AnyModel:
        """The chosen model."""
        return self._models[self._name]

    def offer(self, own: Mapping[str, AnyModel]) -> None:
        """List the models of the papers and the user's own; the chosen one stays if it can."""
        if self._models and self._own == dict(own):
            return
        chosen = self._models.get(self._name)
        self._own = dict(own)
        self._models = {**MODELS, **own}
        if self._name not in self._models:
            self._name = DEFAULT_MODEL
        elif isinstance(chosen, FormulaModel) and self._name in own:
            self._models[self._name] = own[self._name]
        self._list()

    def show_model(self, model: AngularModel) -> None:
        """Show a model without a signal; a formula that is not the user's joins the list."""
        if not isinstance(model, (PhaseModel, FormulaModel)):
            return
        if self._models.get(model.name) != model:
            self._models[model.name] = model
            self._name = model.name
            self._list()
        self._name = model.name
        self.box.setCurrentIndex(self.box.findData(model.name))
        self._enable()

    def choose(self, name: str) -> None:
        """Make the model of that name the chosen one, without a signal."""
        if name in self._models:
            self.show_model(self._models[name])

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Draw the symbol in the colours of the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _dress(self) -> None:
        self.more.setIcon(draw_icon("ph.dots-three-outline-vertical"))

    def _list(self) -> None:
        self.box.clear()
        for name, model in self._models.items():
            if name not in MODELS and self.box.count() == len(MODELS):
                self.box.insertSeparator(self.box.count())
            self.box.addItem(model.title, name)
            self.box.setItemData(self.box.count() - 1, model.formula, TOOL_TIP)
        self.box.insertSeparator(self.box.count())
        self.box.addItem(self.tr("New formula model…"), NEW)
        self.box.setCurrentIndex(self.box.findData(self._name))
        self._enable()

    def _enable(self) -> None:
        own = self._name in self._own
        for action in (self.edit, self.delete):
            action.setEnabled(own)

    def _on_activated(self, place: int) -> None:
        name = self.box.itemData(place)
        if name == NEW:
            self.box.setCurrentIndex(self.box.findData(self._name))
            self.new_asked.emit()
        elif name is not None:
            self._name = name
            self._enable()
            self.changed.emit()

    def _on_edit(self) -> None:
        self.edit_asked.emit(self.model)

    def _on_delete(self) -> None:
        self.delete_asked.emit(self.model)
