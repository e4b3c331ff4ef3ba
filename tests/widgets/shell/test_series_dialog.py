"""The dialog that makes a series: names, tables, typed values, doubts, memory, what it makes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit
from pytestqt.qtbot import QtBot

from app.services.series import memory
from app.services.simulation import Targets
from app.services.simulation_order import Order
from app.services.simulation_series import simulate_series
from widgets.common.series.entry_table import ANGLE, HOURS, NAME, NOTE, TREATMENT
from widgets.dialogs.series import SeriesDialog
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
ANGLES = ["-30", "0", "30"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("stage")
    simulate_series(Order("goniometer", step_deg=0.2), "stage.angle_deg=-30:30:30", Targets(out))
    return out


@pytest.fixture
def ask(shell: MainWindow, folder: Path, qtbot: QtBot) -> Iterator[Callable[[], SeriesDialog]]:
    """Ask for a series of the folder; every dialog is closed in the end."""

    def open_dialog() -> SeriesDialog:
        shell.desk.series.offer_folder(folder)
        (dialog,) = shell.findChildren(SeriesDialog)
        qtbot.waitUntil(lambda: not shell.controller.bridge.jobs, timeout=60_000)
        return dialog

    yield open_dialog
    for dialog in shell.findChildren(SeriesDialog):
        dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs, timeout=60_000)


def column(dialog: SeriesDialog, number: int) -> list[str]:
    return [dialog.table.item(row, number).text() for row in range(dialog.table.rowCount())]


def type_into(dialog: SeriesDialog, row: int, place: int, text: str) -> None:
    table = dialog.table
    table.setCurrentCell(row, place)
    table.editItem(table.item(row, place))
    editor = table.findChild(QLineEdit)
    editor.selectAll()
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)


def test_names_fill_the_table_and_make_the_series(
    ask: Callable[[], SeriesDialog], shell: MainWindow, folder: Path, qtbot: QtBot
) -> None:
    dialog = ask()
    assert dialog.pattern.text() == "goniometer_angle_deg_{angle}"
    assert column(dialog, ANGLE) == ANGLES
    assert dialog.table.reference == 1  # nearest to 0
    assert dialog.name.text() == folder.name
    assert "3 scans with" in dialog.facts.text()
    type_into(dialog, 2, TREATMENT, "dry")
    with qtbot.waitSignal(shell.desk.series.made, timeout=60_000) as made:
        QTest.mouseClick(dialog.start, Qt.MouseButton.LeftButton)
    series = shell.controller.project.state.series[made.args[0]]
    assert [entry.angle_deg for entry in series.entries] == [-30, 0, 30]
    assert series.entries[2].treatment == "dry"
    names = [shell.controller.project.state.scan(e.scan).scan.name for e in series.entries]
    assert names[0].startswith("goniometer_angle_deg_-30")
    assert series.reference == series.entries[1].scan

    shell.desk.series.change(series.key)
    dialog = next(d for d in shell.findChildren(SeriesDialog) if d.isVisible())
    assert column(dialog, ANGLE) == ANGLES
    assert column(dialog, NOTE) == ["", "", ""]
    assert not dialog.facts.isVisible()
    type_into(dialog, 0, HOURS, "2,5")
    dialog.table.choose_reference(0)
    QTest.mouseClick(dialog.start, Qt.MouseButton.LeftButton)
    changed = shell.controller.project.state.series[series.key]
    assert changed.entries[0].hours == 2.5
    assert changed.reference == changed.entries[0].scan
    shell.controller.undo()
    assert shell.controller.project.state.series[series.key] == series


def test_rows_that_cannot_be_understood_are_explained(ask: Callable[[], SeriesDialog]) -> None:
    dialog = ask()
    dialog.pattern.setText("goniometer_angle_deg_-{angle}")
    QTest.keyClick(dialog.pattern, Qt.Key.Key_Return)
    assert "2; their rows say why" in dialog.notice.text
    notes = column(dialog, NOTE)
    assert "does not look like" in notes[1]
    assert "does not look like" in notes[2]
    assert not dialog.start.isEnabled()
    type_into(dialog, 1, ANGLE, "seven")
    assert column(dialog, NOTE)[1] == "seven is not a number."
    type_into(dialog, 1, ANGLE, "7")
    assert column(dialog, NOTE)[1] == "will be opened"
    dialog.table.setCurrentCell(2, NAME)
    QTest.mouseClick(dialog.remove, Qt.MouseButton.LeftButton)
    assert len(column(dialog, NAME)) == 2


def test_a_table_is_joined_by_file_name(
    ask: Callable[[], SeriesDialog], folder: Path, tmp_path: Path
) -> None:
    dialog = ask()
    dialog.fill_by_table(folder / "series.csv")
    assert column(dialog, ANGLE) == ANGLES
    table = tmp_path / "hours.csv"
    lines = [f"{row.file.name},{k * 1.5},wet" for k, row in enumerate(dialog.table.rows[:2])]
    table.write_text("\n".join(["file,hours,treatment", *lines]))
    dialog.fill_by_table(table)
    assert column(dialog, HOURS) == ["0", "1.5", ""]
    assert column(dialog, ANGLE) == ANGLES  # what the table does not say stays
    assert "no row for" in column(dialog, NOTE)[2]
    table.write_text("a,b\n1,2\n")
    dialog.fill_by_table(table)
    assert "must have a column file" in dialog.notice.text


def test_more_than_fits_into_the_memory_is_refused(
    ask: Callable[[], SeriesDialog], monkeypatch: pytest.MonkeyPatch
) -> None:
    tiny = psutil.virtual_memory()._replace(available=2**20)
    monkeypatch.setattr(memory.psutil, "virtual_memory", lambda: tiny)
    dialog = ask()
    assert "holds two scans at a time" in dialog.facts.text()
    assert not dialog.start.isEnabled()
