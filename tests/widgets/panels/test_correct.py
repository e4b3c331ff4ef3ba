"""The panel that corrects shows what the command writes, and puts it to use undoably."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.cli import run
from app.formats.cloud import Cloud
from app.services.export import export
from app.services.leaves import leaves_from_labels
from app.services.workflow_preview import TOGETHER
from app.simulate.scenes import leaf_row_scan
from widgets.common.correct.words import list_numbers, tell_marks
from widgets.common.step_titles import title_steps
from widgets.fields_at_hand import list_fields
from widgets.panels.correct import CorrectPanel

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(CorrectPanel)
    ready(panel, qtbot)
    return panel


def ready(panel, qtbot) -> None:
    """Wait until what is shown belongs to what is chosen."""
    qtbot.waitUntil(
        lambda: not panel._later.isActive() and not panel.controller.bridge.jobs
        and (panel.preview is not None or bool(panel.notice.text)),
        timeout=60_000,
    )  # fmt: skip


def choose(panel, box, data, qtbot) -> None:
    """Choose in a box with the keyboard, as `activated` tells of users only."""
    row = next(i for i in range(box.count()) if box.itemData(i) == data)
    box.setFocus()
    while box.currentIndex() != row:
        down = Qt.Key.Key_Down if box.currentIndex() < row else Qt.Key.Key_Up
        QTest.keyClick(box, down)
    ready(panel, qtbot)


def click(panel, button, qtbot) -> None:
    qtbot.mouseClick(button, LEFT)
    ready(panel, qtbot)


def fields(panel) -> set[str]:
    return set(panel.controller.project.catalogue(panel.controller.current))


def test_it_foretells_then_corrects_then_undo_takes_it_back(panel, opened, qtbot) -> None:
    assert "Not in use yet" in panel.state.text()
    assert "near_wf2" not in fields(panel)
    assert panel.grid.columnCount() == 4
    rows = panel.preview.rows
    steps = len(opened.controller.project.history.done)
    click(panel, panel.correct_button, qtbot)
    assert {"near_wf2", "near_wf3", "near_wf2_mark"} <= fields(panel)
    assert len(opened.controller.project.history.done) == steps + 1
    assert "In use" in panel.state.text()
    assert not panel.correct_button.isEnabled()
    assert panel.preview.rows == rows
    opened.controller.undo()
    ready(panel, qtbot)
    assert "near_wf2" not in fields(panel)
    assert panel.correct_button.isEnabled()
    opened.controller.redo()
    ready(panel, qtbot)
    click(panel, panel.remove_button, qtbot)
    assert "near_wf2" not in fields(panel)


def test_the_numbers_are_those_of_the_command(desk, qtbot, tmp_path: Path) -> None:
    path, out = tmp_path / "row.laz", tmp_path / "w.csv"
    export(Cloud(leaf_row_scan(step_deg=0.06, noise_m=0.0004, seed=2)), path)
    assert run(["correct", str(path), "--out", str(out), "--label-field", "truth_leaf"]) == 0
    desk.documents.open([path])
    qtbot.waitUntil(lambda: desk.controller.current is not None, timeout=30_000)
    leaves_from_labels(desk.controller.project, desk.controller.current, "truth_leaf")
    panel = desk.show(CorrectPanel)
    ready(panel, qtbot)
    click(panel, panel.form.every, qtbot)
    target = tmp_path / "window.csv"
    qtbot.mouseClick(panel.export_button, LEFT)
    (dialog,) = panel.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(target))
    dialog.reject()
    with out.open() as command, target.open() as window:
        expected, found = list(csv.DictReader(command)), list(csv.DictReader(window))
    assert len(found) == len(expected) == 12
    for told, shown in zip(expected, found, strict=True):
        assert {**told, "scan": ""} == {**shown, "scan": ""}
    first = next(r for r in panel.preview.rows if r["leaf"] != TOGETHER)
    assert f"CV {100 * first['wf2_cv']:.1f} %" in panel.grid.item(1, 2).text()


def test_typed_numbers_are_used_and_shown(panel, opened, qtbot) -> None:
    choose(panel, panel.form.source_box, ("typed", ""), qtbot)
    field = panel.form.typed["b"]
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.75")
    QTest.keyClick(field, Qt.Key.Key_Return)
    ready(panel, qtbot)
    assert panel.numbers.item(0, 2).text() == "0.75"
    click(panel, panel.correct_button, qtbot)
    used = opened.controller.scan.parameters.corrections
    assert [c.values for c in used] == [{"b": 0.75}, {"k_d": 0.8, "m": 0.3}]
    steps = [e.operation for e in opened.controller.project.history.log if e.operation is not None]
    assert title_steps(steps)[-1].startswith("Correct near by WF2 (b = 0.75), near by WF3")


def test_a_fit_of_each_leaf_or_only_of_the_current_one(panel, opened, qtbot) -> None:
    choose(panel, panel.form.source_box, ("each", ""), qtbot)
    click(panel, panel.form.workflow_boxes["wf3"], qtbot)
    assert [c.leaves for c in panel.preview.made] == [("leaf-00001",), ("leaf-00002",)]
    choose(panel, panel.form.leaves_box, "leaf", qtbot)
    assert [row["name"] for row in panel.preview.rows] == ["all leaves", "Leaf 2"]
    choose(panel, panel.form.leaves_box, "chosen", qtbot)
    assert "Select one or more leaves" in panel.notice.text
    panel.choose_leaves(["leaf-00001"])
    ready(panel, qtbot)
    assert [c.leaves for c in panel.preview.made] == [("leaf-00001",)]


def test_what_cannot_be_corrected_is_said(panel, opened, qtbot) -> None:
    choose(panel, panel.form.source_box, ("published", "birch"), qtbot)
    qtbot.waitUntil(lambda: "1550 and 690 nm" in panel.notice.text)
    assert not panel.body.isVisible()
    panel.refresh()
    assert "1550 and 690 nm" in panel.notice.text
    choose(panel, panel.form.source_box, ("together", ""), qtbot)
    qtbot.waitUntil(lambda: panel.body.isVisible())
    assert not panel.notice.text


def test_a_click_colours_the_view_by_the_channel_or_its_mark(panel, opened, qtbot) -> None:
    assert not panel.colours.buttons
    click(panel, panel.correct_button, qtbot)
    for field in ("near_wf2", "near_wf3_mark", "near"):
        qtbot.mouseClick(panel.colours.buttons[field], LEFT)
        assert opened.controller.view.colour == field
        qtbot.waitUntil(lambda f=field: panel.colours.buttons[f].isChecked())
    ready(panel, qtbot)
    groups = {f.name: f.group for f in list_fields(opened.controller.project,
                                                   opened.controller.current)}  # fmt: skip
    assert {groups[f"near_wf2{end}"] for end in ("", "_sigma", "_mark")} == {"Corrected"}


def test_missing_things_are_said(desk, qtbot, make_scan) -> None:
    panel = desk.show(CorrectPanel)
    assert "Open a scan" in panel.notice.text
    key = desk.open(make_scan(pose=False))
    qtbot.waitUntil(lambda: "where the scanner stood" in panel.notice.text)
    with qtbot.waitSignal(panel.origin_asked) as asked:
        qtbot.mouseClick(panel.notice.button, LEFT)
    assert asked.args == [key]
    desk.documents.set_origin(key, (0.0, 0.0, 0.0))
    qtbot.waitUntil(lambda: "no leaf yet" in panel.notice.text)
    assert desk.controller.project.cache.computed(key) == {}
    choose(panel, panel.form.leaves_box, "scan", qtbot)
    qtbot.waitUntil(lambda: panel.preview is not None, timeout=60_000)
    assert panel.preview.rows[0]["name"] == "whole scan"


def test_marks_and_numbers_in_words() -> None:
    words = tell_marks("wf2", {"good": 90, "no angle": 4, "bracket too small": 6}, 0.25)
    assert words.startswith("WF2: 10 of 100 points are marked: 4 without an angle, 6 where")
    assert "below 0.25" in words
    assert "all 9 points" in tell_marks("wf3", {"good": 9}, 0.25)
    assert list_numbers([], {}) == ([], [])


def test_rows_have_three_lines_and_go_by_the_numbers_in_names(panel) -> None:
    (row,) = (r for r in panel.preview.rows if r["leaf"] == TOGETHER and r["channel"] == "near")
    leaves = [{**row, "leaf": f"leaf-{k}", "name": f"Leaf {k}"} for k in (10, 2, 1)]
    marked = {**row, "wf2_marked": 808}
    panel.grid.show_rows([*leaves, marked])
    names = [panel.grid.item(k, 0).text() for k in range(4)]
    assert names == ["Together", "Leaf 1", "Leaf 2", "Leaf 10"]
    cell = panel.grid.item(0, 2)
    lines = cell.text().split("\n")
    assert len(lines) == 3
    assert "±" in lines[0]
    assert lines[1].startswith("CV ")
    assert lines[2].endswith("808")
    assert "808 marked" in cell.toolTip()


def test_five_rows_are_seen_in_a_low_panel(panel, qtbot) -> None:
    panel.resize(380, 640)
    (row,) = (r for r in panel.preview.rows if r["leaf"] == TOGETHER and r["channel"] == "near")
    panel.grid.show_rows([row, *({**row, "leaf": f"leaf-{k}"} for k in range(8))])
    qtbot.wait(50)
    foot = panel.grid.mapTo(panel, panel.grid.rect().bottomLeft()).y()
    assert foot < panel.height()
    last = panel.grid.visualItemRect(panel.grid.item(4, 0))
    assert last.bottom() <= panel.grid.viewport().height()
