"""The jobs panel shows what takes time, and stops it."""

from __future__ import annotations

import threading

from PySide6.QtCore import Qt

from widgets.panels.jobs import PATIENCE, JobsPanel


def test_a_long_job_is_shown_and_can_be_cancelled(desk, qtbot) -> None:
    panel = desk.show(JobsPanel)
    assert "Nothing" in panel.notice.text
    ended = threading.Event()

    def work(progress) -> None:
        progress.report(0.25, "Normals")
        while not ended.wait(0.02):
            progress.report(0.25)

    job = desk.controller.run("Computing incidence", work, print)
    waiting = desk.controller.run("Fitting", lambda _: None, lambda _: None)
    qtbot.waitUntil(lambda: len(panel.rows) == 2)
    row = panel.rows[job]
    assert "Computing incidence" in row.title.text()
    qtbot.waitUntil(lambda: row.bar.value() == 250)
    assert "25 %" in row.detail.text()
    assert "Waiting" in panel.rows[waiting].detail.text()
    qtbot.mouseClick(row.button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: job.state == "cancelled", timeout=500)
    qtbot.waitUntil(lambda: not panel.rows)
    qtbot.waitUntil(lambda: "Nothing" in panel.notice.text)
    ended.set()


def test_a_short_job_is_never_shown(desk, qtbot) -> None:
    panel = desk.show(JobsPanel)
    done: list[object] = []
    desk.controller.run("Quick", lambda _: 7, done.append)
    qtbot.waitUntil(lambda: done == [7])
    qtbot.wait(2 * PATIENCE)
    assert not panel.rows
    assert "Nothing" in panel.notice.text


def test_a_job_that_fails_leaves_the_list(desk, qtbot) -> None:
    panel = desk.show(JobsPanel)
    go = threading.Event()

    def work(progress) -> None:
        go.wait(5)
        raise ValueError("on purpose")

    desk.controller.failed.disconnect()
    with qtbot.waitSignal(desk.controller.failed):
        desk.controller.run("Failing", work, print)
        qtbot.waitUntil(lambda: len(panel.rows) == 1)
        go.set()
    qtbot.waitUntil(lambda: not panel.rows)
