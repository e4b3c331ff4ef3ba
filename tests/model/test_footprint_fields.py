"""The footprint as a field: the check values of the paper, measured on points."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput
from app.model.leaf import Leaf
from app.model.operations import AddScan, PutLeaf, SetParameters
from app.model.parameters import Beam
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Grid, Pose, Scan

KEY = "scan-00001"
LS880 = Beam(0.0015, float(np.deg2rad(0.014)), "instrument ls880")
SIDE, STEP, RANGE = 121, 0.00012, 2.16
MIDDLE = SIDE * SIDE // 2


def see_plane(degrees: float) -> Scan:
    """A plane that the middle beam meets at 2.16 m and at an angle, on a grid of beams."""
    row, column = (a.ravel() for a in np.mgrid[:SIDE, :SIDE])
    rise, turn = (SIDE // 2 - row) * STEP, (SIDE // 2 - column) * STEP
    flat = np.cos(rise)
    beams = np.stack([flat * np.cos(turn), flat * np.sin(turn), np.sin(rise)], axis=1)
    tilt = np.deg2rad(degrees)
    normal = np.array([-np.cos(tilt), np.sin(tilt), 0.0])
    xyz = beams * (-RANGE * np.cos(tilt) / (beams @ normal))[:, None]
    grid = Grid(SIDE, SIDE, row.astype(np.int32), column.astype(np.int32))
    return Scan("plane", xyz, pose=Pose((0.0, 0.0, 0.0)), grid=grid)


def put(scan: Scan, beam: Beam | None = LS880) -> Project:
    project = Project()
    project.do(AddScan(project.shelve(scan), "plane", None))
    old = project.state.scan(KEY).parameters
    project.do(SetParameters(KEY, msgspec.structs.replace(old, beam=beam)))
    return project


@pytest.mark.parametrize(("degrees", "mm"), [(0.0, 4.056), (65.0, 9.596), (79.33, 21.9)])
def test_ls880_at_2_16_m(degrees: float, mm: float) -> None:
    project = put(see_plane(degrees))
    found = project.field(KEY, "footprint", np.array([MIDDLE]))
    assert float(found[0]) == pytest.approx(mm, rel=2e-3)
    assert project.cache.computed(KEY) == {"footprint": 1, "range": 1, "incidence": 1}


def test_a_fifth_of_a_leaf_of_21_9_mm_at_20_degrees() -> None:
    scan = see_plane(20.0)
    near = np.linalg.norm(scan.xyz - scan.xyz[MIDDLE], axis=1) < 0.0219 / 2
    project = put(scan)
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "disc", PointSet.from_mask(near))))
    share = project.field(KEY, "footprint_share")
    assert float(share[MIDDLE]) == pytest.approx(0.197, abs=0.004)
    assert np.array_equal(np.isfinite(share), near)
    assert project.cache.computed(KEY)["footprint"] == near.sum()


def test_where_the_outer_ray_misses_the_surface_there_is_no_footprint() -> None:
    wide = Beam(0.001, float(np.deg2rad(30.0)), "typed in")
    assert np.isnan(put(see_plane(70.0), wide).field(KEY, "footprint", np.array([MIDDLE]))).all()
    assert np.isfinite(put(see_plane(50.0), wide).field(KEY, "footprint", np.array([MIDDLE]))).all()


@pytest.mark.parametrize("name", ["footprint", "footprint_share"])
def test_without_a_beam_the_sentence_says_how_to_give_one(name: str) -> None:
    with pytest.raises(BadInput, match=r"beam .* is unknown.*--instrument.*--half-divergence"):
        put(see_plane(0.0), None).field(KEY, name)


def test_a_leaf_that_is_a_line_has_no_share() -> None:
    project = put(see_plane(20.0))
    line = PointSet(np.arange(MIDDLE - 20, MIDDLE + 20))
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "line", line)))
    assert np.isnan(project.field(KEY, "footprint_share")).all()


def test_another_beam_spoils_footprints_but_no_angle() -> None:
    project = put(see_plane(20.0))
    project.field(KEY, "footprint")
    old = project.state.scan(KEY).parameters
    project.do(SetParameters(KEY, msgspec.structs.replace(old, beam=Beam(0.001, 0.001))))
    assert project.known_field(KEY, "footprint") is None
    assert project.known_field(KEY, "incidence") is not None
