from __future__ import annotations

import numpy as np
import pytest

from app.services.cleanup import Answer, make_step
from app.services.cleanup.areas import compare_areas
from app.services.surfaces.meshes import measure_areas

KEY = "scan-00001"


def test_areas_are_those_of_the_table_after_the_clean_up(project, plan) -> None:
    state = project.state
    answers = np.full(len(plan), Answer.DELETE, np.int8)
    found = compare_areas(project, plan, answers)
    assert project.state.scans[KEY] is not None
    np.testing.assert_array_equal(project.state.scan(KEY).marks, state.scan(KEY).marks)
    assert project.state.scan(KEY).parameters == state.scan(KEY).parameters
    assert not project.state.scan(KEY).deleted.any()
    leaves = project.state.leaves_of(KEY)
    assert [(one.key, one.name) for one in found] == [(leaf.key, leaf.name) for leaf in leaves]
    before = measure_areas(project, KEY, leaves)
    project.do(make_step(project.state, plan, answers))
    after = measure_areas(project, KEY, project.state.leaves_of(KEY))
    for one in found:
        assert one.before == before[one.key]["area_cm2"]
        assert one.after == after[one.key]["area_cm2"]
        if one.before is not None:
            assert one.after == pytest.approx(one.before, rel=1e-9), "deletion shrinks no leaf"
    assert sum(one.after is not None for one in found) >= 4


def test_no_leaves_have_no_areas(make_scattered, plan) -> None:
    assert compare_areas(make_scattered(), plan, plan.proposal) == ()
