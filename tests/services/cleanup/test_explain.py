from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.ghosts import Reason, Reasons
from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.services.cleanup import Explainer
from app.services.cleanup.evidence import LeafNames, say_length, say_reason

KEY = "scan-00001"


def explain_ghost(project, scan, point) -> str:
    score = project.field(scan, "ghost_score")
    leaves = project.state.leaves_of(scan)
    return Explainer(project.state.scan(scan), leaves, score).explain(point).sentence


def make_reasons(reason, offset, light=0.41, border=0.6, member=(0, 1), incidence=1.4):
    return Reasons(
        np.array([reason], np.uint8), np.array([offset]), np.array([member]),
        None if light is None else np.array([light]), np.array([border]), np.array([incidence]),
    )  # fmt: skip


NAMES = LeafNames((), ("leaf 12", "wall"), np.array([0, 1], np.int32))


@pytest.mark.parametrize(
    ("reason", "offset", "words"),
    [
        (Reason.BETWEEN, (-0.014, 2.1), "between leaf 12 (−14 mm) and wall (+2.1 m), "
         "intensity 0.41 of expected, 0.6 beams from the border"),
        (Reason.BESIDE, (-0.014, -2.1), "behind leaf 12 (−14 mm) and all else around, "
         "intensity 0.41 of expected, 0.6 beams from the border"),
        (Reason.BESIDE, (0.0071, np.nan), "in front of leaf 12 (+7.1 mm) and all else around, "
         "intensity 0.41 of expected, 0.6 beams from the border"),
        (Reason.STEEP, (-0.014, np.nan), "in a steep, lengthened part of leaf 12 (−14 mm), seen "
         "at 80°, intensity 0.41 of expected, 0.6 beams from the border"),
        (Reason.WEAK, (-0.002, np.nan), "on leaf 12 (−2.0 mm), but nothing goes on through it, "
         "intensity 0.41 of expected, 0.6 beams from the border"),
    ],
)  # fmt: skip
def test_sentences(reason, offset, words) -> None:
    assert say_reason(make_reasons(reason, offset), 0, NAMES) == words


def test_what_is_not_known_is_not_said() -> None:
    alone = make_reasons(Reason.ALONE, (np.nan, np.nan), None, np.nan, (-1, -1))
    assert say_reason(alone, 0, NAMES) == "alone, no surface around"
    nameless = make_reasons(Reason.BETWEEN, (-0.014, 2.1), np.nan, np.nan, (-1, -1))
    assert say_reason(nameless, 0, NAMES) == (
        "between a surface (−14 mm) and another surface (+2.1 m)"
    )
    clean = make_reasons(Reason.ON_SURFACE, (0.0002, np.nan), None, np.nan)
    assert say_reason(clean, 0, NAMES, ghost=False) == "on leaf 12 (+0.2 mm)"


def test_lengths() -> None:
    assert [say_length(x) for x in (-0.0141, 2.14, 0.9996, 0.00061, -0.25)] == [
        "−14 mm", "+2.1 m", "+1.0 m", "+0.6 mm", "−250 mm",
    ]  # fmt: skip


def test_a_point_is_explained_as_the_plan_does(project, plan) -> None:
    for place in (0, len(plan) // 2, len(plan) - 1):
        sentence = explain_ghost(project, KEY, int(plan.ghosts[place]))
        said = plan.explain(place)
        assert sentence.startswith(f"Ghost (score {plan.score[place]:.2f}):")
        assert sentence.split(": ", 1)[1] == said.split(": ", 1)[1]


def test_good_points_and_the_users_word(project) -> None:
    score = project.field(KEY, "ghost_score")
    clean = int(np.flatnonzero(score == 0.0)[1000])
    assert explain_ghost(project, KEY, clean).startswith("No ghost (score 0.00): on ")
    project.do(MarkGhosts(KEY, ghosts=PointSet([clean])))
    assert explain_ghost(project, KEY, clean).startswith("Ghost by hand (score 0.00):")
    project.do(MarkGhosts(KEY, kept=PointSet([clean])))
    assert explain_ghost(project, KEY, clean).startswith("Kept by hand (score 0.00): on ")
    with pytest.raises(WrongUse, match="no point"):
        explain_ghost(project, KEY, len(score))


def test_without_a_grid_the_method_is_said(make_scattered) -> None:
    project = make_scattered()
    score = project.field(KEY, "ghost_score")
    told = Explainer(project.state.scan(KEY), (), score).explain(int(np.nanargmax(score)))
    assert told.ghost
    assert told.reason is None
    assert "density, weaker" in told.sentence
