"""Operations and their inverses, over generated sequences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from app.core.errors import BadInput, WrongUse
from app.model.codec import decode, encode
from app.model.leaf import Leaf, Sample
from app.model.operations import (
    AddScan,
    AnyOperation,
    CloseScan,
    Coordinates,
    MarkGhosts,
    MovePoints,
    Numbers,
    PutLeaf,
    PutSample,
    PutSeries,
    Select,
    SetChannels,
    SetDeleted,
    SetParameters,
    SetPose,
    Several,
)
from app.model.parameters import Curve, Parameters
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.model.selection import Difference, Explicit, FieldRange, Intersection
from app.model.series import Correction, Series, SeriesEntry
from app.model.state import State

SIZE = 40
points = st.sets(st.integers(0, SIZE - 1)).map(PointSet)
leaf_keys = st.sampled_from(["leaf-00001", "leaf-00002", "leaf-00012"])


def make_leaf(key: str, members: PointSet) -> Leaf:
    basis = (Difference(Explicit(members), FieldRange("range", 0.0, 1.0)),)
    return Leaf(key, "scan-00001", f"name of {key}", members, basis)


def make_series(corrected: PointSet) -> Series:
    entry = SeriesEntry("scan-00001", 5.0, corrections=(Correction("leaf-00001", corrected),))
    return Series("series-00001", "stage", (entry,), "scan-00001")


def brush(chosen: PointSet, drag: str) -> Select:
    basis = Intersection((FieldRange("incidence", 10.0, 20.0), Explicit(chosen)))
    return Select("scan-00001", chosen, basis, drag)


def moves(chosen: PointSet) -> MovePoints:
    to = np.arange(3.0 * len(chosen)).reshape(-1, 3)
    return MovePoints("scan-00001", chosen, Coordinates(to))


def sure_moves(chosen: PointSet) -> MovePoints:
    return replace(moves(chosen), confidence=Numbers(np.linspace(0.8, 1.0, len(chosen))))


simple = st.one_of(
    st.builds(SetDeleted, st.just("scan-00001"), points, st.booleans()),
    st.builds(MarkGhosts, st.just("scan-00001"), points, points, points),
    st.builds(Select, st.just("scan-00001"), points),
    points.map(moves),
    points.map(sure_moves),
    st.builds(lambda r: SetParameters("scan-00001", Parameters(radius=r)), st.floats(0.001, 0.4)),
    st.builds(
        lambda k: SetParameters("scan-00001", Parameters(curve=Curve("lambert", {"f": k}, "i"))),
        st.floats(0.1, 2),
    ),
    st.builds(lambda x: SetPose("scan-00001", Pose((x, 0.0, 0.0))), st.floats(-5, 5)),
    st.just(SetPose("scan-00001", None)),
    st.just(SetChannels("scan-00001", (Channel("new", "i", 1550.0, "dB"),))),
    st.builds(CloseScan, st.just("scan-00001"), st.booleans()),
    st.builds(lambda k, m: PutLeaf(k, make_leaf(k, m)), leaf_keys, points),
    st.builds(PutLeaf, leaf_keys, st.none()),
    st.just(PutSample("sample-00001", Sample("sample-00001", "birch", ("scan-00001",)))),
    points.map(lambda p: PutSeries("series-00001", make_series(p))),
    st.just(PutSeries("series-00001", None)),
)
# One after another they may merge, so there can be fewer steps than operations.
brushes = st.builds(brush, points, st.sampled_from(["brush-1", "brush-2"]))
operations = st.one_of(simple, st.lists(simple, max_size=3).map(lambda s: Several("x", tuple(s))))


def fresh() -> Project:
    project = Project()
    rng = np.random.default_rng(3)
    scan = Scan("demo", rng.random((SIZE, 3)), {"i": rng.random(SIZE)}, (Channel("i", "i"),))
    key = project.shelve(scan)
    project.do(AddScan(key, "demo", None))
    return project


def picture(state: State) -> object:
    """Everything of a state that a user could tell apart."""
    return (
        [
            (
                key,
                s.scan.xyz.tobytes(),
                s.scan.pose,
                s.scan.channels,
                s.deleted.tobytes(),
                s.marks.tobytes(),
                None if s.confidence is None else s.confidence.tobytes(),
                s.selection,
                s.parameters,
                s.closed,
            )
            for key, s in state.scans.items()
        ],
        list(state.leaves.items()),
        list(state.fits.items()),
        list(state.samples.items()),
        list(state.series.items()),
    )


@settings(max_examples=150, deadline=None)
@given(st.lists(operations, max_size=8))
def test_undo_of_everything_and_redo_of_everything(steps: list[AnyOperation]) -> None:
    project = fresh()
    pictures = [picture(project.state)]
    for step in steps:
        project.do(step)
        pictures.append(picture(project.state))
    for expected in reversed(pictures[:-1]):
        project.undo()
        assert picture(project.state) == expected
    for expected in pictures[1:]:
        project.redo()
        assert picture(project.state) == expected


@settings(max_examples=100, deadline=None)
@given(st.one_of(operations, brushes))
def test_codec_gives_back_what_it_got(step: AnyOperation) -> None:
    arrays: dict[str, np.ndarray] = {}
    assert decode(encode(step, arrays, "a"), arrays) == step


@settings(max_examples=60, deadline=None)
@given(st.lists(st.one_of(operations, brushes, st.sampled_from(["undo", "redo"])), max_size=12))
def test_a_log_restores_state_and_both_stacks(deeds: list[AnyOperation | str]) -> None:
    project = fresh()
    for deed in deeds:
        if deed == "undo":
            project.undo()
        elif deed == "redo":
            project.redo()
        elif "scan-00001" in project.state.scans:
            project.do(deed)
    again = Project()
    again.shelve(next(iter(project.state.library.values())), "scan-00001")
    again.restore(list(project.history.log))
    assert picture(again.state) == picture(project.state)
    assert again.history.done == project.history.done
    assert again.history.undone == project.history.undone


@settings(max_examples=40, deadline=None)
@given(st.lists(operations, min_size=1, max_size=6))
def test_inverses_on_disk_lead_back_as_well(steps: list[AnyOperation]) -> None:
    project = fresh()
    project.history._cap = 0
    before = picture(project.state)
    for step in steps:
        project.do(step)
    assert project.history.on_disk == len(steps)
    for _ in steps:
        project.undo()
    assert picture(project.state) == before


def test_naming_the_scanner_does_not_look_for_finite_points_again() -> None:
    scan = fresh().state.library["scan-00001"]
    valid = scan.valid
    assert scan.with_pose(Pose((1.0, 0.0, 0.0))).valid is valid
    assert scan.with_channels(()).valid is valid
    moved = scan.xyz.copy()
    moved[3] = np.nan
    assert not scan.with_xyz(moved).valid[3]


def test_the_confidence_of_moves_is_known_of_these_points_only() -> None:
    project = fresh()
    project.do(sure_moves(PointSet([3, 7])))
    project.do(moves(PointSet([7, 9])))
    confidence = project.state.scan("scan-00001").confidence
    assert np.flatnonzero(np.isfinite(confidence)).tolist() == [3]
    project.undo()
    np.testing.assert_allclose(
        project.state.scan("scan-00001").confidence[[3, 7, 9]], [0.8, 1.0, np.nan], atol=1e-6
    )
    project.undo()
    assert project.state.scan("scan-00001").confidence is None
    with pytest.raises(WrongUse, match="not of these points"):
        project.do(replace(moves(PointSet([3, 7])), confidence=Numbers([0.5])))


def test_numbers_that_are_none_are_refused() -> None:
    arrays: dict[str, np.ndarray] = {}
    text = encode(sure_moves(PointSet([3, 7])), arrays, "a")
    name = next(key for key, held in arrays.items() if held.dtype == np.float32)
    with pytest.raises(BadInput, match="list of floats"):
        decode(text, arrays | {name: np.array([1, 2])})
