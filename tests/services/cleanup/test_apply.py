from __future__ import annotations

import json

import numpy as np
import pytest

from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.services.cleaning import clean_up
from app.services.cleanup import Answer, make_step, sum_up
from app.services.cleanup.answers import answer_ghosts

KEY = "scan-00001"


def take(project):
    """All that a clean-up may touch, as plain arrays."""
    state = project.state.scan(KEY)
    members = {key: leaf.members.indices for key, leaf in project.state.leaves.items()}
    return state.scan.xyz.copy(), state.deleted.copy(), state.marks.copy(), members


def assert_same(one, other):
    for a, b in zip(one[:3], other[:3], strict=True):
        np.testing.assert_array_equal(a, b)
    assert one[3].keys() == other[3].keys()
    for key in one[3]:
        np.testing.assert_array_equal(one[3][key], other[3][key])


@pytest.fixture
def answers(plan):
    """Every answer there is, and some ghosts without one."""
    given = plan.proposal.copy()
    given[:5], given[5:10], given[10:15] = Answer.KEEP, Answer.LEAVE, 0
    return given


def test_apply_undo_redo_are_equal_to_the_bit(project, plan, answers) -> None:
    before, steps = take(project), len(project.history.done)
    project.do(make_step(project.state, plan, answers))
    assert len(project.history.done) == steps + 1
    after = take(project)
    project.undo()
    assert_same(take(project), before)
    project.redo()
    assert_same(take(project), after)


def test_each_answer_does_what_it_says(project, plan, answers) -> None:
    old = project.state.scan(KEY)
    project.do(make_step(project.state, plan, answers))
    new = project.state.scan(KEY)
    moved = np.flatnonzero((new.scan.xyz != old.scan.xyz).any(axis=1))
    corrected = plan.ghosts[answers == Answer.CORRECT]
    assert set(moved) <= set(corrected)
    np.testing.assert_array_equal(
        np.flatnonzero(new.deleted), plan.ghosts[answers == Answer.DELETE]
    )
    for places, mark in ((answers == Answer.KEEP, -1), (answers == Answer.LEAVE, 1),
                         (answers == 0, 0), (answers == Answer.CORRECT, -1)):  # fmt: skip
        assert (new.marks[plan.ghosts[places]] == mark).all()
    eye = np.array(old.scan.pose.position)
    before, now = old.scan.xyz[corrected] - eye, new.scan.xyz[corrected] - eye
    np.testing.assert_allclose(
        np.linalg.norm(now, axis=1) - np.linalg.norm(before, axis=1),
        plan.shift[answers == Answer.CORRECT], atol=1e-9,
    )  # fmt: skip
    assert np.abs(np.cross(before, now)).max() < 1e-9, "along the beam only"


def test_corrected_points_join_their_leaf_and_the_statistics_know(project, plan) -> None:
    answers = plan.proposal
    found = sum_up(plan, answers, project.state.scan(KEY).alive)
    project.do(make_step(project.state, plan, answers))
    alive = project.state.scan(KEY).alive
    assert found.ghosts == len(plan)
    assert found.by_answer["corrected"] == (answers == Answer.CORRECT).sum()
    assert found.by_answer["deleted"] == (answers == Answer.DELETE).sum()
    assert sum(found.by_answer.values()) == len(plan)
    assert sum(sum(counts.values()) for counts in found.by_reason.values()) == len(plan)
    grown = 0
    for leaf, change in zip(project.state.leaves.values(), found.leaves, strict=True):
        assert change.name == leaf.name
        assert change.after == alive[leaf.members.indices].sum()
        grown += change.after - change.before
    assert grown > 20
    shift = 1000.0 * np.abs(plan.shift[answers == Answer.CORRECT])
    assert found.shift_median == pytest.approx(np.median(shift))
    assert found.shift_95 == pytest.approx(np.quantile(shift, 0.95))
    json.dumps(found.as_json())


def test_most_corrected_points_come_nearer_to_the_truth(project, plan, leaves) -> None:
    eye = np.array(leaves.pose.position)
    truth = leaves.attributes["truth_range"] - leaves.attributes["truth_range_shift"]
    project.do(make_step(project.state, plan, plan.proposal))
    rows = plan.ghosts[plan.proposal == Answer.CORRECT]
    off = [
        np.abs(np.linalg.norm(xyz[rows] - eye, axis=1) - truth[rows])
        for xyz in (leaves.xyz, project.state.scan(KEY).scan.xyz)
    ]
    assert np.mean(off[1] < off[0]) > 0.7


def test_clean_up_is_one_step_with_a_title(project) -> None:
    steps = len(project.history.done)
    found = clean_up(project, KEY)
    assert len(project.history.done) == steps + 1
    title = project.history.done[-1].title
    assert title.startswith("Clean up ghosts: ")
    assert f"{found.by_answer['corrected']} corrected" in title.replace("\u202f", "")
    assert found.by_answer["left marked"] == 0


def test_answers_are_steps_with_titles_and_survive_undo(project, plan) -> None:
    points = plan.ghosts[:4]
    for answer, word in ((Answer.KEEP, "keep"), (Answer.DELETE, "delete"),
                         (Answer.CORRECT, "correct"), (Answer.LEAVE, "leave marked")):  # fmt: skip
        step = answer_ghosts(KEY, points, answer, "Leaf 2")
        assert step.title == f"Answer “{word}” for 4 ghosts of Leaf 2"
        project.do(step)
        assert (project.state.scan(KEY).marks[points] == answer).all()
    project.do(answer_ghosts(KEY, points, None))
    assert not project.state.scan(KEY).marks.any()
    for mark in (1, 3, 2, -1, 0):
        project.undo()
        assert (project.state.scan(KEY).marks[points] == mark).all()
    accepted = answer_ghosts(KEY, plan.ghosts, None, "", plan.proposal)
    project.do(accepted)
    np.testing.assert_array_equal(project.state.scan(KEY).marks[plan.ghosts], plan.proposal)
    assert accepted.title.startswith("Accept proposals for")


def test_marks_to_delete_and_correct_count_as_ghosts(project, plan) -> None:
    free = np.flatnonzero(project.field(KEY, "ghost") == 0.0)[:2]
    project.do(MarkGhosts(KEY, deleting=PointSet(free[:1]), correcting=PointSet(free[1:])))
    assert (project.field(KEY, "ghost")[free] == 1.0).all()
    assert project.history.done[-1].title == "Mark 1 point to delete, Mark 1 point to correct"
