"""A text file whose columns were not understood is opened by naming them."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialogButtonBox, QPushButton
from pytestqt.qtbot import QtBot

from widgets.dialogs.text_layout import TextLayoutDialog
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
LINES = "56 0 -0.15 0.0 0.69 255\n57 0 -0.20 0.0 0.64 254\n58 0 -0.23 0.0 0.59 253\n"


def name(dialog: TextLayoutDialog, *names: str) -> None:
    for column, text in enumerate(names):
        dialog.rows.item(0, column).setText(text)


def press_open(dialog: TextLayoutDialog, qtbot: QtBot) -> None:
    button = dialog.buttons.button(QDialogButtonBox.StandardButton.Open)
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def test_a_refused_header_is_named_by_hand(
    window: MainWindow, tmp_path: Path, qtbot: QtBot
) -> None:
    path = tmp_path / "bad.txt"
    path.write_text("X,Y,X\n0,0,1\n.5,.5,2\n1.5,.5,3\n")
    window.documents.open([path])
    qtbot.waitUntil(
        lambda: any(b.text() == "Name the columns…" for b in window.findChildren(QPushButton)),
        timeout=20_000,
    )
    ask = next(b for b in window.findChildren(QPushButton) if b.text() == "Name the columns…")
    qtbot.mouseClick(ask, Qt.MouseButton.LeftButton)
    dialog = window.findChild(TextLayoutDialog)
    able = dialog.buttons.button(QDialogButtonBox.StandardButton.Open)
    assert not able.isEnabled()
    assert "names no z" in dialog.word.text()
    name(dialog, "x", "y", "z")
    assert able.isEnabled()
    press_open(dialog, qtbot)
    qtbot.waitUntil(lambda: window.controller.current is not None, timeout=20_000)
    assert window.controller.scan.scan.xyz.tolist() == [[0, 0, 1], [0.5, 0.5, 2], [1.5, 0.5, 3]]


def test_a_wrong_guess_is_corrected_and_the_unit_given(
    window: MainWindow, tmp_path: Path, qtbot: QtBot
) -> None:
    path = tmp_path / "sphere.xyz"
    path.write_text(LINES)
    window.documents.open([path])
    qtbot.waitUntil(lambda: window.controller.current is not None, timeout=20_000)
    assert window.controller.scan.scan.xyz[0].tolist() == [56, 0, -0.15]
    window.table.actions["scan.columns"].trigger()
    dialog = window.findChild(TextLayoutDialog)
    name(dialog, "row", "column", "x", "y", "z", "intensity")
    dialog.unit.setCurrentIndex(2)
    press_open(dialog, qtbot)
    qtbot.waitUntil(lambda: window.controller.current == "scan-00002", timeout=20_000)
    scan = window.controller.scan.scan
    assert scan.xyz[0] == pytest.approx([-0.15e-3, 0.0, 0.69e-3])
    assert scan.channels[0].name == "intensity"
    assert window.controller.project.state.scans["scan-00001"].closed


def test_prose_says_why_there_is_no_table(qtbot: QtBot, tmp_path: Path) -> None:
    path = tmp_path / "prose.txt"
    path.write_text("This is a story without numbers.\n")
    dialog = TextLayoutDialog(path)
    qtbot.addWidget(dialog)
    assert dialog.rows.rowCount() == 0
    assert "no line of three numbers" in dialog.word.text()
