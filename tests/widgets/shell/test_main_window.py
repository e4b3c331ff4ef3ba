"""The window opens, shows, asks and closes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QMessageBox, QTabBar, QWidget
from pytestqt.qtbot import QtBot

from app.core.errors import BadInput, MissingChannel, MissingScanner
from app.core.progress import Progress
from app.core.screen import project as project_points
from app.core.screen import select_in_lasso
from app.model.operations import Select, SetPose
from app.model.points import PointSet
from app.model.scan import Pose
from app.model.selection import Explicit
from widgets.dialogs.error import ErrorDialog
from widgets.dialogs.origin import OriginDialog
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
Put = Callable[..., str]
Button = QMessageBox.StandardButton


def list_questions(window: MainWindow) -> list[QMessageBox]:
    return [box for box in window.findChildren(QMessageBox, "unsaved") if box.isVisible()]


def test_a_file_is_opened_and_shown(window: MainWindow, scan_file: Path, qtbot: QtBot) -> None:
    assert window.stack.currentWidget() is window.welcome
    window.documents.open([scan_file])
    qtbot.waitUntil(lambda: window.controller.current is not None, timeout=20_000)
    qtbot.waitUntil(lambda: window.stack.currentWidget() is window.picture.view)
    assert window.windowTitle() == "patch[*] – Leafscope"
    assert not window.isWindowModified()  # opening alone is no work to lose
    assert window.controller.view.colour == "reflectance_1063"
    assert "576" in window.status.points.text()
    assert window.colour_by.currentText().startswith("reflectance_1063")


def test_gestures_select_pick_and_undo(window: MainWindow, put_scan: Put, qtbot: QtBot) -> None:
    key = put_scan(window)
    project, view = window.controller.project, window.picture.view
    qtbot.waitUntil(lambda: window.stack.currentWidget() is view)
    corners = [(0.05, 0.05), (0.95, 0.05), (0.95, 0.95), (0.05, 0.95)]
    window.tools.reach("through")
    seen_from = view.current_view()
    view.lasso_finished.emit(corners, "replace")
    qtbot.waitUntil(lambda: len(project.state.scan(key).selection) > 0, timeout=20_000)
    xyz = project.state.scan(key).scan.xyz
    expected = select_in_lasso(xyz, None, seen_from, np.array(corners), "through")
    assert np.array_equal(project.state.scan(key).selection.indices, expected.indices)
    assert len(expected.indices) > 400
    assert window.status.currentMessage() == expected.describe()
    window.table.actions["edit.undo"].trigger()
    assert len(project.state.scan(key).selection) == 0
    now = view.current_view()
    place = project_points(xyz[300:301], now.origin, now.matrix, now.size).px[0] / now.size
    view.picked.emit(float(place[0]), float(place[1]))
    qtbot.waitUntil(lambda: window.picture.picker.point is not None, timeout=20_000)
    assert window.picture.picker.point == (key, 300)
    qtbot.waitUntil(lambda: not window.controller.bridge.jobs, timeout=60_000)
    known = project.known_field(key, "incidence")
    assert known.computed == 1  # of that point only
    view.tool_changed.emit("navigate")
    assert window.tools.tool == "navigate"
    view.limits_changed.emit(0.35, 0.5, True)
    assert window.controller.view.ranges["reflectance_1063"].low == 0.35


def test_the_first_leaf_is_shown_and_the_camera_is_saved(
    window: MainWindow, put_scan: Put, qtbot: QtBot
) -> None:
    key = put_scan(window)
    qtbot.waitUntil(lambda: bool(window.picture.view.counts))
    assert not window.controller.view.show_leaves
    window.work.make_leaf(key, PointSet(range(50)), Explicit(PointSet(range(50))))
    assert window.controller.view.show_leaves
    window.controller.look(colour="reflectance_1545")
    assert not window.controller.view.show_leaves  # other colours were asked for
    window.table.actions["view.leaves"].trigger()
    window.controller.look(colour="range")
    assert window.controller.view.show_leaves  # asked for: they stay
    window.table.actions["view.leaves"].trigger()
    window.work.make_leaf(key, PointSet(range(50, 90)), Explicit(PointSet(range(50, 90))))
    assert not window.controller.view.show_leaves  # the user's wish holds
    window.picture.keep_camera()
    camera = window.picture.view.camera()
    assert window.controller.view.camera == (camera.position, camera.focal_point, camera.view_up)


def test_a_session_comes_back_as_it_was_left(
    window: MainWindow, scan_file: Path, tmp_path: Path, qtbot: QtBot
) -> None:
    window.documents.open([scan_file])
    qtbot.waitUntil(lambda: bool(window.picture.view.counts), timeout=20_000)
    key = window.controller.current
    window.controller.do(Select(key, PointSet([1, 2, 3])))
    window.picture.look_from("top")
    camera = window.picture.view.camera()
    path = tmp_path / "work.leafscope"
    window.documents.path = path
    window.table.actions["file.save"].trigger()
    assert path.is_file()
    assert not window.isWindowModified()
    assert window.windowTitle() == "work.leafscope[*] – Leafscope"
    window.table.actions["file.new"].trigger()  # nothing is lost: no question
    qtbot.waitUntil(lambda: window.stack.currentWidget() is window.welcome)
    window.desk.files.open_paths([path])
    qtbot.waitUntil(lambda: window.controller.scan is not None, timeout=20_000)
    qtbot.waitUntil(lambda: window.picture.view.camera() == camera)
    assert list(window.controller.scan.selection.indices) == [1, 2, 3]


def test_docks_come_back(window: MainWindow, qtbot: QtBot) -> None:
    def list_bars() -> list[list[str]]:
        bars = [b for b in window.findChildren(QTabBar) if b.isVisible() and b.parent() is window]
        return sorted([bar.tabText(i) for i in range(bar.count())] for bar in bars)

    qtbot.waitUntil(lambda: window.docks.docks["ghosts"].titleBarWidget() is not None)
    before = list_bars()
    assert before == [
        ["Leaves", "Jobs", "Series"],
        ["Phase lab", "Correct", "Index", "Δω", "Ghosts", "Angles", "Calibration", "Planner"],
        ["Scans", "Point", "History"],
    ]
    window.docks.docks["ghosts"].setFloating(True)
    window.docks.docks["leaves"].close()
    qtbot.waitUntil(lambda: window.docks.docks["ghosts"].titleBarWidget() is None)
    window.table.actions["view.reset_layout"].trigger()
    qtbot.waitUntil(lambda: list_bars() == before)


def test_tools_and_theme_reach_the_view(window: MainWindow, put_scan: Put, qtbot: QtBot) -> None:
    put_scan(window)
    heard: list[str] = []
    window.picture.view.tool_changed.connect(heard.append)
    window.table.actions["tool.lasso"].trigger()
    assert window.tools.tool == "lasso"
    qtbot.keyClick(window, Qt.Key.Key_Escape)
    assert heard[0] == "lasso"
    assert heard[-1] == "navigate"
    light = window.palette().window().color().lightness()
    window.table.actions["theme.dark"].trigger()
    assert window.palette().window().color().lightness() < 60 < 200 < light
    assert window.controller.view.theme == "dark"
    window.table.actions["view.ortho"].trigger()
    assert window.picture.orthographic
    assert window.table.actions["view.ortho"].isChecked()


def test_everything_has_a_name_for_those_who_cannot_see(window: MainWindow) -> None:
    # Panels and viewport look after their own.
    others = ("PySide6", "shiboken6", "widgets.panels.", "widgets.common.", "widgets.viewport.")
    ours = [w for w in window.findChildren(QWidget) if not type(w).__module__.startswith(others)]
    takes_keys = [w for w in ours if w.focusPolicy() != Qt.FocusPolicy.NoFocus]
    assert window.colour_by in takes_keys
    named = {w for w in takes_keys if w.accessibleName() or w.toolTip()}
    nameless = [type(w).__name__ for w in takes_keys if w not in named and not hasattr(w, "text")]
    assert nameless == []


def test_a_missing_scanner_becomes_a_notice_with_a_way_out(
    shell: MainWindow, put_scan: Put, qtbot: QtBot
) -> None:
    key = put_scan(shell, None)
    shell.show()
    shell.controller.want(key, "range")
    qtbot.waitUntil(lambda: bool(shell.notices.notices), timeout=20_000)
    (notice,) = shell.notices.notices
    assert "scanner's position is unknown" in notice.text
    notice.buttons[0].click()
    assert shell.notices.notices == []
    (dialog,) = shell.findChildren(OriginDialog)
    dialog.by_hand.setChecked(True)
    dialog.at[2].setValue(1.6)
    dialog.accept()
    assert shell.controller.scan.scan.pose == Pose((0.0, 0.0, 1.6), known_by="given")


def test_a_notice_goes_when_it_is_settled(shell: MainWindow, put_scan: Put) -> None:
    key = put_scan(shell, None)
    shell.tell(MissingScanner("the range"))
    shell.tell(MissingChannel("patch.csv has no intensity."))
    shell.controller.do(SetPose(key, Pose((1.0, 2.0, 3.0))))
    assert [n.topic for n in shell.notices.notices] == ["channel"]


def test_a_proposed_position_is_accepted_by_a_click(shell: MainWindow, put_scan: Put) -> None:
    key = put_scan(shell, None)
    pose = Pose((0.0, 0.0, 0.0), known_by="assumed")
    shell.documents.pose_proposed.emit(key, pose)
    (notice,) = shell.notices.notices
    notice.buttons[0].click()
    assert shell.controller.scan.scan.pose == pose


def test_errors_are_told_once_and_explained(shell: MainWindow) -> None:
    shell.show()
    shell.tell(BadInput("x.las is empty (0 bytes)."))
    shell.tell(BadInput("x.las is empty (0 bytes)."))
    try:
        raise ZeroDivisionError("division by zero")
    except ZeroDivisionError as error:
        shell.tell(error)
    first, second = shell.notices.notices
    assert (first.kind, second.kind) == ("warning", "error")
    second.buttons[0].click()
    (dialog,) = shell.findChildren(ErrorDialog)
    assert "ZeroDivisionError" in dialog.details.toPlainText()
    dialog.close()


@pytest.mark.parametrize("answer", [Button.Cancel, Button.Discard, Button.Save])
def test_closing_asks_about_work(
    shell: MainWindow, put_scan: Put, qtbot: QtBot, tmp_path: Path, answer: Button
) -> None:
    key = put_scan(shell)
    shell.show()
    saved: list[Path] = []
    shell.documents.path = tmp_path / "work.leafscope"
    shell.documents.save = lambda path: saved.append(path) or True  # type: ignore[method-assign]
    shell.controller.do(Select(key, PointSet([3])))
    assert shell.isWindowModified()
    shell.close()
    (question,) = list_questions(shell)
    assert shell.isVisible()
    qtbot.mouseClick(question.button(answer), Qt.MouseButton.LeftButton)
    assert shell.isVisible() == (answer == Button.Cancel)
    assert saved == ([tmp_path / "work.leafscope"] if answer == Button.Save else [])


def test_closing_asks_nothing_when_nothing_is_lost(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell)
    shell.show()
    shell.close()
    assert not shell.isVisible()


def test_new_asks_first_and_cancel_keeps_all(shell: MainWindow, put_scan: Put) -> None:
    key = put_scan(shell)
    shell.show()
    shell.controller.do(Select(key, PointSet([3])))
    shell.table.actions["file.new"].trigger()
    (question,) = list_questions(shell)
    question.button(Button.Cancel).click()
    assert shell.controller.current == key
    shell.table.actions["file.new"].trigger()
    list_questions(shell)[-1].button(Button.Discard).click()
    assert shell.controller.current is None
    assert shell.windowTitle() == "Leafscope[*]"


def test_dropped_files_are_opened(shell: MainWindow, scan_file: Path, qtbot: QtBot) -> None:
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile(str(scan_file))])
    drop = QDropEvent(QPointF(5, 5), Qt.DropAction.CopyAction, mime, Qt.MouseButton.LeftButton,
                      Qt.KeyboardModifier.NoModifier)  # fmt: skip
    shell.dropEvent(drop)
    assert drop.isAccepted()
    qtbot.waitUntil(lambda: shell.controller.current is not None, timeout=20_000)
    assert shell.controller.scan.scan.name.startswith("patch")


def test_colours_that_cannot_be_had_say_why(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell, None)
    model = shell.colour_by.model()
    row = shell.colour_by.findData("incidence")
    assert not model.item(row).isEnabled()
    assert "position is unknown" in model.item(row).toolTip()
    shell.documents.set_origin(shell.controller.current, (0.0, 0.0, 0.0))
    row = shell.colour_by.findData("incidence")
    assert model.item(row).isEnabled()
    shell.colour_by.activated.emit(shell.colour_by.findData("reflectance_1545"))
    assert shell.controller.view.colour == "reflectance_1545"


def test_a_narrow_tool_bar_leaves_words_out(shell: MainWindow, qtbot: QtBot) -> None:
    shell.show()
    style = {}
    for width in (2400, 700):
        shell.resize(width, 700)
        qtbot.waitUntil(lambda width=width: abs(shell.bar.width() - width) < 400)
        buttons = [b for s in shell.bar._segments for b in s.buttons]
        style[width] = {b.toolButtonStyle() for b in buttons}
    assert style[2400] == {Qt.ToolButtonStyle.ToolButtonTextBesideIcon}
    assert style[700] == {Qt.ToolButtonStyle.ToolButtonIconOnly}


def test_long_work_shows_progress_and_can_be_cancelled(shell: MainWindow, qtbot: QtBot) -> None:
    shell.show()
    done: list[object] = []

    def work(progress: Progress) -> None:
        for _ in range(2000):
            progress.report(0.3, "Counting sheep")
            time.sleep(0.01)

    job = shell.controller.run("Long work", work, done.append)
    qtbot.wait(300)
    assert not shell.status.progress.isVisible()  # short work is not worth a flash
    qtbot.waitUntil(shell.status.progress.isVisible, timeout=3000)
    assert "Counting sheep" in shell.status.job.toolTip()
    assert shell.status.progress.value() == 30
    start = time.monotonic()
    shell.status.cancel.click()
    qtbot.waitUntil(lambda: job.over)
    assert time.monotonic() - start < 0.5
    qtbot.waitUntil(lambda: not shell.status.progress.isVisible())
    assert (job.state, done) == ("cancelled", [])
