"""A user's own formula model: typed, checked, kept, fitted, changed and deleted."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialogButtonBox, QMessageBox, QPushButton

from app.services.lab.own_models import list_own
from widgets.dialogs.formula_model import FormulaModelDialog
from widgets.panels.phase_lab import PhaseLabPanel

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def lab(opened, qtbot, monkeypatch, tmp_path):
    monkeypatch.setenv("LEAFSCOPE_MODELS", str(tmp_path / "models"))
    panel = opened.show(PhaseLabPanel)
    qtbot.waitUntil(lambda: panel.editor.points.count > 0, timeout=60_000)
    return panel


def open_dialog(lab, qtbot, action) -> FormulaModelDialog:
    action.trigger()
    seen = lambda: [d for d in lab.findChildren(FormulaModelDialog) if d.isVisible()]  # noqa: E731
    qtbot.waitUntil(lambda: len(seen()) == 1)
    return seen()[0]


def save_button(dialog) -> QPushButton:
    return dialog.buttons.button(QDialogButtonBox.StandardButton.Save)


def make(lab, qtbot, name="slope", text="f * (1 - b * (1 - cos(omega)))") -> None:
    dialog = open_dialog(lab, qtbot, lab.choice.models.new)
    qtbot.keyClicks(dialog.name, name)
    qtbot.keyClicks(dialog.expression, text)
    assert dialog.verdict.text() == ""
    qtbot.mouseClick(save_button(dialog), LEFT)
    qtbot.waitUntil(lambda: lab.choice.model.name == name)


def test_a_formula_is_kept_listed_and_fitted(lab, opened, qtbot) -> None:
    make(lab, qtbot)
    assert set(list_own().models) == {"slope"}
    assert lab.choice.model_box.currentText() == "slope"
    qtbot.waitUntil(lambda: set(lab.editor.values) == {"f", "b"})
    qtbot.mouseClick(lab.fit_button, LEFT)
    qtbot.waitUntil(lambda: lab.editor.result is not None, timeout=60_000)
    assert lab.editor.result.values["f"] > 0.3
    qtbot.mouseClick(lab.use_button, LEFT)
    curve = opened.controller.scan.parameters.curve
    assert curve.formula is not None
    assert curve.formula.expression == "f * (1 - b * (1 - cos(omega)))"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("f * cos(", "cannot be read"),
        ("f * 2", "does not depend on omega"),
        ("f * cos(omega) + __import__('os')", "not allowed"),
        ("f.real * omega", "dot"),
    ],
)
def test_what_cannot_be_is_said_and_not_saved(lab, qtbot, text, words) -> None:
    dialog = open_dialog(lab, qtbot, lab.choice.models.new)
    dialog.name.setText("bad")
    dialog.expression.setText(text)
    assert words in dialog.verdict.text()
    assert not save_button(dialog).isEnabled()
    dialog.reject()
    assert not list_own().models


def test_the_parameters_are_found_and_keep_what_was_typed(lab, qtbot) -> None:
    dialog = open_dialog(lab, qtbot, lab.choice.models.new)
    dialog.expression.setText("f * cos(omega)")
    table = dialog.parameters
    table.item(0, 1).setText("0.2")
    dialog.expression.setText("f * cos(omega) ** n")
    assert [table.item(row, 0).text() for row in range(table.rowCount())] == ["f", "n"]
    assert table.item(0, 1).text() == "0.2"
    table.item(1, 2).setText("many")
    assert "no number" in dialog.verdict.text()
    table.item(1, 2).setText("0.01")
    assert "usual range" in dialog.verdict.text()
    dialog.reject()


def test_a_name_that_is_taken_is_said(lab, qtbot) -> None:
    make(lab, qtbot)
    dialog = open_dialog(lab, qtbot, lab.choice.models.new)
    dialog.name.setText("slope")
    dialog.expression.setText("g * omega")
    qtbot.mouseClick(save_button(dialog), LEFT)
    assert "already" in dialog.verdict.text()
    assert dialog.isVisible()
    dialog.reject()
    assert list_own().models["slope"].expression.startswith("f *")


def test_a_formula_can_be_renamed_and_deleted(lab, qtbot) -> None:
    make(lab, qtbot)
    dialog = open_dialog(lab, qtbot, lab.choice.models.edit)
    dialog.name.setText("steeper")
    qtbot.mouseClick(save_button(dialog), LEFT)
    qtbot.waitUntil(lambda: set(list_own().models) == {"steeper"})
    assert lab.choice.model.name == "steeper"
    lab.choice.models.delete.trigger()
    box = lab.findChild(QMessageBox)
    button = next(b for b in box.buttons() if "Delete" in b.text())
    qtbot.mouseClick(button, LEFT)
    qtbot.waitUntil(lambda: not list_own().models)
    qtbot.waitUntil(lambda: lab.choice.model.name == "lambert-beckmann")
    assert not lab.choice.models.edit.isEnabled()
