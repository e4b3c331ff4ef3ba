"""Dialogs say what they will do, and do it as one step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog
from pytestqt.qtbot import QtBot

from app.model.operations import Select
from app.model.points import PointSet
from app.model.scan import Pose
from widgets.dialogs.channel import KINDS, ChannelDialog
from widgets.dialogs.error import ErrorDialog
from widgets.dialogs.export import FORMATS, ExportDialog
from widgets.dialogs.open_scan import list_filters
from widgets.dialogs.origin import OriginDialog
from widgets.faults import Trouble
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
Put = Callable[..., str]


def open_export(shell: MainWindow) -> ExportDialog:
    shell.table.actions["file.export"].trigger()
    (dialog,) = shell.findChildren(ExportDialog)
    return dialog


def test_export_says_what_it_will_write(shell: MainWindow, put_scan: Put) -> None:
    key = put_scan(shell)
    shell.controller.do(Select(key, PointSet(range(10))))
    dialog = open_export(shell)
    assert dialog.summary.text().startswith("576 points with 7 columns")
    dialog.portions.button(1).setChecked(True)
    row = next(i for i in range(dialog.fields.count())
               if dialog.fields.item(i).data(Qt.ItemDataRole.UserRole) == "range")  # fmt: skip
    dialog.fields.item(row).setCheckState(Qt.CheckState.Checked)
    assert dialog.summary.text().startswith("10 points with 8 columns")
    assert dialog.chosen_fields() == ["range"]
    dialog.reject()


def test_export_writes_the_selection(
    shell: MainWindow, put_scan: Put, tmp_path: Path, qtbot: QtBot
) -> None:
    key = put_scan(shell)
    shell.controller.do(Select(key, PointSet(range(10))))
    dialog = open_export(shell)
    dialog.portions.button(1).setChecked(True)
    dialog.format.setCurrentIndex(list(FORMATS).index(".csv"))
    dialog.accept()
    (files,) = dialog.findChildren(QFileDialog)
    assert files.acceptMode() == QFileDialog.AcceptMode.AcceptSave
    assert not files.testOption(QFileDialog.Option.DontConfirmOverwrite)
    out = tmp_path / "out.csv"
    files.fileSelected.emit(str(out))
    files.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs and out.exists(), timeout=20_000)
    lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
    assert len(lines) == 1 + 10


def test_origin_offers_what_the_grid_speaks_for(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell, None)
    proposed = Pose((0.0, 0.0, 0.0), known_by="assumed")
    shell.desk.scans.set_origin(proposed)
    (dialog,) = shell.findChildren(OriginDialog)
    assert dialog.by_grid.isChecked()
    assert not dialog.at[0].isEnabled()
    dialog.accept()
    assert shell.controller.scan.scan.pose == proposed


def test_origin_can_be_marked_unknown(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell, Pose((1.0, 2.0, 3.0)))
    shell.table.actions["scan.origin"].trigger()
    (dialog,) = shell.findChildren(OriginDialog)
    assert dialog.position() == (1.0, 2.0, 3.0)
    dialog.unknown.setChecked(True)
    dialog.accept()
    assert shell.controller.scan.scan.pose is None
    shell.controller.undo()
    assert shell.controller.scan.scan.pose == Pose((1.0, 2.0, 3.0))


def test_a_channel_is_named_by_hand(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell)
    shell.table.actions["scan.channel"].trigger()
    (dialog,) = shell.findChildren(ChannelDialog)
    dialog.attribute.setCurrentText("reflectance_1545")
    assert dialog.wavelength.value() == 1545.0
    dialog.name.setText("green")
    dialog.wavelength.setValue(532.0)
    dialog.kind.setCurrentIndex(KINDS.index("dB"))
    dialog.accept()
    channels = {c.attribute: c for c in shell.controller.scan.scan.channels}
    named = channels["reflectance_1545"]
    assert (named.name, named.wavelength_nm, named.kind) == ("green", 532.0, "dB")
    assert channels["reflectance_1063"].name == "reflectance_1063"


def test_the_report_can_be_copied(shell: MainWindow) -> None:
    dialog = ErrorDialog(Trouble("It broke.", "Mend it.", "Traceback …"), shell)
    dialog.copy.click()
    text = QGuiApplication.clipboard().text()
    assert text.startswith("It broke.\nMend it.")
    assert "Traceback …" in text
    dialog.close()


def test_open_asks_for_several_files_and_remembers_the_folder(
    shell: MainWindow, tmp_path: Path
) -> None:
    opened: list[list[Path]] = []
    shell.desk.files.dialogs.ask_open(opened.append)
    (files,) = shell.findChildren(QFileDialog)
    assert files.fileMode() == QFileDialog.FileMode.ExistingFiles
    folder = tmp_path / "scans"
    files.filesSelected.emit([str(folder / "a.laz"), str(folder / "b.laz")])
    files.reject()
    assert opened == [[folder / "a.laz", folder / "b.laz"]]
    assert shell.desk.files.dialogs.folder == folder


def test_filters_know_every_format_that_is_read() -> None:
    from app.formats._registry import FORMATS as READ

    first = list_filters()[0]
    missing = [s for module in READ.values() for s in module.SUFFIXES if f"*{s}" not in first]
    assert missing == []


def test_guide_and_keys_open_beside_the_window(shell: MainWindow) -> None:
    for name in ("help.keys", "help.about", "help.guide"):
        shell.table.actions[name].trigger()
    from widgets.dialogs.guide import GuideDialog

    pages = shell.findChildren(GuideDialog)
    assert len(pages) == 3
    assert not any(page.isModal() for page in pages)
    assert "Ctrl+O" in pages[0].page.toPlainText()
    for page in pages:
        page.close()


def test_the_guide_follows_its_links_and_comes_back(qtbot: QtBot) -> None:
    from widgets.dialogs.guide import GuideDialog

    dialog = GuideDialog.of_guide()
    qtbot.addWidget(dialog)
    guide = dialog.page.toPlainText()
    assert guide.startswith("Guide")
    dialog.page.setSource(QUrl("benchmarks.md"))
    assert dialog.page.toPlainText().startswith("Benches")
    dialog.page.backward()
    assert dialog.page.toPlainText() == guide
