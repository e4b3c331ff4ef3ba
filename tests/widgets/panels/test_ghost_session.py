"""Going through the ghosts: queue, keys, batches, the lasso's selection, apply and undo."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence, QShortcut

from app.model.operations import Select
from app.model.points import PointSet
from app.services.cleanup.answers import Answer
from widgets.panels.ghosts import GhostsPanel

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(GhostsPanel)
    qtbot.waitUntil(lambda: "Compute" in panel.notice.button.text())
    qtbot.mouseClick(panel.notice.button, LEFT)
    qtbot.waitUntil(lambda: panel.known_score is not None, timeout=60_000)
    bar = panel.pages.tabBar()
    qtbot.mouseClick(bar, LEFT, pos=bar.tabRect(1).center())
    qtbot.waitUntil(lambda: panel.page.session.plan is not None, timeout=60_000)
    return panel


def marks_of(panel):
    return panel.controller.scan.marks


def test_the_queue_is_shown_and_n_and_p_walk_in_it(panel, qtbot) -> None:
    page, session = panel.page, panel.page.session
    assert page.model.rowCount() == len(session.plan) > 100
    assert "N shows" in page.sentence.text()
    qtbot.keyClick(page.table, Qt.Key.Key_N)
    assert session.row == 0
    assert page.table.currentIndex().row() == 0
    assert page.sentence.text().startswith("Score 0.")
    assert "Proposed: " in page.proposal.text()
    qtbot.keyClick(page.table, Qt.Key.Key_N)
    qtbot.keyClick(page.table, Qt.Key.Key_N)
    assert session.row == 2
    qtbot.keyClick(page.table, Qt.Key.Key_P)
    assert session.row == 1
    qtbot.mouseClick(page.back_button, LEFT)
    qtbot.mouseClick(page.back_button, LEFT)
    assert session.row == 0
    place = page.table.visualRect(page.model.index(4, 0)).center()
    qtbot.mouseClick(page.table.viewport(), LEFT, pos=place)
    assert session.row == 4


def test_each_letter_answers_and_goes_on_to_the_next_open_one(panel, qtbot) -> None:
    page, session = panel.page, panel.page.session
    order = session.order
    assert session.plan.correctable[order[3]]
    qtbot.keyClick(page.table, Qt.Key.Key_N)
    steps = len(panel.controller.project.history.done)
    for key in (Qt.Key.Key_A, Qt.Key.Key_R, Qt.Key.Key_D, Qt.Key.Key_C):
        qtbot.keyClick(page.table, key)
    ghosts = session.plan.ghosts[order[:5]]
    proposed = session.plan.proposal[order[0]]
    assert marks_of(panel)[ghosts].tolist() == [proposed, -1, 2, 3, 0]
    assert session.row == 4
    titles = [step.title for step in panel.controller.project.history.done[steps:]]
    assert titles[1:] == [f"Answer “{word}” for 1 ghost" for word in ("keep", "delete", "correct")]
    for _ in range(4):
        panel.controller.undo()
    assert not marks_of(panel).any()
    qtbot.waitUntil(lambda: "0 of" in page.tally.text())


def test_letters_of_the_window_are_only_lent(panel, qtbot) -> None:
    fired = []
    shortcuts = [QShortcut(QKeySequence(key), panel.window()) for key in "NPARDC"]
    for shortcut in shortcuts:
        shortcut.activated.connect(partial_append(fired, shortcut.key().toString()))
    panel.window().activateWindow()
    qtbot.waitUntil(panel.isActiveWindow)
    panel.page.table.setFocus()
    qtbot.keyClick(panel.page.table, Qt.Key.Key_N)
    qtbot.keyClick(panel.page.table, Qt.Key.Key_A)
    assert fired == []
    assert panel.page.session.row == 1
    panel.pages.setCurrentIndex(0)
    qtbot.waitUntil(panel.finder.isVisible)
    panel.finder.mark_button.setFocus()
    qtbot.keyClick(panel.finder.mark_button, Qt.Key.Key_N)
    assert fired == ["N"]


def partial_append(where, what):
    def note() -> None:
        where.append(what)

    return note


def test_a_batch_is_answered_in_one_step(panel, opened, qtbot) -> None:
    page, session = panel.page, panel.page.session
    names = [page.batch_box.itemData(row) for row in range(page.batch_box.count())]
    assert names[:3] == ["", "Leaf 1", "Leaf 2"]
    row = names.index("Leaf 2")
    assert page.batch_box.itemText(row) == f"Leaf 2: {len(session.batches[row].places)}"
    page.batch_box.setCurrentIndex(row)
    page.batch_box.activated.emit(row)
    assert page.model.rowCount() == len(session.batches[row].places)
    places = session.order
    action(page.batch_button, "Delete all").trigger()
    assert (marks_of(panel)[session.plan.ghosts[places]] == Answer.DELETE).all()
    assert (marks_of(panel) != 0).sum() == len(places)
    title = opened.controller.project.history.done[-1].title
    assert title.endswith("ghosts of Leaf 2")
    action(page.batch_button, "Take answers back").trigger()
    assert not marks_of(panel).any()


def action(button, text):
    return next(a for a in button.menu().actions() if a.text().replace("&", "") == text)


def test_the_selection_is_answered_where_it_holds_ghosts(panel, opened, qtbot) -> None:
    page, session = panel.page, panel.page.session
    assert not page.lasso_button.isEnabled()
    others = np.flatnonzero(panel.known_score.values == 0.0)[:50]
    chosen = session.plan.ghosts[10:30]
    both = PointSet(np.concatenate((others, chosen)))
    opened.controller.do(Select(opened.controller.current, both))
    qtbot.waitUntil(page.lasso_button.isEnabled)
    action(page.lasso_button, "Keep all").trigger()
    assert np.flatnonzero(marks_of(panel)).tolist() == chosen.tolist()
    assert (marks_of(panel)[chosen] == Answer.KEEP).all()


def test_apply_is_one_step_and_undo_brings_everything_back(panel, opened, qtbot) -> None:
    page, session = panel.page, panel.page.session
    qtbot.keyClick(page.table, Qt.Key.Key_N)
    qtbot.keyClick(page.table, Qt.Key.Key_R)
    answers, plan = session.answers(), session.plan
    old, steps = opened.controller.scan, len(opened.controller.project.history.done)
    qtbot.mouseClick(page.apply_button, LEFT)
    assert len(opened.controller.project.history.done) == steps + 1
    new = opened.controller.scan
    assert (new.deleted.sum()) == (answers == Answer.DELETE).sum()
    moved = (new.scan.xyz != old.scan.xyz).any(axis=1).sum()
    assert 0 < moved <= (answers == Answer.CORRECT).sum()
    qtbot.waitUntil(lambda: session.plan is not None and session.plan is not plan, timeout=60_000)
    assert "Done:" in page.done.text()
    assert page.done.isVisible()
    qtbot.waitUntil(lambda: "Area of " in page.done.text(), timeout=60_000)
    assert " cm² before, " in page.done.text()
    assert "cm² before" in page.done.toolTip()
    opened.controller.undo()
    back = opened.controller.scan
    assert np.array_equal(back.scan.xyz, old.scan.xyz)
    assert np.array_equal(back.marks, old.marks)
    assert np.array_equal(back.deleted, old.deleted)
    qtbot.waitUntil(
        lambda: session.plan is not None and np.array_equal(session.plan.ghosts, plan.ghosts),
        timeout=60_000,
    )
    qtbot.waitUntil(lambda: not page.done.isVisible())


def test_only_answers_are_done_where_proposals_do_not_count(panel, opened, qtbot) -> None:
    page, session = panel.page, panel.page.session
    page.proposals.setChecked(False)
    steps = len(opened.controller.project.history.done)
    qtbot.mouseClick(page.apply_button, LEFT)
    assert len(opened.controller.project.history.done) == steps, "nothing is answered yet"
    qtbot.keyClick(page.table, Qt.Key.Key_N)
    ghost = session.ghost
    qtbot.keyClick(page.table, Qt.Key.Key_D)
    qtbot.mouseClick(page.apply_button, LEFT)
    assert np.flatnonzero(opened.controller.scan.deleted).tolist() == [ghost]


def test_settings_behind_the_disclosure_change_the_proposals(panel, opened, qtbot) -> None:
    session, settings = panel.page.session, panel.finder.settings
    before = session.plan
    panel.finder.settings.uncertain_box.setCurrentIndex(1)
    qtbot.waitUntil(lambda: session.plan is not None and session.plan is not before)
    assert (session.plan.proposal != Answer.DELETE).all()
    settings.sure_field.setValue(1.0)
    qtbot.waitUntil(
        lambda: session.plan is not None and (session.plan.proposal == Answer.LEAVE).all()
    )


def test_ghosts_marked_by_hand_join_the_queue(panel, opened, qtbot) -> None:
    session, count = panel.page.session, len(panel.page.session.plan)
    clean = np.flatnonzero(panel.known_score.values == 0.0)[:3]
    opened.work.apply(opened.controller.current, PointSet(clean), None, "ghost")
    qtbot.waitUntil(lambda: session.plan is not None and len(session.plan) == count + 3)
    opened.controller.undo()
    qtbot.waitUntil(lambda: session.plan is not None and len(session.plan) == count)
