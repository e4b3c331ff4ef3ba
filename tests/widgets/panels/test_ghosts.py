"""The ghosts panel counts what a threshold would do, and does it only when asked."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QStyle, QStyleOptionSlider

from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.model.scan import Pose, Scan
from app.services.opening import add_scans
from widgets.panels.ghosts import GhostsPanel


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(GhostsPanel)
    qtbot.waitUntil(lambda: "Compute" in panel.notice.button.text())
    qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: panel.finder.counts is not None, timeout=60_000)
    return panel


def brute_count(opened, threshold: float) -> int:
    key, state = opened.controller.current, opened.controller.scan
    score = opened.controller.project.field(key, "ghost_score")
    marks = state.marks
    ghost = ((score >= threshold) & (marks == 0)) | (marks == 1)
    return int((ghost & state.alive).sum())


def said_count(panel) -> int:
    return int(panel.finder.summary.text().split("<b>")[1].split(" ")[0].replace("\u202f", ""))


def test_counts_are_those_of_the_score(panel, opened, qtbot) -> None:
    threshold = opened.controller.scan.parameters.ghost_threshold
    assert panel.finder.threshold == threshold
    assert said_count(panel) == brute_count(opened, threshold) > 100
    for value in (0.01, 0.31, 0.5, 0.99, 1.0):
        panel.finder.show_threshold(value)
        assert said_count(panel) == brute_count(opened, value)
    assert (
        panel.finder.counts.histogram.sum()
        == panel.finder.counts.total
        == opened.controller.scan.shown
    )
    panel.finder.show_threshold(0.0)
    assert panel.finder.threshold == 0.01, "a threshold of 0 would call every point a ghost"


def test_dragging_previews_and_releasing_commits(panel, opened, qtbot) -> None:
    qtbot.mouseClick(panel.finder.settings.more, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(panel.finder.settings.slider.isVisible)
    steps = len(opened.controller.project.history.done)
    old = opened.controller.scan.parameters.ghost_threshold
    option = QStyleOptionSlider()
    panel.finder.settings.slider.initStyleOption(option)
    start = (
        panel.finder.settings.slider.style()
        .subControlRect(
            QStyle.ComplexControl.CC_Slider,
            option,
            QStyle.SubControl.SC_SliderHandle,
            panel.finder.settings.slider,
        )
        .center()
    )
    qtbot.mousePress(panel.finder.settings.slider, Qt.MouseButton.LeftButton, pos=start)
    for step in (20, 40, 70):
        qtbot.mouseMove(panel.finder.settings.slider, start - QPoint(step, 0))
    qtbot.waitUntil(lambda: panel.finder.threshold < old)
    wanted = panel.finder.threshold
    assert said_count(panel) == brute_count(opened, wanted)
    assert panel.finder.plot.line.value() == pytest.approx(wanted)
    assert opened.controller.scan.parameters.ghost_threshold == old
    assert len(opened.controller.project.history.done) == steps
    qtbot.mouseRelease(
        panel.finder.settings.slider, Qt.MouseButton.LeftButton, pos=start - QPoint(70, 0)
    )
    assert opened.controller.scan.parameters.ghost_threshold == wanted
    assert len(opened.controller.project.history.done) == steps + 1
    opened.controller.undo()
    qtbot.waitUntil(lambda: panel.finder.threshold == old)
    assert said_count(panel) == brute_count(opened, old)


def test_a_typed_threshold_is_one_step(panel, opened, qtbot) -> None:
    qtbot.mouseClick(panel.finder.settings.more, Qt.MouseButton.LeftButton)
    steps = len(opened.controller.project.history.done)
    panel.finder.settings.field.setFocus()
    panel.finder.settings.field.selectAll()
    qtbot.keyClicks(panel.finder.settings.field, "0.25")
    qtbot.keyClick(panel.finder.settings.field, Qt.Key.Key_Return)
    assert opened.controller.scan.parameters.ghost_threshold == 0.25
    assert panel.finder.settings.slider.value() == 25
    assert len(opened.controller.project.history.done) == steps + 1


def test_mark_unmark_and_undo(panel, opened, qtbot) -> None:
    ghosts = said_count(panel)
    assert not panel.finder.unmark_button.isEnabled()
    qtbot.mouseClick(panel.finder.mark_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: (opened.controller.scan.marks == 1).sum() == ghosts)
    qtbot.waitUntil(lambda: panel.finder.unmark_button.isEnabled())
    assert "Judged by hand" in panel.finder.summary.text()
    panel.finder.show_threshold(1.0)
    assert said_count(panel) >= ghosts, "what is marked stays a ghost at any threshold"
    qtbot.mouseClick(panel.finder.unmark_button, Qt.MouseButton.LeftButton)
    assert not opened.controller.scan.marks.any()
    opened.controller.undo()
    qtbot.waitUntil(lambda: "Judged by hand" in panel.finder.summary.text())


def test_kept_points_are_no_ghosts(panel, opened, qtbot) -> None:
    before = said_count(panel)
    key, score = opened.controller.current, opened.controller.project.field(
        opened.controller.current, "ghost_score"
    )  # fmt: skip
    kept = PointSet(np.argsort(score)[-10:])
    opened.controller.do(MarkGhosts(key, kept=kept))
    qtbot.waitUntil(lambda: said_count(panel) == before - 10)


def test_delete_and_bring_back(panel, opened, qtbot) -> None:
    ghosts, shown = said_count(panel), opened.controller.scan.shown
    qtbot.mouseClick(panel.finder.delete_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: opened.controller.scan.shown == shown - ghosts)
    qtbot.waitUntil(lambda: said_count(panel) == 0)
    assert not panel.finder.delete_button.isEnabled()
    opened.controller.undo()
    qtbot.waitUntil(lambda: said_count(panel) == ghosts)


def test_correction_moves_ghosts_and_finds_the_score_anew(panel, opened, qtbot) -> None:
    old = opened.controller.scan.scan.xyz
    qtbot.mouseClick(panel.finder.correct_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: opened.controller.scan.scan.xyz is not old, timeout=30_000)
    qtbot.waitUntil(lambda: panel.known_score is not None, timeout=30_000)
    qtbot.waitUntil(lambda: panel.finder.isVisible())
    opened.controller.undo()
    assert np.array_equal(opened.controller.scan.scan.xyz, old)
    qtbot.waitUntil(lambda: panel.known_score is not None, timeout=30_000)


def test_the_cloud_can_be_coloured_and_gets_its_colour_back(panel, opened, qtbot) -> None:
    opened.controller.look(colour="far")
    qtbot.mouseClick(
        panel.finder.preview,
        Qt.MouseButton.LeftButton,
        pos=QPoint(8, panel.finder.preview.height() // 2),
    )
    assert opened.controller.view.colour == "ghost"
    qtbot.mouseClick(
        panel.finder.preview,
        Qt.MouseButton.LeftButton,
        pos=QPoint(8, panel.finder.preview.height() // 2),
    )
    assert opened.controller.view.colour == "far"


def test_a_missing_position_is_said(desk, qtbot, make_scan) -> None:
    panel = desk.show(GhostsPanel)
    assert "Open a scan" in panel.notice.text
    key = desk.open(make_scan(pose=False))
    qtbot.waitUntil(lambda: "where the scanner stood" in panel.notice.text)
    with qtbot.waitSignal(panel.origin_asked) as asked:
        qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    assert asked.args == [key]


def test_three_steps_set_the_threshold_each_as_one_step(panel, opened, qtbot) -> None:
    steps, settings = len(opened.controller.project.history.done), panel.finder.settings
    settings.steps.setFocus()
    qtbot.keyClick(settings.steps, Qt.Key.Key_Left)
    assert opened.controller.scan.parameters.ghost_threshold == 0.8
    assert "good points" in settings.step_words.text()
    qtbot.keyClick(settings.steps, Qt.Key.Key_Right)
    qtbot.keyClick(settings.steps, Qt.Key.Key_Right)
    assert opened.controller.scan.parameters.ghost_threshold == 0.2
    assert len(opened.controller.project.history.done) == steps + 3
    panel.finder.show_threshold(0.63)
    assert "own threshold" in settings.step_words.text()


def test_the_method_of_the_score_is_said(panel) -> None:
    assert "scan grid" in panel.finder.method.text()


def test_without_rows_and_columns_nothing_is_corrected_and_marks_are_proposed(desk, qtbot) -> None:
    chance = np.random.default_rng(2)
    xyz = np.array([2.0, 0.0, 0.0]) + 0.05 * chance.random((3000, 3))
    pose = Pose((0.0, 0.0, 0.0), known_by="given")
    (key,) = add_scans(desk.controller.project, [Scan("loose", xyz, {}, (), pose)])
    desk.controller.look(current=key)
    panel = desk.show(GhostsPanel)
    qtbot.waitUntil(lambda: "Compute" in panel.notice.button.text())
    qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: panel.finder.counts is not None, timeout=60_000)
    assert "weaker" in panel.finder.method.text()
    assert not panel.finder.correct_button.isEnabled()
    assert "without rows and columns" in panel.finder.correct_button.toolTip()
    settings = panel.finder.settings
    assert settings.uncertain == "mark"
    settings.uncertain_box.setCurrentIndex(0)
    panel.refresh()
    assert settings.uncertain == "delete", "the user's choice stays"
