"""Steps and axes learnt from points, on scanners as they are and as they should not be."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.arrays import read_only
from app.core.neighbours.beams import SAMPLES, Beams, sample_points
from app.core.neighbours.range_image import build_image
from app.core.neighbours.steps import Cells, UnusableGrid

ORIGIN = np.zeros(3)


def look(elevation, azimuth, noise=0.0, kept=1.0, axes=None, seed=0):
    """A scan of a rough sphere; elevation and azimuth are (rows, columns)."""
    rng = np.random.default_rng(seed)
    rows, columns = elevation.shape
    keep = np.flatnonzero(rng.random(elevation.size) < kept)
    row, column = (a.ravel()[keep].astype(np.int32) for a in np.mgrid[:rows, :columns])
    e, a = elevation.ravel()[keep], azimuth.ravel()[keep]
    beams = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
    beams = beams if axes is None else beams @ axes
    xyz = beams * (3.0 + noise * rng.normal(size=len(keep)))[:, None]
    return read_only(np.ascontiguousarray(xyz)), Cells(rows, columns, row, column)


def learn(xyz, cells) -> Beams:
    tiles = np.ones((-(-cells.rows // 128), -(-cells.columns // 128)), bool)
    return build_image(xyz, ORIGIN, cells, tiles).beams


def lines(count, step, begin=0.0):
    return begin + step * (np.arange(count) - count // 2)


def test_steps_of_an_upright_scanner_with_holes():
    elevation, azimuth = np.meshgrid(
        lines(200, 1.2e-3, 0.1), lines(300, -4.4e-3, 2.0), indexing="ij"
    )
    beams = learn(*look(elevation, azimuth, noise=1e-3, kept=0.4))
    assert np.allclose(beams.down, 1.2e-3, rtol=1e-9)
    assert np.allclose(beams.turn, -4.4e-3, rtol=1e-9)
    assert np.allclose(beams.level, np.cos(elevation[:, 0]), atol=1e-9)
    assert np.allclose(beams.axes[2], [0.0, 0.0, 1.0])
    assert not beams.seam


def test_columns_that_lean_as_those_of_a_real_scanner():
    rows, columns = 300, 200
    elevation, azimuth = np.meshgrid(lines(rows, 1e-3), lines(columns, 4e-3), indexing="ij")
    skew = 3e-6 * np.arange(rows)[:, None] + 2e-9 * np.arange(rows)[:, None] ** 2
    beams = learn(*look(elevation, azimuth + skew, kept=0.6))
    assert np.allclose(beams.turn, 4e-3, rtol=0.02)
    assert np.allclose(beams.down, 1e-3, rtol=0.01)


def test_the_axis_of_a_leaning_scanner_is_found():
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    elevation, azimuth = np.meshgrid(lines(150, 2e-3), lines(200, 4e-3), indexing="ij")
    beams = learn(*look(elevation, azimuth, axes=turn))
    assert abs(beams.axes[2] @ turn[2]) == pytest.approx(1.0, abs=1e-9)
    assert np.allclose(np.abs(beams.down), 2e-3, rtol=1e-6)
    assert np.allclose(np.abs(beams.turn), 4e-3, rtol=1e-6)


@pytest.mark.parametrize(("columns", "seam"), [(720, True), (719, True), (700, False)])
def test_the_seam_is_where_the_circle_closes(columns, seam):
    step = 2 * np.pi / 720
    elevation, azimuth = np.meshgrid(lines(60, 4e-3), step * np.arange(columns), indexing="ij")
    beams = learn(*look(elevation, azimuth))
    assert beams.seam is (seam and columns == 720)


def test_lines_near_a_change_of_step_are_marked():
    rows = np.cumsum(np.where(np.arange(120) < 60, 1e-3, 2e-3))
    elevation, azimuth = np.meshgrid(rows, lines(100, 3e-3), indexing="ij")
    beams = learn(*look(elevation, azimuth, noise=1e-3, kept=0.7))
    assert beams.uneven_row[45:75].all()
    assert not beams.uneven_row[:30].any()
    assert not beams.uneven_row[90:].any()
    assert not beams.uneven_column.any()


def test_cells_that_say_nothing_of_the_beams_are_refused():
    rng = np.random.default_rng(0)
    elevation, azimuth = np.meshgrid(lines(100, 1e-3), lines(100, 1e-3), indexing="ij")
    xyz, cells = look(elevation, azimuth)
    rough, _ = look(elevation, azimuth, noise=0.3)
    shuffled = Cells(100, 100, cells.row, cells.column[rng.permutation(len(cells.column))])
    with pytest.raises(UnusableGrid, match="do not follow the beams"):
        learn(xyz, shuffled)
    with pytest.raises(UnusableGrid, match="do not follow the beams"):
        learn(read_only(rough + np.array([0.0, 0.5, 0.0])), cells)  # not where the scanner was
    one = Cells(100, 100, np.zeros(len(xyz), np.int32), cells.column)
    with pytest.raises(UnusableGrid, match="no neighbouring cells"):
        learn(xyz, one)
    with pytest.raises(UnusableGrid, match="no point has a range"):
        learn(read_only(np.full_like(xyz, np.nan)), cells)


def test_sampled_points_are_spread_and_within_the_scan():
    for total in (2, SAMPLES, SAMPLES + 1, 3_000_000):
        sample = sample_points(total)
        assert len(np.unique(sample)) == len(sample) >= min(total, SAMPLES)
        assert sample.min() >= 0
        assert sample.max() < total
        assert np.diff(sample).max() <= 2 * max(total // SAMPLES, 1) + 1
