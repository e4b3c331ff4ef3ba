"""Recovered rows and columns against those that the points were made with."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import Cancelled
from app.core.kernels.recovered import look
from app.core.neighbours.recovered import recover, recover_grid
from app.core.neighbours.steps import UnusableGrid, measure_steps
from app.core.progress import LiveProgress

ORIGIN = np.zeros(3)


def make_scan(
    rows=240, columns=320, step=(0.05, 0.08), top=10.0, left=0.0, tilt=0.0, drift=0.0, skew=0.0,
    jitter=0.0, keep=1.0, seed=0,
):  # fmt: skip
    """Points of a scan in random order, with their rows and columns; angles in degrees."""
    rng = np.random.default_rng(seed)
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    order = rng.permutation(len(row))[: round(keep * len(row))]
    row, column = row[order], column[order]
    down = row + drift * column / columns + jitter * rng.uniform(-1, 1, rows)[row]
    right = column + skew * row / rows + jitter * rng.uniform(-1, 1, columns)[column]
    rise, turn = np.deg2rad(top - step[0] * down), np.deg2rad(left - step[1] * right)
    beams = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], 1)
    lean = np.deg2rad(tilt)
    turned = np.array(
        [[np.cos(lean), 0, np.sin(lean)], [0, 1, 0], [-np.sin(lean), 0, np.cos(lean)]]
    )
    # Surfaces of 16 columns each, some of them behind others.
    depth = 3.0 + rng.uniform(-1, 1, columns // 16 + 1)[column // 16] + 0.2 * np.sin(9 * turn)
    depth += rng.normal(0, 0.0007, len(depth))
    return (beams * depth[:, None]) @ turned.T, row, column


def assert_same(cells, row, column):
    assert cells.row.dtype == cells.column.dtype == np.int32
    assert np.ptp(cells.row - row) == 0
    assert np.ptp(cells.column - column) == 0
    assert (cells.row.min(), cells.column.min()) == (0, 0)
    assert cells.rows == cells.row.max() + 1
    assert cells.columns == cells.column.max() + 1


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"keep": 0.5},
        {"step": (0.067, 0.251), "rows": 400, "columns": 120},
        {"step": (0.2, 0.05)},
        {"step": (0.002, 0.002)},
        {"tilt": 3.0},
        {"tilt": 0.05, "step": (0.018, 0.018)},
        {"drift": 2.0, "skew": -1.0},
        {"jitter": 0.2},
        {"left": 189.0},
        {"rows": 40, "columns": 40},
        {"top": 60.0, "step": (0.3, 0.3)},
    ],
)
def test_finds_the_rows_and_columns(changes):
    xyz, row, column = make_scan(**changes)
    found = recover(xyz, ORIGIN)
    assert_same(found.cells, row, column)
    step = np.deg2rad(changes.get("step", (0.05, 0.08)))
    assert found.step == pytest.approx(step, rel=0.005)


@settings(max_examples=15, deadline=None)
@given(
    st.floats(0.01, 0.3), st.floats(0.3, 3.0), st.floats(-180, 180), st.floats(-4, 4),
    st.floats(0.6, 1.0), st.integers(0, 10**6),
)  # fmt: skip
def test_any_steps(down, ratio, left, tilt, keep, seed):
    xyz, row, column = make_scan(
        200, 200, (down, down * ratio), 10.0, left, tilt=tilt, keep=keep, seed=seed
    )
    try:
        found = recover_grid(xyz, ORIGIN)
    except UnusableGrid:
        return  # a few leaning scans are refused, which costs time and no angle
    assert_same(found, row, column)


@pytest.mark.parametrize("seed", range(6))
def test_usual_steps_are_recovered_whatever_is_missing(seed):
    rng = np.random.default_rng(seed)
    down, ratio = rng.uniform(0.02, 0.2), rng.uniform(0.5, 2.0)
    xyz, row, column = make_scan(
        200, 200, (down, down * ratio), 10.0, rng.uniform(-180, 180), keep=0.7, seed=seed
    )
    assert_same(recover_grid(xyz, ORIGIN), row, column)


def test_goes_all_round_and_up_to_the_pole():
    xyz, row, column = make_scan(300, 720, (0.4, 0.5), top=89.8)
    cells = recover_grid(xyz, ORIGIN)
    assert (cells.rows, cells.columns) == (300, 720)
    assert np.ptp(cells.row - row) == 0
    assert len(np.unique((cells.column - column) % 720)) == 1
    assert measure_steps(xyz, ORIGIN, cells).seam


@pytest.mark.parametrize("rounding", [1e-4, 2.5e-4])
def test_rounded_coordinates(rounding):
    xyz, row, column = make_scan(step=(0.03, 0.04))
    assert_same(recover_grid(np.round(xyz / rounding) * rounding, ORIGIN), row, column)


def test_far_from_the_world_origin():
    xyz, row, column = make_scan()
    scanner = np.array([4e5, 5.4e6, 300.0])
    assert_same(recover_grid(xyz + scanner, scanner), row, column)


def test_several_returns_duplicates_and_lost_points():
    xyz, row, column = make_scan()
    behind, again = np.flatnonzero(row % 3 == 0), np.flatnonzero(column % 5 == 0)
    lost = np.array([[np.nan, 0, 0], [np.inf, 0, 1], [0, 0, 0]])
    cloud = np.concatenate([lost, xyz, 1.3 * xyz[behind], xyz[again]])
    cells = recover_grid(cloud, ORIGIN)
    assert (cells.row[:3] == 0).all()
    true_row, true_column = (np.concatenate([k, k[behind], k[again]]) for k in (row, column))
    assert np.ptp(cells.row[3:] - true_row) == 0
    assert np.ptp(cells.column[3:] - true_column) == 0


def test_missing_rows_and_holes():
    xyz, row, column = make_scan()
    hole = (row > 60) & (row < 130) & (column > 90) & (column < 200)
    kept = ~hole & (row % 37 != 5) & ~((row > 160) & (row < 175))
    assert_same(recover_grid(xyz[kept], ORIGIN), row[kept], column[kept])


def _rng():
    return np.random.default_rng(7)


def _blur(xyz):
    return xyz + _rng().normal(0, 0.002, xyz.shape) * np.linalg.norm(xyz, axis=1)[:, None]


def _merge(xyz, share):
    other = make_scan(seed=3)[0] + [0.31, 0.17, 0.05]
    return np.concatenate([xyz, other[: round(share * len(other))]])


def _repeat(xyz):
    noise = 1 + _rng().normal(0, 0.0007, len(xyz)) / np.linalg.norm(xyz, axis=1)
    return np.concatenate([xyz, xyz * noise[:, None]])


def _average(xyz):
    return (np.unique(np.floor(xyz / 0.02), axis=0) + 0.5) * 0.02


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (lambda xyz: _rng().normal(size=xyz.shape), "rows and columns"),
        (lambda xyz: _rng().uniform(-1, 1, xyz.shape) * [1, 1, 0] + [3, 0, 1], "lie on|line up"),
        (_blur, "rows and columns"),
        (lambda xyz: _merge(xyz, 1.0), "rows and columns|merged|differ"),
        (lambda xyz: _merge(xyz, 0.1), "merged|rows and columns"),
        (_repeat, "one surface several times"),
        (_average, "lie on|line up|differ|thinned"),
        (lambda xyz: np.add(xyz, [0.02, 0.01, 0.0]), "rows and columns|merged|bend|differ"),
        (lambda xyz: np.add(xyz, [0.4, 0.3, 0.1]), "rows and columns|merged|bend|differ"),
        (lambda xyz: np.round(xyz, 2), "rows"),
        (lambda xyz: xyz[::12], "thinned|lie on|differ"),
        (lambda xyz: xyz[:300], "too few"),
        (lambda xyz: xyz[:0], "too few"),
        (lambda xyz: xyz * np.nan, "too few"),
        (lambda xyz: np.ones_like(xyz), "lie on|too few"),
    ],
)
def test_refuses_with_a_reason(spoil, why):
    xyz = np.ascontiguousarray(spoil(make_scan()[0]))
    with pytest.raises(UnusableGrid, match=why):
        recover_grid(xyz, ORIGIN)


def test_same_result_in_file_order():
    xyz, row, column = make_scan()
    order = np.lexsort((row, column))
    assert_same(recover_grid(xyz[order], ORIGIN), row[order], column[order])


def test_cancels():
    with pytest.raises(Cancelled):
        recover_grid(make_scan()[0], ORIGIN, LiveProgress(lambda *_: None, lambda: True))


def test_directions_are_exact_enough():
    beams = np.random.default_rng(0).normal(size=(5000, 3))
    beams[:3] = np.eye(3)
    seen = np.empty((4, len(beams)))
    lattice = np.array([np.pi, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    look(beams, ORIGIN, np.eye(3), lattice, seen)
    rise = np.arctan2(beams[:, 2], np.hypot(beams[:, 0], beams[:, 1]))
    turn = np.pi - np.arctan2(beams[:, 1], beams[:, 0])
    assert np.abs(seen[0] - rise).max() < 4e-8
    assert np.abs(np.angle(np.exp(1j * (seen[1] - turn)))).max() < 4e-8


@pytest.mark.data
def test_pump_as_its_file_says(shared_data):
    pye57 = pytest.importorskip("pye57")
    file = pye57.E57(str(shared_data / "pump_e57_gridded" / "pumpAVisualReferenceImage.e57"))
    scan = file.read_scan_raw(0)
    xyz = np.stack([scan[f"cartesian{axis}"] for axis in "XYZ"], axis=1)
    order = np.random.default_rng(1).permutation(len(xyz))
    cells = recover_grid(xyz[order], ORIGIN)
    row, column = (scan[key][order].astype(int) for key in ("rowIndex", "columnIndex"))
    assert min(np.ptp(cells.row - row), np.ptp(cells.row + row)) == 0
    assert min(np.ptp(cells.column - column), np.ptp(cells.column + column)) == 0
