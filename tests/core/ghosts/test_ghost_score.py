"""Ghost scores on a scene whose truth is known by construction, and on another simulator's."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.errors import Cancelled, WrongUse
from app.core.footprint import BeamShape
from app.core.ghosts import THRESHOLD, lay_out, score_ghosts
from app.core.progress import Progress

ORIGIN = np.zeros(3)


def f1(score, truth):
    called = score > THRESHOLD
    return 2 * (called & truth).sum() / (called.sum() + truth.sum())


@pytest.mark.parametrize(
    ("on_grid", "least", "method"), [(True, 0.93, "scan grid"), (False, 0.7, "density")]
)
def test_border_points_are_found(make_scene, on_grid, least, method):
    scene = make_scene()
    found = score_ghosts(scene.xyz, ORIGIN, None, scene.grid if on_grid else None)
    assert found.method == method
    assert f1(found.score, scene.ghost) > least
    assert ((found.score >= 0) & (found.score <= 1)).all()
    if on_grid:
        assert (found.score[scene.share == 1.0] < THRESHOLD).mean() > 0.995
        assert found.looked < len(scene.xyz) / 2


def test_steep_leaf_has_no_ghosts_inside(make_scene):
    scene = make_scene(tilt=np.deg2rad(72))
    score = score_ghosts(scene.xyz, ORIGIN, None, scene.grid).score
    assert (score[scene.from_centre < 34] < THRESHOLD).all()


@pytest.mark.parametrize("on_grid", [True, False])
def test_subset_equals_full_and_missing_is_nan(make_scene, on_grid):
    scene = make_scene()
    scene.xyz[3], scene.xyz[4] = np.nan, 0.0
    chosen = scene.grid if on_grid else None
    light = np.where(scene.ghost, -1.0, 0.0) + np.random.default_rng(0).normal(
        0, 0.05, len(scene.xyz)
    )
    full = score_ghosts(scene.xyz, ORIGIN, None, chosen, light=light).score
    border = np.flatnonzero(scene.ghost)[::9]
    asked = np.concatenate([[9800, 3, 4, 5000, 9800], border])
    part = score_ghosts(scene.xyz, ORIGIN, asked, chosen, light=light).score
    assert np.allclose(part, full[asked], equal_nan=True, atol=1e-5)
    assert np.isnan(part[:5]).tolist() == [False, True, True, False, False]


@pytest.mark.parametrize("way", ["flipped", "mirrored", "turned"])
def test_turning_the_image_changes_nothing(make_scene, way):
    scene = make_scene()
    plain = score_ghosts(scene.xyz, ORIGIN, None, scene.grid).score
    grid = scene.grid
    row, column = grid.row, grid.column
    if way == "flipped":
        row = grid.rows - 1 - row
    elif way == "mirrored":
        column = grid.columns - 1 - column
    else:
        row, column = column, row
    other = SimpleNamespace(rows=grid.rows, columns=grid.columns, row=row, column=column)
    score = score_ghosts(scene.xyz, ORIGIN, None, other).score
    assert np.mean((score > THRESHOLD) != (plain > THRESHOLD)) < 0.001


def test_columns_go_on_around_a_full_turn():
    """A wall all around with a bump across the seam scores as the same bump elsewhere."""
    rows, columns = 24, 360
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    rise, turn = (row - 12) * np.deg2rad(1.0), column * np.deg2rad(1.0)
    beams = np.stack(
        [np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=1
    )
    noise = np.random.default_rng(2).normal(0, 3e-4, (rows, columns))

    def scan(place):
        near = np.abs((column - place + columns // 2) % columns - columns // 2)
        away = np.where(near <= 4, 1.0, np.where(near == 5, 1.2, 1.4)) / np.cos(rise)
        shaken = away + np.roll(noise, place, axis=1).ravel()
        grid = SimpleNamespace(rows=rows, columns=columns, row=row, column=column)
        return score_ghosts(beams * shaken[:, None], ORIGIN, None, grid).score

    across, inside = scan(0).reshape(rows, columns), scan(100).reshape(rows, columns)
    moved = np.roll(across, 100, axis=1)
    assert ((moved > THRESHOLD) == (inside > THRESHOLD)).mean() > 0.995
    assert (inside > THRESHOLD).any()


def test_several_returns_of_a_beam_do_not_hide_one_another(make_scene):
    """Each beam at the border also tells leaf and wall: the ghosts stay ghosts, those do not."""
    scene = make_scene()
    border = np.flatnonzero(scene.ghost)
    beams = scene.xyz[border] / np.linalg.norm(scene.xyz[border], axis=1)[:, None]
    extra = beams * scene.wall[border, None]
    xyz = np.concatenate([scene.xyz, extra])
    grid = SimpleNamespace(
        rows=scene.grid.rows,
        columns=scene.grid.columns,
        row=np.concatenate([scene.grid.row, scene.grid.row[border]]),
        column=np.concatenate([scene.grid.column, scene.grid.column[border]]),
    )
    image = lay_out(xyz, ORIGIN, grid)
    assert image.ranges.shape[0] == 2
    assert image.layer[len(scene.xyz) :].min() == 1
    score = score_ghosts(xyz, ORIGIN, None, grid).score
    assert (score[len(scene.xyz) :] > THRESHOLD).mean() < 0.1
    assert (score[border] > THRESHOLD).mean() > 0.8
    mixed = np.random.default_rng(4).permutation(len(xyz))
    shuffled = SimpleNamespace(
        rows=grid.rows, columns=grid.columns, row=grid.row[mixed], column=grid.column[mixed]
    )
    again = score_ghosts(xyz[mixed], ORIGIN, None, shuffled).score
    # Steps and noise are measured on some of the points: on others in another order.
    assert ((again > THRESHOLD) == (score[mixed] > THRESHOLD)).mean() > 0.999


def test_lonely_point_is_a_ghost():
    row, column = (a.ravel() for a in np.mgrid[:30, :30])
    xyz = np.stack([np.full(900, 2.0), (column - 15) * 6e-4, (row - 15) * 6e-4], axis=1)
    lonely = 15 * 30 + 15
    near = np.hypot(row - 15, column - 15)
    xyz[lonely, 0] = 1.7
    grid = SimpleNamespace(rows=30, columns=30, row=row, column=column)
    score = score_ghosts(xyz, ORIGIN, None, grid).score
    assert score[lonely] > 0.9
    assert np.nanmax(score[near > 3]) < THRESHOLD


def test_empty_one_and_all_missing_are_no_trouble():
    for count in (0, 1):
        found = score_ghosts(np.full((count, 3), 1.0), ORIGIN)
        assert found.score.shape == (count,)
    grid = SimpleNamespace(rows=2, columns=2, row=np.arange(4) // 2, column=np.arange(4) % 2)
    missing = score_ghosts(np.full((4, 3), np.nan), ORIGIN, None, grid)
    assert np.isnan(missing.score).all()


def test_bad_requests_are_refused(make_scene):
    scene = make_scene()
    with pytest.raises(WrongUse, match="beam"):
        score_ghosts(scene.xyz, ORIGIN, None, scene.grid, beam=BeamShape(-1.0, 0.0))
    with pytest.raises(WrongUse, match="asked for"):
        score_ghosts(scene.xyz, ORIGIN, np.array([10**7]), scene.grid)


def test_it_can_be_cancelled(make_scene):
    class Stop(Progress):
        def report(self, fraction, text=""):
            raise Cancelled

    scene = make_scene()
    with pytest.raises(Cancelled):
        score_ghosts(scene.xyz, ORIGIN, None, scene.grid, progress=Stop())


@pytest.mark.data
@pytest.mark.parametrize(("name", "least"), [("phase_shift", 0.98), ("pulsed", 0.97)])
def test_scenes_of_another_simulator(shared_data, name, least):
    folder = shared_data / "truth_scenes"
    truth = np.load(folder / f"{name}_truth.npz")
    table = np.loadtxt(folder / f"{name}.ptx", skiprows=10)
    met = table[:, :3].any(axis=1)
    columns, rows = (int(size) for size in truth["shape"])
    grid = SimpleNamespace(rows=rows, columns=columns, row=truth["row"], column=truth["col"])
    light = np.log(np.maximum(table[met, 3], 1e-6))
    counted = ~truth["unsure"]
    on_one = counted & (truth["hit_fraction"] > 0.9999)
    for given in (None, light):
        score = score_ghosts(table[met, :3], ORIGIN, None, grid, light=given).score
        assert f1(score[counted], truth["ghost"][counted]) > least
        assert np.mean(score[on_one] > THRESHOLD) < 0.002
