"""The user's own formula models in the window: listed, made, changed, deleted."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QMessageBox, QWidget

from app.core.errors import BadInput
from app.core.phase.formula_model import FormulaModel, make_formula_model
from app.services.lab.own_models import delete_own, list_own
from widgets.common.lab.model_choice import ModelChoice
from widgets.common.lab.series import Series
from widgets.controller import Controller
from widgets.dialogs.formula_model import FormulaModelDialog


class OwnFormulas(QObject):
    """Keeps the list of models in step with the folder of the user.

    Signals
    -------
    changed()
        A model was made, changed or deleted.
    """

    changed = Signal()

    def __init__(self, controller: Controller, choice: ModelChoice, panel: QWidget) -> None:
        super().__init__(panel)
        self._controller, self._choice, self._panel = controller, choice, panel
        self._read = False
        self._series = Series("")
        self._title = ""
        choice.new_asked.connect(self.make)
        choice.edit_asked.connect(self.edit)
        choice.delete_asked.connect(self.ask_delete)

    def offer(self, anew: bool = False) -> None:
        """List the models of the folder; it is read once, and when it was written to."""
        if self._read and not anew:
            return
        self._read = True
        own = list_own()
        self._choice.offer({name: make_formula_model(d) for name, d in own.models.items()})
        if own.faults:
            error = BadInput(
                self.tr("Some formula models cannot be read: {0}").format(" ".join(own.faults))
            )
            self._controller.failed.emit(error)

    def show_preview(self, series: Series, title: str) -> None:
        """Say which points the dialog draws its curve over."""
        self._series, self._title = series, title

    def make(self) -> None:
        """Ask for a new model."""
        self._open(None)

    def edit(self, model: FormulaModel) -> None:
        """Ask how a model shall be changed."""
        self._open(model)

    def ask_delete(self, model: FormulaModel) -> None:
        """Ask whether a model shall be deleted: this cannot be undone."""
        box = QMessageBox(
            QMessageBox.Icon.Question,
            self.tr("Delete formula model"),
            self.tr("Delete the formula model {0}?").format(model.name),
            QMessageBox.StandardButton.Cancel,
            self._panel,
        )
        box.setInformativeText(
            self.tr("This cannot be undone. Fits and curves made with it keep their formula.")
        )
        delete = box.addButton(self.tr("&Delete"), QMessageBox.ButtonRole.DestructiveRole)
        delete.clicked.connect(partial(self._delete, model.name))
        box.finished.connect(box.deleteLater)
        box.open()

    def _delete(self, name: str, _: bool = False) -> None:
        if self._controller.attempt(lambda: delete_own(name)):
            self.offer(anew=True)
            self.changed.emit()

    def _open(self, before: FormulaModel | None) -> None:
        dialog = FormulaModelDialog(self._series, self._title, before, self._panel)
        dialog.saved.connect(self._take)
        dialog.open()

    def _take(self, model: FormulaModel, before: str) -> None:
        if before and before != model.name:
            self._controller.attempt(lambda: delete_own(before))
        self.offer(anew=True)
        self._choice.show_model(model)
        self.changed.emit()
