from __future__ import annotations

import re

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.ghosts import SURE, Reason
from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.services.cleanup import Answer, Explainer, plan_cleanup
from app.services.cleanup.queue import list_batches, order_by_doubt
from widgets.common.ghosts.counts import count_ghosts

KEY = "scan-00001"


def test_ghosts_are_those_of_the_field(project, plan) -> None:
    ghost = project.field(KEY, "ghost") == 1.0
    np.testing.assert_array_equal(plan.ghosts, np.flatnonzero(ghost))
    np.testing.assert_allclose(plan.score, project.field(KEY, "ghost_score")[ghost])
    shift = project.field(KEY, "ghost_correction")[ghost]
    np.testing.assert_allclose(plan.shift * 1000.0, shift, atol=1e-9)
    np.testing.assert_allclose(plan.confidence, project.field(KEY, "ghost_confidence")[ghost])
    np.testing.assert_array_equal(plan.reasons.reason, project.field(KEY, "ghost_reason")[ghost])


def test_sure_corrections_are_proposed_and_the_rest_as_wished(project, plan) -> None:
    sure = plan.correctable & (plan.confidence >= SURE)
    assert 0 < sure.sum() < len(plan)
    assert (plan.proposal[sure] == Answer.CORRECT).all()
    assert (plan.proposal[~sure] == Answer.DELETE).all()
    marked = plan_cleanup(project, KEY, uncertain="mark")
    assert (marked.proposal[~sure] == Answer.LEAVE).all()
    none = plan_cleanup(project, KEY, sure=1.0)
    assert (none.proposal == Answer.CORRECT).sum() < sure.sum()
    with pytest.raises(WrongUse, match="0 to 1"):
        plan_cleanup(project, KEY, sure=1.5)


def test_the_users_word_goes_before_the_proposal(project, plan) -> None:
    kept, deleted, marked = plan.ghosts[:3], plan.ghosts[3:5], plan.ghosts[5:7]
    project.do(
        MarkGhosts(KEY, kept=PointSet(kept), deleting=PointSet(deleted), ghosts=PointSet(marked))
    )
    marks = project.state.scan(KEY).marks
    answers = plan.answers(marks)
    assert answers[:5].tolist() == [-1, -1, -1, 2, 2]
    np.testing.assert_array_equal(answers[5:], plan.proposal[5:])
    open_ = plan.answers(marks, proposals=False)
    assert open_[:5].tolist() == [-1, -1, -1, 2, 2]
    assert not open_[5:].any(), "a mark as ghost alone is no answer"
    again = plan_cleanup(project, KEY)
    np.testing.assert_array_equal(again.ghosts, plan.ghosts)


def test_what_has_no_surface_is_not_corrected(project, plan) -> None:
    plan.shift[0] = np.nan
    project.do(MarkGhosts(KEY, correcting=PointSet(plan.ghosts[:2])))
    answers = plan.answers(project.state.scan(KEY).marks)
    assert answers[:2].tolist() == [Answer.LEAVE, Answer.CORRECT]


def test_sentences_name_leaves_and_numbers(plan) -> None:
    between = np.flatnonzero((plan.reasons.reason == Reason.BETWEEN) & (plan.leaf >= 0))
    assert len(between) > 10
    said = plan.explain(between[0])
    pattern = (
        r"score \d\.\d\d: between Leaf \d \([−+][\d.]+ mm\) and .+ \([−+][\d.]+ m?m\), "
        r"intensity \d\.\d\d of expected, \d\.\d beams from the border"
    )
    assert re.fullmatch(pattern, said)
    first, second = plan.reasons.offset[between[0]]
    assert ("(−" in said.split(" and ")[0]) == (first < 0)
    assert first * second < 0


def test_the_leaf_of_a_ghost_is_that_of_the_nearest_surface(project, plan, leaves) -> None:
    truth = leaves.attributes["truth_leaf"][plan.ghosts]
    told = plan.leaf >= 0
    assert told.sum() > 50
    assert (plan.leaf[told] == truth[told]).mean() > 0.9


def test_doubtful_ghosts_come_first_and_batches_are_whole(plan) -> None:
    order = order_by_doubt(plan)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(plan)))
    doubt = np.floor(np.abs(plan.score - plan.threshold)[order] / 0.1)
    assert (np.diff(doubt) >= 0).all()
    batches = list_batches(plan, order)
    assert batches[0].name == ""
    np.testing.assert_array_equal(batches[0].places, order)
    by_leaf = [b for b in batches if b.name.startswith("Leaf") or b.name == "no leaf"]
    assert sum(len(b.places) for b in by_leaf) == len(plan)
    for batch in batches:
        assert len(batch.places) > 0
        rank = np.argsort(order)[batch.places]
        assert (np.diff(rank) > 0).all(), "in the order of the queue"
    number = plan.names.names.index(by_leaf[0].name)
    assert (plan.leaf[by_leaf[0].places] == number).all()


def test_without_rows_and_columns_the_score_says_that_it_is_weaker(make_scattered) -> None:
    project = make_scattered()
    plan = plan_cleanup(project, KEY)
    assert "weaker" in plan.method
    assert plan.reasons is None
    assert "weaker" in plan.explain(0)
    names = [batch.name for batch in list_batches(plan, order_by_doubt(plan))]
    assert names == [""]


def test_what_is_uncertain_is_marked_where_the_score_is_weak(project, make_scattered) -> None:
    assert plan_cleanup(project, KEY, uncertain=None).uncertain == "delete"
    weak = plan_cleanup(make_scattered(), KEY, uncertain=None)
    assert weak.uncertain == "mark"
    assert (weak.proposal == Answer.LEAVE).all()


def test_a_ghost_is_what_reaches_the_threshold_everywhere(project, plan) -> None:
    """The score of a point itself as threshold: window, field, plan and reasons agree."""
    score = project.field(KEY, "ghost_score")
    edge = float(np.sort(plan.score)[len(plan) // 2])
    project.set_parameters(KEY, ghost_threshold=edge)
    wanted = np.flatnonzero(score >= edge)
    state = project.state.scan(KEY)
    np.testing.assert_array_equal(plan_cleanup(project, KEY).ghosts, wanted)
    np.testing.assert_array_equal(np.flatnonzero(project.field(KEY, "ghost") == 1.0), wanted)
    counts = count_ghosts(score, state.marks, state.alive)
    assert counts.count(edge) == len(wanted)
    explainer = Explainer(state, (), score)
    at_edge = int(np.flatnonzero(score == edge)[0])
    assert explainer.explain(at_edge).ghost
    assert explainer.explain(at_edge).reason != Reason.ON_SURFACE
    below = int(np.flatnonzero((score < edge) & (score > 0.5))[-1])
    told = explainer.explain(below)
    assert not told.ghost
    assert told.reason == Reason.ON_SURFACE
    assert told.sentence.startswith("No ghost (score ")
