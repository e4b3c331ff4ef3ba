"""Which footprints are drawn, and on which planes."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from app.core.errors import BadInput, MissingScanner, WrongUse
from app.core.footprint import footprint_axis
from app.model.operations import AddScan, Select
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Grid, Pose, Scan
from app.model.state import ScanState
from app.services.beams import typed_beam
from app.services.footprint_rings import MOST, choose_rows, make_rings, thin
from app.services.opening import set_parameters

SIDE = 120
BEAM = typed_beam(3.0, 0.014)


def wall(pose: bool = True, grid: bool = True) -> Scan:
    """A wall at 4 m that the beams meet at up to 60 degrees."""
    azimuth, elevation = np.meshgrid(np.linspace(0.9, 1.05, SIDE), np.linspace(0.1, -0.1, SIDE))
    beam = np.stack(
        (np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
         np.sin(elevation)), axis=-1,
    ).reshape(-1, 3)  # fmt: skip
    row, column = (place.ravel().astype(np.int32) for place in np.indices((SIDE, SIDE)))
    return Scan(
        "wall", beam * (2.0 / beam[:, :1]), {}, (),
        Pose((0.0, 0.0, 0.0)) if pose else None,
        Grid(SIDE, SIDE, row, column) if grid else None,
    )  # fmt: skip


def open_wall(**how: bool) -> tuple[Project, str]:
    project = Project()
    key = project.shelve(wall(**how))
    project.do(AddScan(key, "wall", None))
    return project, key


def test_rings_lie_on_the_wall_at_true_scale() -> None:
    project, key = open_wall()
    set_parameters(project, key, beam=BEAM, radius=0.03)
    state = project.state.scan(key)
    rows = np.arange(SIDE * 30 + 20, SIDE * 31 - 20, 7)
    rings = make_rings(state, rows)
    assert rings.shape == (len(rows), 36, 3)
    assert rings[:, :, 0] == pytest.approx(2.0, abs=1e-6)
    away = np.linalg.norm(state.scan.xyz[rows], axis=1)
    axis = footprint_axis(away, np.arccos(2.0 / away), BEAM.radius, BEAM.half_divergence)
    widest = np.linalg.norm(rings[:, :18] - rings[:, 18:], axis=2).max(axis=1)
    assert widest == pytest.approx(axis, rel=0.01)


def test_a_selection_is_drawn_as_it_is_and_a_leaf_is_thinned() -> None:
    project, key = open_wall()
    assert len(choose_rows(project, key, None)[0]) == 0
    assert len(choose_rows(project, key, "leaf-7")[0]) == 0
    some = PointSet(np.arange(100, 140))
    project.do(Select(key, some, None))
    rows, every = choose_rows(project, key, None, 9)
    assert rows.tolist() == list(range(100, 140))
    assert every == 1


@pytest.mark.parametrize("grid", [True, False])
def test_thinning_is_even_and_never_too_much(grid: bool) -> None:
    state = ScanState.fresh(wall(grid=grid))
    every_point = np.arange(SIDE * SIDE)
    rows, every = thin(state, every_point, 10)
    assert every == 10
    assert len(rows) == (SIDE // 10) ** 2
    if grid:
        assert (rows % SIDE % 10 == 0).all()
    rows, every = thin(state, every_point, 1)
    assert 0 < len(rows) <= MOST
    assert every > 1
    with pytest.raises(WrongUse, match="0th row"):
        thin(state, every_point, 0)


def test_deleted_points_have_no_footprint() -> None:
    state = ScanState.fresh(wall())
    state.deleted[: SIDE * 60] = True
    rows, _ = thin(state, np.arange(SIDE * SIDE), 6)
    assert rows.min() >= SIDE * 60


def test_without_beam_or_position_it_is_refused() -> None:
    state = ScanState.fresh(wall())
    with pytest.raises(BadInput, match="beam of the scanner is unknown"):
        make_rings(state, np.arange(5))
    lost = ScanState.fresh(wall(pose=False))
    with pytest.raises(MissingScanner):
        make_rings(lost, np.arange(5))
    known = ScanState(
        state.scan, state.deleted, state.marks, parameters=replace(state.parameters, beam=BEAM)
    )
    assert len(make_rings(known, np.empty(0, np.int64))) == 0
