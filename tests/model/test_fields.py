"""The lazy graph: what is computed, when, and for which points."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput, MissingChannel, MissingScanner, WrongUse
from app.model.leaf import Leaf
from app.model.operations import (
    AddScan,
    MarkGhosts,
    PutLeaf,
    SetChannels,
    SetDeleted,
    SetParameters,
    SetPose,
)
from app.model.parameters import Beam, Curve, Formula
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Pose, Scan

KEY = "scan-00001"


@pytest.fixture
def project(leaves: Scan) -> Project:
    project = Project()
    project.do(AddScan(project.shelve(leaves), "leaves", None))
    return project


def change(project: Project, **values: object) -> None:
    old = project.state.scan(KEY).parameters
    project.do(SetParameters(KEY, msgspec.structs.replace(old, **values)))


def test_nothing_is_computed_before_somebody_asks(project: Project) -> None:
    assert project.cache.computed(KEY) == {}


def test_a_field_is_computed_once_and_only_where_asked(project: Project) -> None:
    rows = np.arange(10, 60)
    first = project.field(KEY, "incidence", rows)
    assert project.cache.computed(KEY) == {"incidence": 50}
    again = project.field(KEY, "incidence", np.arange(30, 70))
    assert project.cache.computed(KEY) == {"incidence": 60}
    np.testing.assert_array_equal(again[:30], first[20:])


def test_some_first_then_all_equals_all_at_once(project: Project, leaves: Scan) -> None:
    project.field(KEY, "incidence", np.arange(0, len(leaves), 7))
    in_parts = project.field(KEY, "incidence")
    other = Project()
    other.do(AddScan(other.shelve(leaves), "leaves", None))
    np.testing.assert_array_equal(in_parts, other.field(KEY, "incidence"))
    assert project.cache.computed(KEY) == {"incidence": len(leaves)}


def test_a_parameter_spoils_only_what_depends_on_it(project: Project) -> None:
    names = ("range", "reflectance_1063", "ndi", "incidence", "ghost")
    for name in names:
        project.field(KEY, name)
    change(project, radius=0.006)
    stale = {
        n
        for n in ("range", "ndi", "incidence", "ghost_score", "ghost")
        if project.known_field(KEY, n) is None
    }
    assert stale == {"incidence"}
    change(project, beam=Beam(0.002, 0.0003))
    stale = {
        n for n in ("range", "ndi", "ghost_score", "ghost") if project.known_field(KEY, n) is None
    }
    assert stale == {"ghost_score", "ghost"}
    project.field(KEY, "ghost")
    change(project, ghost_threshold=0.9)
    stale = {
        n for n in ("range", "ndi", "ghost_score", "ghost") if project.known_field(KEY, n) is None
    }
    assert stale == {"ghost"}


def test_undo_of_a_parameter_makes_old_values_valid_again(project: Project) -> None:
    project.field(KEY, "incidence")
    change(project, radius=0.006)
    project.undo()
    assert project.known_field(KEY, "incidence") is not None


def test_moving_the_scanner_spoils_angles_but_no_index(project: Project) -> None:
    project.field(KEY, "incidence")
    project.field(KEY, "ndi")
    project.do(SetPose(KEY, Pose((0.0, 0.5, 1.0))))
    assert project.known_field(KEY, "incidence") is None
    assert project.known_field(KEY, "ndi") is not None


def test_index_is_that_of_its_channels(project: Project, leaves: Scan) -> None:
    a, b = (leaves.attributes[f"reflectance_{nm}"].astype(float) for nm in (1063, 1545))
    np.testing.assert_allclose(project.field(KEY, "ndi"), (a - b) / (a + b), rtol=1e-12)


def test_a_formula_is_a_field(project: Project, leaves: Scan) -> None:
    change(project, formulas=(Formula("ratio", "reflectance_1063 / reflectance_1545"),))
    a, b = (leaves.attributes[f"reflectance_{nm}"].astype(float) for nm in (1063, 1545))
    np.testing.assert_allclose(project.field(KEY, "ratio"), a / b, rtol=1e-12)


def test_marks_overrule_the_score(project: Project) -> None:
    ghost = project.field(KEY, "ghost")
    one, other = int(np.flatnonzero(ghost == 1)[0]), int(np.flatnonzero(ghost == 0)[0])
    project.do(MarkGhosts(KEY, ghosts=PointSet([other]), kept=PointSet([one])))
    assert project.field(KEY, "ghost")[[one, other]].tolist() == [0.0, 1.0]


def test_delta_omega_is_the_angle_from_intensity_less_the_plane(project: Project) -> None:
    scan = project.state.scan(KEY).scan
    members = PointSet.from_mask(
        (scan.attributes["truth_leaf"] == 2) & (scan.attributes["truth_ghost"] == 0)
    )
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "two", members)))
    change(project, curve=Curve("lambert", {"f": 0.5}, "reflectance_1063"))
    delta = project.field(KEY, "delta_omega")
    outside = np.setdiff1d(np.arange(len(scan)), members.indices)
    assert np.isnan(delta[outside]).all()
    ratio = scan.attributes["reflectance_1063"][members.indices].astype(float) / 0.5
    angle = np.degrees(np.arccos(np.where(ratio <= 1, ratio, np.nan)))
    finite = np.isfinite(angle)
    shift = (delta[members.indices] - angle)[finite]
    assert finite.sum() > 20
    np.testing.assert_allclose(shift, shift[0], atol=1e-6)
    assert 0 < -shift[0] < 90
    assert project.cache.computed(KEY)["incidence_from_intensity"] == len(members)


def test_deleting_points_of_a_leaf_changes_its_plane(project: Project) -> None:
    scan = project.state.scan(KEY).scan
    members = PointSet.from_mask(scan.attributes["truth_leaf"] == 2)
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "two", members)))
    change(project, curve=Curve("lambert", {"f": 0.5}, "reflectance_1063"))
    project.field(KEY, "delta_omega")
    project.do(SetDeleted(KEY, PointSet(members.indices[::2])))
    assert project.known_field(KEY, "delta_omega") is None
    assert project.known_field(KEY, "incidence_from_intensity") is not None


@pytest.mark.parametrize("field", ["range", "incidence", "ghost", "ghost_score"])
def test_without_a_scanner_the_sentence_says_what_is_missing(project: Project, field: str) -> None:
    project.do(SetPose(KEY, None))
    with pytest.raises(MissingScanner, match=r"position is unknown.*--origin"):
        project.field(KEY, field)


def test_without_intensity_the_sentence_says_so() -> None:
    project = Project()
    project.do(AddScan(project.shelve(Scan("bare", np.eye(3))), "bare", None))
    for field in ("ndi", "incidence_from_intensity"):
        with pytest.raises(MissingChannel):
            project.field(KEY, field)


def test_without_a_curve_the_sentence_says_how_to_get_one(project: Project) -> None:
    with pytest.raises(BadInput, match="No angular curve is in use"):
        project.field(KEY, "incidence_from_intensity")


def test_an_unknown_field_names_those_there_are(project: Project) -> None:
    with pytest.raises(WrongUse, match=r"no field beauty.*incidence.*truth_leaf"):
        project.field(KEY, "beauty")


def test_rows_that_are_not_finite_stay_and_have_no_value(leaves: Scan) -> None:
    xyz = leaves.xyz.copy()
    xyz[3], xyz[500] = np.nan, np.inf
    project = Project()
    project.do(AddScan(project.shelve(replace(leaves, xyz=xyz)), "holes", None))
    assert project.state.scan(KEY).shown == len(leaves) - 2
    assert np.isnan(project.field(KEY, "incidence")[[3, 500]]).all()


def test_ten_leaves_of_two_million_points_touch_less_than_two_percent() -> None:
    from app.services.leaves import measure_leaves
    from app.simulate.scenes import large_scan

    scan = large_scan(2_000_000, seed=1)
    project = Project()
    project.do(AddScan(project.shelve(scan), "large", None))
    labels = scan.attributes["truth_leaf"]
    names, counts = np.unique(labels[labels >= 0], return_counts=True)
    ten = names[np.argsort(counts)][:10]
    keys = []
    for number, name in enumerate(ten, 1):
        key = f"leaf-{number:05d}"
        keys.append(key)
        members = PointSet(np.flatnonzero(labels == name)[:3000])
        project.do(PutLeaf(key, Leaf(key, KEY, key, members)))
    rows = measure_leaves(project, KEY, keys)
    assert all(isinstance(row["incidence_plane_deg"], float) for row in rows)
    touched = max(project.cache.computed(KEY).values())
    assert 0 < touched < 0.02 * len(scan)


def test_naming_the_kind_of_a_channel_spoils_what_reads_it(project: Project) -> None:
    before = project.field(KEY, "ghost_score")
    scan = project.state.scan(KEY).scan
    project.do(SetChannels(KEY, tuple(replace(c, kind="dB") for c in scan.channels)))
    # Decibels say nothing about how much of the power is lost.
    assert np.nanmax(np.abs(project.field(KEY, "ghost_score") - before)) > 0.01


def test_another_attribute_under_the_same_name_is_another_channel(project: Project) -> None:
    first, second = project.state.scan(KEY).scan.channels
    project.field(KEY, first.name)
    project.do(SetChannels(KEY, (replace(first, attribute=second.attribute), second)))
    np.testing.assert_array_equal(project.field(KEY, first.name), project.field(KEY, second.name))


def test_a_few_values_that_arrive_late_do_not_replace_all(project: Project) -> None:
    everything, few = project.evaluation(KEY), project.evaluation(KEY)
    everything.read("incidence")
    few.read("incidence", np.arange(10))
    project.accept(KEY, everything.results)
    project.accept(KEY, few.results)
    known = project.known_field(KEY, "incidence")
    assert known is not None
    assert known.covers(None)


def test_parts_that_were_computed_side_by_side_are_joined(project: Project) -> None:
    parts = [np.arange(0, 40), np.arange(30, 60)]
    evaluations = [project.evaluation(KEY) for _ in parts]
    for evaluation, part in zip(evaluations, parts, strict=True):
        evaluation.read("incidence", part)
        project.accept(KEY, evaluation.results)
    known = project.known_field(KEY, "incidence")
    assert known is not None
    assert np.flatnonzero(known.have).tolist() == list(range(60))
    expected = project.field(KEY, "incidence")[:60]
    np.testing.assert_array_equal(known.values[:60], expected)


def test_a_result_from_older_parameters_is_dropped(project: Project) -> None:
    late = project.evaluation(KEY)
    late.read("incidence")
    change(project, radius=0.006)
    valid = project.field(KEY, "incidence")
    project.accept(KEY, late.results)
    known = project.known_field(KEY, "incidence")
    assert known is not None
    assert known.values is valid
    assert project.cache.computed(KEY)["incidence"] == 2 * len(valid)


def test_a_result_for_a_scan_that_is_gone_is_dropped(project: Project) -> None:
    late = project.evaluation(KEY)
    late.read("range")
    project.undo()
    project.accept(KEY, late.results)
    assert "range" not in project.cache.known(KEY)


def test_a_formula_whose_channel_went_says_so_and_breaks_nothing_else(project: Project) -> None:
    change(project, formulas=(Formula("ratio", "reflectance_1063 * 2"),))
    project.do(SetChannels(KEY, project.state.scan(KEY).scan.channels[1:]))
    assert "ratio" in project.catalogue(KEY)
    with pytest.raises(MissingChannel, match="reflectance_1063"):
        project.field(KEY, "ratio")


def test_a_formula_never_takes_the_place_of_a_field(project: Project, leaves: Scan) -> None:
    change(project, formulas=(Formula("reflectance_1063", "reflectance_1063 * 2"),))
    values = project.field(KEY, "reflectance_1063")
    np.testing.assert_array_equal(values, leaves.attributes["reflectance_1063"])


def test_the_same_points_under_another_key_are_another_leaf(project: Project) -> None:
    members = PointSet([1, 2, 3])
    project.do(PutLeaf("leaf-00002", Leaf("leaf-00002", KEY, "two", members)))
    assert project.field(KEY, "leaf")[1] == 2
    project.do(PutLeaf("leaf-00002", None))
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "one", members)))
    assert project.field(KEY, "leaf")[1] == 1
