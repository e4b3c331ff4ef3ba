"""Selections as expressions, against sets of row numbers that are worked out one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.model.codec import decode, encode
from app.model.operations import Select
from app.model.points import PointSet
from app.model.selection import (
    Complement,
    Difference,
    Explicit,
    FieldRange,
    Intersection,
    Selection,
    Union,
    evaluate,
)

SIZE = 12
FIELDS = {
    "angle": np.array([0, 5, 10, 15, 20, 25, 30, np.nan, 40, 45, 50, 55.0]),
    "near": np.array([9, 8, 7, 6, 5, 4, 3, 2, np.nan, 1, 0, -1.0]),
}
ALLOWED = np.arange(SIZE) != 3

leaves = st.one_of(
    st.sets(st.integers(0, SIZE - 1)).map(lambda rows: Explicit(PointSet(rows))),
    st.builds(
        lambda field, ends: FieldRange(field, min(ends), max(ends)),
        st.sampled_from(sorted(FIELDS)),
        st.tuples(st.floats(-2, 60), st.floats(-2, 60)),
    ),
)
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda parts: Intersection(tuple(parts))),
        st.lists(inner, max_size=3).map(lambda parts: Union(tuple(parts))),
        st.builds(Difference, inner, inner),
        st.builds(Complement, inner),
    ),
    max_leaves=6,
)


def holds(selection: Selection, row: int) -> bool:
    """Whether one point belongs to a selection, said again in plain logic."""
    match selection:
        case Explicit():
            return row in selection.points.indices.tolist()
        case FieldRange():
            return selection.low <= FIELDS[selection.field][row] <= selection.high
        case Intersection():
            return all(holds(part, row) for part in selection.of)
        case Union():
            return any(holds(part, row) for part in selection.of)
        case Difference():
            return holds(selection.of, row) and not holds(selection.less, row)
        case Complement():
            return not holds(selection.of, row)
    raise AssertionError(selection)


def find(selection: Selection) -> list[int]:
    return evaluate(selection, np.zeros((SIZE, 3)), ALLOWED, FIELDS.__getitem__).indices.tolist()


@given(expressions)
def test_an_expression_means_what_logic_says(selection: Selection) -> None:
    assert find(selection) == [row for row in range(SIZE) if ALLOWED[row] and holds(selection, row)]


def test_a_brush_over_angles_and_intensities() -> None:
    brush = Intersection((FieldRange("angle", 10.0, 40.0), FieldRange("near", 3.0, 7.0)))
    assert find(brush) == [2, 4, 5, 6]


def test_a_selection_of_an_older_session_has_no_drag() -> None:
    arrays = {"a-0": np.array([1, 4])}
    step = decode(b'{"op": "Select", "scan": "scan-00001", "points": {"array": "a-0"}}', arrays)
    assert step == Select("scan-00001", PointSet([1, 4]))
    assert step.drag == ""


@pytest.mark.parametrize("drag", ["", "brush-1"])
def test_a_brush_is_stored_with_what_it_meant(drag: str) -> None:
    basis = Intersection((FieldRange("angle", 10.0, 40.0), FieldRange("near", 3.0, 7.0)))
    step, arrays = Select("scan-00001", PointSet([2, 4]), basis, drag), {}
    assert decode(encode(step, arrays, "a"), arrays) == step
