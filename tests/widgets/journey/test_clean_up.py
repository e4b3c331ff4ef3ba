"""A user cleans a simulated scan of ghosts: by keys in queue and picture, by batch, then undoes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu, QToolTip

from app.render.camera import turn
from app.services.cleanup.answers import Answer
from app.services.opening import add_scans
from app.simulate.scenes import leaves_scan

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]


def place_of(view: Any, xyz: np.ndarray) -> QPoint:
    from app.core.screen import project

    seen = view.current_view()
    x, y = project(xyz[None], seen.origin, seen.matrix, seen.size).px[0]
    return QPoint(round(x / seen.size[0] * view.width()), round(y / seen.size[1] * view.height()))


def test_clean_up(user: Any) -> None:
    window, controller = user.window, user.window.controller
    (key,) = add_scans(controller.project, [leaves_scan(seed=4, leaves=6, step_deg=0.05)])
    controller.look(current=key)
    user.rest()
    user.press("Find leaves", user.panel("leaves"))
    user.wait_for(lambda: len(controller.project.state.leaves) >= 3)
    user.rest()

    # The score, then the queue.
    panel = user.panel("ghosts")
    user.rest()
    if panel.notice.button.isVisible():
        user.press("Compute score", panel)
    user.wait_for(lambda: panel.known_score is not None)
    user.look("ghosts")
    bar = panel.pages.tabBar()
    user.click(bar, bar.tabRect(1).center())
    page, session, view = panel.page, panel.page.session, window.picture.view
    user.wait_for(lambda: session.plan is not None)
    user.rest()

    # N moves the camera to the ghost, seen across its beam.
    QTest.keyClick(page.table, Qt.Key.Key_N)
    user.rest()
    assert session.row == 0
    ghost, eye = controller.scan.scan.xyz[session.ghost], controller.scan.scan.pose.position
    spot = place_of(view, ghost)
    assert abs(spot.y() - view.height() / 2) < 0.1 * view.height()
    assert 0.2 * view.width() < spot.x() < 0.7 * view.width()
    beam, sight = ghost - eye, ghost - np.array(view.camera().position)
    cosine = beam @ sight / np.linalg.norm(beam) / np.linalg.norm(sight)
    assert 0.3 < cosine <= 1.0
    user.look("ghosts-session")

    # Who turns the picture keeps his view of the next one.
    view.set_camera(turn(view.camera(), 0.4, 0.1))
    axes = view.camera().axes()
    QTest.keyClick(page.table, Qt.Key.Key_N)
    user.rest()
    assert np.allclose(view.camera().axes(), axes)
    spot = place_of(view, controller.scan.scan.xyz[session.ghost])
    assert abs(spot.y() - view.height() / 2) < 0.1 * view.height()
    QTest.keyClick(page.table, Qt.Key.Key_P)
    user.rest()

    # The same letters while the picture has the focus: no tool and no panel comes instead.
    view.setFocus()
    tool, steps = window.tools.tool, len(controller.project.history.done)
    first = session.ghost
    QTest.keyClick(view, Qt.Key.Key_A)
    second = session.ghost
    QTest.keyClick(view, Qt.Key.Key_R)
    QTest.keyClick(view, Qt.Key.Key_P)
    user.rest()
    marks = controller.scan.marks
    assert (marks[first], marks[second]) == (session.plan.proposal[session.order[0]], Answer.KEEP)
    assert session.ghost == second
    assert len(controller.project.history.done) == steps + 2
    assert window.tools.tool == tool
    assert panel.isVisible()

    # A leaf at a time.
    row = next(i for i, b in enumerate(session.batches) if b.name.startswith("Leaf"))
    page.batch_box.setFocus()
    while page.batch_box.currentIndex() != row:
        QTest.keyClick(page.batch_box, Qt.Key.Key_Down)
    page.batch_box.activated.emit(row)
    user.rest()
    assert page.model.rowCount() == len(session.batches[row].places)
    places = session.order
    user.click(page.batch_button)
    menu = page.batch_button.menu()
    user.wait_for(menu.isVisible)
    choose(menu, "Delete all")
    user.rest()
    members = session.plan.ghosts[places]
    assert (controller.scan.marks[members] == Answer.DELETE).all()

    # After, without a change; then applied, in one step.
    before, steps = controller.project.state, len(controller.project.history.done)
    user.click(page.after_button)
    user.wait_for(lambda: "after" not in page.after_button.text().replace("&", ""))
    user.rest()
    assert window.picture._instead is not None
    assert controller.project.state is before
    user.look("ghosts-after")
    user.click(page.after_button)
    user.rest()
    assert window.picture._instead is None
    user.click(page.apply_button)
    user.wait_for(lambda: len(controller.project.history.done) == steps + 1)
    assert controller.scan.deleted[members].all()
    assert "Done:" in page.done.text()
    user.rest()
    user.look("ghosts-done")

    # Undone: everything is as it was, and the queue is there again.
    user.keys("Ctrl+Z")
    user.rest()
    user.wait_for(lambda: session.plan is not None)
    old = before.scan(key)
    assert np.array_equal(controller.scan.scan.xyz, old.scan.xyz)
    assert np.array_equal(controller.scan.marks, old.marks)
    assert np.array_equal(controller.scan.deleted, old.deleted)
    assert controller.project.state.leaves == before.leaves


def choose(menu: QMenu, text: str) -> None:
    """Click an entry of an open menu."""
    action = next(a for a in menu.actions() if a.text().replace("&", "") == text)
    QTest.mouseClick(menu, Qt.MouseButton.LeftButton, pos=menu.actionGeometry(action).center())


def test_hovering_and_picking_say_why(user: Any) -> None:
    window, controller = user.window, user.window.controller
    (key,) = add_scans(controller.project, [leaves_scan(seed=4, leaves=6, step_deg=0.05)])
    controller.look(current=key)
    user.rest()
    panel = user.panel("ghosts")
    user.press("Compute score", panel)
    user.wait_for(lambda: panel.known_score is not None)
    user.rest()
    view, scan = window.picture.view, controller.scan.scan
    score = np.nan_to_num(panel.known_score.values)
    spot = place_of(view, scan.xyz[int(np.argmax(score))])
    QTest.mouseMove(view, spot + QPoint(40, 0))
    QTest.mouseMove(view, spot)
    user.wait_for(QToolTip.isVisible)
    assert "host (score" in QToolTip.text()
    QToolTip.hideText()
    user.tool("tool.pick")
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=spot)
    user.wait_for(panel.point.isVisible)
    assert "(score" in panel.point.text()
    sentence = user.panel("pick").ghost
    user.wait_for(sentence.isVisible)
    assert sentence.text() == panel.point.text()
