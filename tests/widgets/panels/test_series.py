"""The series panel: what is missing, stepping, the words of the user, the axis, the table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from app.model.operations import CloseScan, Select, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.model.series import SeriesEntry
from app.model.view_state import ViewState
from app.services.series.document import make_series
from widgets.panels.series import CARRY, SCANS, TABLE, SeriesPanel

pytestmark = pytest.mark.window
LEFT = Qt.MouseButton.LeftButton
SHIFT = 0.002


@pytest.fixture
def carrying(desk, make_scan: Callable[..., Scan], qtbot: QtBot):
    """A panel with two leaves carried to two scans, of which one is a little further away."""
    scan = make_scan()
    keys = [desk.open(scan), desk.open(replace(scan, name="again"))]
    further = scan.xyz * (1.0 + SHIFT / np.linalg.norm(scan.xyz, axis=1)[:, None])
    keys.append(desk.open(replace(scan, name="later", xyz=further)))
    desk.make_halves(keys[0])
    entries = [SeriesEntry(key, hours=float(k)) for k, key in enumerate(keys)]
    series = make_series(desk.controller.project, "drying", entries, keys[0])
    panel = desk.show(SeriesPanel)
    panel.show_series(series)
    panel.tabs.setCurrentIndex(CARRY)
    settle(qtbot, desk)
    return desk, panel, keys


def settle(qtbot: QtBot, desk) -> None:
    for _ in range(3):
        qtbot.waitUntil(lambda: not desk.controller.bridge.jobs, timeout=60_000)
        qtbot.wait(20)


def click(button) -> None:
    assert button.isEnabled(), button.text()
    QTest.mouseClick(button, LEFT)


def go_to(panel, row: int, qtbot: QtBot, desk) -> None:
    table = panel.carrying.steps.table
    QTest.mouseClick(table.viewport(), LEFT, pos=table.visualItemRect(table.item(row, 0)).center())
    settle(qtbot, desk)


def choose(panel, row: int) -> None:
    table = panel.carrying.list.table
    QTest.mouseClick(table.viewport(), LEFT, pos=table.visualItemRect(table.item(row, 0)).center())


def verdicts(panel) -> list[str]:
    return [one.verdict for one in panel.carrying.list.found]


def test_it_says_what_is_missing(desk, make_scan, qtbot: QtBot) -> None:
    panel = desk.show(SeriesPanel)
    assert "Make one of open scans or of a folder" in panel.notice.text
    with qtbot.waitSignal(panel.make_asked):
        click(panel.make_button)
    keys = [desk.open(make_scan()), desk.open(replace(make_scan(), name="again"))]
    make_series(desk.controller.project, "s", [SeriesEntry(key) for key in keys], keys[0])
    qtbot.waitUntil(lambda: "has no leaf yet" in panel.notice.text)
    assert panel.about.facts.texts["Reference"] == "bent leaf"
    assert not panel.about.axis.isVisible()
    with qtbot.waitSignal(panel.change_asked) as asked:
        click(panel.about.change_button)
    assert asked.args == [panel.series.key]
    click(panel.about.forget_button)
    qtbot.waitUntil(lambda: "Make one of open scans" in panel.notice.text)


def test_stepping_shows_leaves_and_hides_the_other_scans(carrying, qtbot: QtBot) -> None:
    desk, panel, keys = carrying
    steps, view = panel.carrying.steps, lambda: desk.controller.view
    assert desk.controller.current == keys[0]
    assert view().previewed == ()  # those of the reference are the document's
    assert not steps.previous.isEnabled()
    with qtbot.waitActive(panel):
        panel.activateWindow()
    QTest.keyClick(panel, Qt.Key.Key_Right, Qt.KeyboardModifier.AltModifier)
    qtbot.waitUntil(lambda: desk.controller.current == keys[1])
    settle(qtbot, desk)
    assert set(view().hidden) == {keys[0], keys[2]}
    assert {(one.scan, one.leaf) for one in view().previewed} == {
        (keys[1], "leaf-00001"),
        (keys[1], "leaf-00002"),
    }
    click(steps.alone)
    settle(qtbot, desk)
    assert view().hidden == ()
    go_to(panel, 2, qtbot, desk)
    assert desk.controller.current == keys[2]
    assert verdicts(panel) == ["sure", "sure"]
    assert [round(1000 * one.offset) for one in panel.carrying.list.found] == [2, 2]
    click(steps.look_button)
    settle(qtbot, desk)
    assert [steps.table.item(row, 1).text() for row in range(3)] == ["", "2", "2"]
    desk.controller.look(current=keys[0])
    settle(qtbot, desk)
    assert steps.current == 0
    assert not panel.carrying.list.confirm_button.isEnabled()


def test_words_of_the_user_can_be_undone(carrying, qtbot: QtBot) -> None:
    desk, panel, keys = carrying
    go_to(panel, 1, qtbot, desk)
    page = panel.carrying
    choose(panel, 0)
    click(page.list.miss_button)
    settle(qtbot, desk)
    assert verdicts(panel) == ["corrected", "sure"]
    assert {one.leaf for one in desk.controller.view.previewed} == {"leaf-00002"}
    choose(panel, 1)
    click(page.list.confirm_button)
    settle(qtbot, desk)
    assert verdicts(panel) == ["corrected", "corrected"]
    assert page.steps.table.item(1, 4).text() == "2"
    choose(panel, 0)
    click(page.list.reset_button)
    settle(qtbot, desk)
    assert verdicts(panel) == ["sure", "corrected"]
    desk.controller.do(Select(keys[1], PointSet([1, 2, 3])))
    settle(qtbot, desk)
    choose(panel, 0)
    click(page.list.take_button)
    settle(qtbot, desk)
    assert list(page.list.found[0].rows) == [1, 2, 3]
    desk.controller.undo()
    settle(qtbot, desk)
    assert verdicts(panel) == ["sure", "corrected"]
    assert len(desk.controller.scan.selection) == 3
    titles = [e.operation.title for e in desk.controller.project.history.log if e.operation]
    assert "Correct a leaf in series drying (3 scans)" in titles


def test_several_leaves_are_confirmed_in_one_step(carrying, qtbot: QtBot) -> None:
    desk, panel, keys = carrying
    go_to(panel, 1, qtbot, desk)
    panel.carrying.list.table.selectAll()
    click(panel.carrying.list.confirm_button)
    settle(qtbot, desk)
    assert len(panel.series.entry(keys[1]).corrections) == 2
    desk.controller.undo()
    assert panel.series.entry(keys[1]).corrections == ()


def test_what_is_found_follows_the_document_and_nothing_else(carrying, qtbot: QtBot) -> None:
    desk, panel, keys = carrying
    go_to(panel, 1, qtbot, desk)
    found = panel.carrying.list.found
    desk.controller.do(Select(keys[1], PointSet([1])))
    settle(qtbot, desk)
    assert panel.carrying.list.found[0] is found[0]  # nothing was looked for again
    gone = PointSet(found[0].rows[:200])
    desk.controller.do(SetDeleted(keys[1], gone, True))
    settle(qtbot, desk)
    assert not np.isin(panel.carrying.list.found[0].rows, gone.indices).any()
    panel.hide()
    desk.controller.undo()
    assert desk.controller.view.previewed == ()  # nobody would notice that they are old
    desk.controller.adopt(Project(), ViewState())
    settle(qtbot, desk)


def test_a_closed_scan_is_not_stepped_to(carrying, qtbot: QtBot) -> None:
    desk, panel, keys = carrying
    desk.controller.do(CloseScan(keys[2]))
    settle(qtbot, desk)
    with qtbot.waitSignal(desk.controller.said) as said:
        go_to(panel, 2, qtbot, desk)
    assert "closed" in said.args[0]
    assert desk.controller.current == keys[0]


def test_an_axis_is_typed_and_picked(carrying, qtbot: QtBot) -> None:
    desk, panel, keys = carrying
    panel.tabs.setCurrentIndex(SCANS)
    settle(qtbot, desk)
    form = panel.about.axis
    assert form.words.text().startswith("Same pose")
    assert not form.fit_button.isEnabled()  # nobody said any angle
    click(form.type_button)
    QTest.keyClicks(form.line, "3, 0, 0, 0, 0, 2")
    QTest.keyClick(form.line, Qt.Key.Key_Return)
    settle(qtbot, desk)
    assert panel.series.axis.direction == (0.0, 0.0, 1.0)
    assert "typed" in form.words.text()
    with qtbot.waitSignal(panel.pick_asked):
        click(form.pick_button)
    xyz = desk.state.scan(keys[0]).scan.xyz
    panel.take_point(keys[0], 5)
    assert "1 of 2" in form.words.text()
    panel.take_point(keys[0], 900)
    settle(qtbot, desk)
    along = (xyz[900] - xyz[5]) / np.linalg.norm(xyz[900] - xyz[5])
    assert panel.series.axis.direction == pytest.approx(tuple(along))
    assert panel.series.axis.origin == "picked"
    panel.take_point(keys[0], 7)  # not asked for
    assert panel.about.axis.words.text().startswith("Turned about an axis: picked")
    click(form.same_button)
    settle(qtbot, desk)
    assert panel.series.axis is None


def test_the_table_is_measured_and_says_when_it_is_old(carrying, qtbot: QtBot, tmp_path) -> None:
    desk, panel, keys = carrying
    panel.tabs.setCurrentIndex(TABLE)
    settle(qtbot, desk)
    page = panel.table
    assert not page.body.isVisible()
    assert page.against.currentData() == "hours"
    click(page.measure_button)
    settle(qtbot, desk)
    assert len(page.rows) == 6
    assert page.table.rowCount() == 6
    assert page.channel.currentText() == "near"
    assert not page.fit_button.isEnabled()  # hours are no angle
    page.against.setCurrentIndex(0)
    page.against.activated.emit(0)
    assert page.fit_button.isEnabled()
    page.export(tmp_path / "t.csv")
    assert len((tmp_path / "t.csv").read_text().splitlines()) == 7
    assert not page.notice.isVisible()
    desk.controller.do(SetDeleted(keys[1], PointSet([0]), True))
    settle(qtbot, desk)
    assert "has changed" in page.notice.text
    click(page.notice.button)
    settle(qtbot, desk)
    assert not page.notice.isVisible()
