"""A formula model of the user's own: text, parameters, and its curve while it is typed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.core.formula_syntax import CALLS
from app.core.phase.formula_model import FormulaDefinition, FormulaModel
from app.services.lab.own_models import check_definition, names_in, save_own
from widgets.common.angular_plot import AngularPlot
from widgets.common.lab.parameter_table import ParameterTable
from widgets.common.lab.series import Series, Shape

PREVIEW_LINES = 13


class FormulaModelDialog(QDialog):
    """Keeps the model among the user's own when it is agreed to.

    Parameters
    ----------
    series : Series
        Points to draw the curve over.
    title : str
        Of their axis.
    before : FormulaModel, optional
        A model of the user's that is to be changed.

    Signals
    -------
    saved(FormulaModel, str)
        The model, and the name that it had before (empty for a new one).
    """

    saved = Signal(object, str)

    def __init__(
        self,
        series: Series,
        title: str,
        before: FormulaModel | None = None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("formula-model")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(
            self.tr("New formula model") if before is None else self.tr("Edit formula model")
        )
        self._series = replace(series, shape=None)
        self._before = before
        self.model: FormulaModel | None = None
        self.name, self.expression = QLineEdit(self), QLineEdit(self)
        self.parameters = ParameterTable(self)
        self.verdict, self.hint = QLabel(self), QLabel(self)
        self.plot = AngularPlot(self.tr("The curve over the points"), self)
        self.plot.title_axis("left", title)
        standard = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(standard.Save | standard.Cancel, self)
        self._explain()
        self._lay_out()
        self._fill(before)
        self.name.textChanged.connect(self._check)
        self.expression.textChanged.connect(self._read)
        self.parameters.edited.connect(self._check)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)

    def accept(self) -> None:
        """Keep the model; a name that is taken is said and nothing is lost."""
        if self.model is None:
            return
        before = "" if self._before is None else self._before.name
        try:
            save_own(self.model.definition, overwrite=self.model.name == before)
        except LeafscopeError as error:
            self._say(str(error))
            return
        self.saved.emit(self.model, before)
        super().accept()

    def _fill(self, before: FormulaModel | None) -> None:
        if before is not None:
            self.name.setText(before.name)
            self.expression.setText(before.definition.expression)
            self.parameters.take(before.definition.parameters)
        self._check()

    def _read(self, text: str) -> None:
        """Find the parameters that the text names."""
        if text.strip():
            try:
                self.parameters.show_names(names_in(text))
            except LeafscopeError as error:
                self._refuse(str(error))
                return
        self._check()

    def _check(self, *_: Any) -> None:
        """Make the model of what is typed, or say why it cannot be."""
        text = self.expression.text().strip()
        if not text:
            self._refuse("")
            return
        name = self.name.text().strip()
        try:
            definition = FormulaDefinition(name or "-", text, self.parameters.read())
            model = check_definition(definition)
        except LeafscopeError as error:
            self._refuse(str(error))
            return
        self.model = model if name else None
        self._draw(model)
        self._say("" if name else self.tr("Give it a name."))

    def _refuse(self, sentence: str) -> None:
        self.model = None
        self._draw(None)
        self._say(sentence)

    def _say(self, sentence: str) -> None:
        self.verdict.setText(sentence)
        self.buttons.button(QDialogButtonBox.StandardButton.Save).setEnabled(self.model is not None)

    def _draw(self, model: FormulaModel | None) -> None:
        points = self._series.points
        size = max(abs(points.top), abs(points.bottom), 1e-12)
        shape = None if model is None else Shape(model, model.start_values(size))
        self.plot.move_curve(shape)

    def _explain(self) -> None:
        functions = ", ".join(CALLS)
        self.name.setPlaceholderText(self.tr("e.g. two slopes"))
        self.name.setToolTip(self.tr("Under which it stands in the list of models"))
        self.name.setAccessibleName(self.tr("Name of the model"))
        self.expression.setPlaceholderText("f * (k * cos(omega) + (1 - k) * cos(omega) ** n)")
        self.expression.setToolTip(
            self.tr(
                "Intensity as a formula of omega, the angle in radians; all other names become "
                "parameters"
            )
        )
        self.expression.setAccessibleName(self.tr("Formula"))
        self.hint.setText(
            self.tr("omega is the angle in radians; a power is **. Functions: {0}.").format(
                functions
            )
        )
        self.verdict.setObjectName("verdict")
        self.verdict.setProperty("fault", "true")
        self.hint.setProperty("faint", "true")
        for label in (self.verdict, self.hint):
            label.setWordWrap(True)
        self.verdict.setMinimumHeight(2 * self.fontMetrics().lineSpacing())
        self.verdict.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.verdict.setAccessibleName(self.tr("What is wrong with the formula"))
        self.buttons.button(QDialogButtonBox.StandardButton.Save).setToolTip(
            self.tr("Keep it among your own models")
        )

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        form = QFormLayout()
        form.addRow(self.tr("&Name"), self.name)
        form.addRow(self.tr("&I(ω) ="), self.expression)
        self.plot.show_strip(False)
        self.plot.setMinimumHeight(PREVIEW_LINES * em)
        self.plot.show_series((self._series,))
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.setSpacing(em // 2)
        column.addLayout(form)
        for widget in (self.verdict, self.hint, self.parameters):
            column.addWidget(widget)
        column.addWidget(self.plot, 1)
        column.addWidget(self.buttons)
        self.resize(36 * em, 42 * em)
