"""The dialog that simulates a scan: what it asks for, what it says before, what it does."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QWidget
from pytestqt.qtbot import QtBot

from app.core.errors import BadInput
from app.services.simulation_order import Estimate, Order, Setup
from app.simulate.instrument import list_instruments
from app.simulate.scene_file import list_scenes
from widgets.common.scan_cost import round_count
from widgets.dialogs.export import FORMATS
from widgets.dialogs.simulate import NOISES, SimulateDialog
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window

SCENE = """\
name = "mine"
description = "A leaf of mine"
seed = 5
instrument = "x330"
step_deg = 0.2
[[part]]
kind = "leaf"
[[part]]
kind = "wall"
range = 4
"""


@pytest.fixture
def dialog(shell: MainWindow, qtbot: QtBot) -> Iterator[SimulateDialog]:
    shell.table.actions["file.simulate"].trigger()
    (dialog,) = shell.findChildren(SimulateDialog)
    yield dialog
    if not shell.findChildren(SimulateDialog):
        return
    dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs, timeout=60_000)


def settle(dialog: SimulateDialog, qtbot: QtBot) -> bool:
    with qtbot.waitSignal(dialog.cost.settled, timeout=100_000) as found:
        pass
    return bool(found.args[0])


def test_scenes_and_instruments_are_offered(dialog: SimulateDialog) -> None:
    rows = [dialog.scenes.topLevelItem(row) for row in range(dialog.scenes.topLevelItemCount())]
    assert [row.text(0) for row in rows] == list(list_scenes())
    assert all(row.text(1) for row in rows)
    assert dialog.instrument.count() == 1 + len(list_instruments())
    assert dialog.order() == Order("leaf")
    assert dialog.instrument.currentText() == "As the scene says: Two colours, phase shift"
    assert dialog.step.text() == "as usual: 0.018 °"


def test_what_is_chosen_is_ordered(dialog: SimulateDialog) -> None:
    dialog.choose("crown")
    assert dialog.step.text() == "as usual: 0.05 °"
    dialog.choose("goniometer")
    assert dialog.instrument.itemText(0) == "As the scene says: FARO LS880"
    dialog.instrument.setCurrentIndex(dialog.instrument.findData("salca"))
    assert dialog.step.text() == "as usual: 0.0573 °"
    dialog.step.setValue(0.1)
    dialog.seed.setValue(3)
    dialog.noise.setCurrentIndex([noise for noise, _ in NOISES].index("filtered"))
    assert dialog.order() == Order("goniometer", "salca", 3, 0.1, "filtered")


def test_beams_and_points_are_told_before(dialog: SimulateDialog, qtbot: QtBot) -> None:
    dialog.step.setValue(0.1)
    assert settle(dialog, qtbot)
    assert dialog.cost.text.text() == "528 beams, about 530 points."
    assert dialog.start.isEnabled()


def test_what_cannot_be_done_is_told_before(dialog: SimulateDialog, qtbot: QtBot) -> None:
    dialog.step.setValue(50.0)
    assert not settle(dialog, qtbot)
    assert "does not fit" in dialog.cost.notice.text
    assert not dialog.start.isEnabled()
    dialog.step.setValue(0.1)
    assert dialog.start.isEnabled()
    assert settle(dialog, qtbot)
    assert dialog.cost.notice.text == ""


def test_a_scene_of_the_users_own(
    dialog: SimulateDialog, shell: MainWindow, tmp_path: Path, qtbot: QtBot
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(SCENE)
    dialog.from_file.click()
    (files,) = dialog.findChildren(QFileDialog)
    files.fileSelected.emit(str(path))
    files.reject()
    assert dialog.scene() == str(path)
    assert dialog.scenes.currentItem().text(0) == "mine.toml"
    assert dialog.scenes.currentItem().text(1) == "A leaf of mine"
    assert dialog.seed.value() == 5
    assert dialog.step.text() == "as usual: 0.2 °"
    assert dialog.order() == Order(str(path))
    path.write_text("name = ")
    dialog.add_file(path)
    assert "mine.toml" in dialog.cost.notice.text
    assert not dialog.start.isEnabled()


@pytest.mark.parametrize("opens", [True, False])
def test_the_scan_is_written_and_opened(
    dialog: SimulateDialog, shell: MainWindow, tmp_path: Path, qtbot: QtBot, opens: bool
) -> None:
    said: list[str] = []
    shell.controller.said.connect(said.append)
    shell.controller.look(colour="something else")
    dialog.choose("goniometer")
    dialog.step.setValue(0.2)
    dialog.format.setCurrentIndex(list(FORMATS).index(".e57"))
    dialog.opens.setChecked(opens)
    dialog.accept()
    (files,) = dialog.findChildren(QFileDialog)
    assert files.selectedFiles() == [str(tmp_path / "goniometer.e57")]
    assert not files.testOption(QFileDialog.Option.DontConfirmOverwrite)
    out = tmp_path / "stage.e57"
    files.fileSelected.emit(str(out))
    files.reject()
    qtbot.waitUntil(lambda: out.exists() and not shell.controller.bridge.jobs, timeout=100_000)
    assert any(f"written to {out}" in text for text in said)
    assert (shell.controller.scan is not None) == opens
    if opens:
        assert shell.controller.view.colour == "intensity_785"
        assert "truth_ghost" in shell.controller.scan.scan.attributes


def test_closing_stops_the_counting(
    dialog: SimulateDialog, shell: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Setup] = []

    def count(setup: Setup, progress: object) -> Estimate:
        begun.append(setup)
        while True:  # until it is told to stop
            progress.report(0.5)

    monkeypatch.setattr("widgets.common.scan_cost.estimate", count)
    dialog.step.setValue(0.1)
    qtbot.waitUntil(lambda: bool(begun), timeout=20_000)
    dialog.reject()
    qtbot.waitUntil(lambda: not shell.controller.bridge.jobs, timeout=20_000)


def test_a_fault_is_told_in_the_dialog_not_behind_it(
    dialog: SimulateDialog, shell: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise BadInput("Too large.", "Take a larger step.")

    failed: list[object] = []
    shell.controller.failed.connect(failed.append)
    monkeypatch.setattr("widgets.common.scan_cost.refuse_too_large", refuse)
    dialog.step.setValue(0.1)
    assert not settle(dialog, qtbot)
    assert dialog.cost.notice.text == "Too large. Take a larger step."
    assert failed == []


def test_everything_has_a_name_for_screen_readers(dialog: SimulateDialog) -> None:
    inputs: list[QWidget] = [
        dialog.scenes, dialog.instrument, dialog.step, dialog.seed, dialog.noise, dialog.format,
    ]  # fmt: skip
    assert all(widget.accessibleName() for widget in inputs)
    assert all(widget.toolTip() for widget in (*inputs[1:], dialog.from_file))
    assert "degrees" in dialog.step.accessibleName()


@pytest.mark.parametrize(
    ("count", "shown"), [(0, 0), (7, 7), (15_990, 16_000), (2_386_256, 2_400_000)]
)
def test_an_estimate_is_rounded(count: int, shown: int) -> None:
    assert round_count(count) == shown
