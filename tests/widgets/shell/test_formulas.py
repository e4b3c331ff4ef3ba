"""The dialog for own indices: written with keys, tried at once, renamed and removed by undo."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from app.model.parameters import Formula
from widgets.dialogs.formulas import FormulasDialog
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
Put = Callable[..., str]
LEFT = Qt.MouseButton.LeftButton
NDI = "(r1063 - r1550) / (r1063 + r1550)"


def open_dialog(shell: MainWindow) -> FormulasDialog:
    shell.table.actions["scan.own_indices"].trigger()
    (dialog,) = shell.findChildren(FormulasDialog)
    return dialog


def write(dialog: FormulasDialog, name: str, text: str) -> None:
    for line, words in ((dialog.name, name), (dialog.text, text)):
        line.setFocus()
        line.selectAll()
        QTest.keyClicks(line, words)
    dialog.text.completion.popup().hide()


def formulas(shell: MainWindow) -> tuple[Formula, ...]:
    return shell.controller.scan.parameters.formulas


def test_it_is_written_renamed_removed_and_undone(
    shell: MainWindow, put_scan: Put, qtbot: QtBot
) -> None:
    put_scan(shell)
    dialog = open_dialog(shell)
    assert not dialog.save_button.isEnabled()
    write(dialog, "mine", NDI)
    assert "reflectance_1545 (1545 nm, 5 nm off)" in dialog.verdict.text()
    qtbot.mouseClick(dialog.save_button, LEFT)
    assert formulas(shell) == (Formula("mine", NDI),)
    assert dialog.chosen == "mine"
    write(dialog, "water", NDI)
    qtbot.mouseClick(dialog.save_button, LEFT)
    assert formulas(shell) == (Formula("water", NDI),)
    assert [dialog.list.item(i).text() for i in range(dialog.list.count())] == [f"water = {NDI}"]
    qtbot.mouseClick(dialog.remove_button, LEFT)
    assert formulas(shell) == ()
    for expected in ("water", "mine"):
        shell.controller.undo()
        assert [f.name for f in formulas(shell)] == [expected]
    dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs)


def test_its_values_are_those_of_the_points(shell: MainWindow, put_scan: Put, qtbot: QtBot) -> None:
    put_scan(shell)
    dialog = open_dialog(shell)
    write(dialog, "mine", NDI)
    qtbot.waitUntil(lambda: "whole scan" in dialog.values.text(), timeout=20_000)
    attributes = shell.controller.scan.scan.attributes
    a, b = (attributes[f"reflectance_{nm}"].astype(float) for nm in (1063, 1545))
    value = (a - b) / (a + b)
    assert f"mean {value.mean():.3f}".replace("-", "−") in dialog.values.text()
    assert f"sd {value.std(ddof=1):.3f}" in dialog.values.text()
    assert "576 points, 0 without" in dialog.values.text()
    dialog.reject()


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("mine", "r1063 - oak", "oak"),
        ("mine", "r1063 -", "⚠"),
        ("mine", "__import__('os')", "⚠"),
        ("mine", "r1063 / r1060", "both nearest"),
        ("ndi", NDI, "a field already"),
        ("2nd", NDI, "no name of an index"),
        ("", NDI, "has no name"),
    ],
)
def test_what_is_wrong_is_said(
    shell: MainWindow, put_scan: Put, qtbot: QtBot, name: str, text: str, said: str
) -> None:
    put_scan(shell)
    dialog = open_dialog(shell)
    write(dialog, name, text)
    if not name:
        dialog.name.clear()
    assert said in dialog.verdict.text()
    assert not dialog.save_button.isEnabled()
    dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs)


def test_a_wavelength_finds_its_channel(shell: MainWindow, put_scan: Put, qtbot: QtBot) -> None:
    put_scan(shell)
    dialog = open_dialog(shell)
    dialog.wavelength.setFocus()
    dialog.wavelength.selectAll()
    QTest.keyClicks(dialog.wavelength, "1540.5")
    QTest.keyClick(dialog.wavelength, Qt.Key.Key_Return)
    assert "reflectance_1545, 1545 nm, 4.5 nm off" in dialog.nearest.text()
    qtbot.mouseClick(dialog.insert_button, LEFT)
    assert dialog.text.text() == "r1540_5"
    dialog.wavelength.setValue(900.0)
    assert "far from it" in dialog.nearest.text()
    dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs)


def test_names_are_completed(shell: MainWindow, put_scan: Put, qtbot: QtBot) -> None:
    put_scan(shell)
    dialog: Any = open_dialog(shell)
    dialog.text.setFocus()
    QTest.keyClicks(dialog.text, "1 + reflectance_15")
    completion = dialog.text.completion
    assert completion.currentCompletion() == "reflectance_1545"
    completion.activated.emit(completion.currentCompletion())
    assert dialog.text.text() == "1 + reflectance_1545"
    completion.popup().hide()
    dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs)
