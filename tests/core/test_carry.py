"""Carried leaves against the truth of simulated series: every angle, drying, neighbours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.core.carry import STILL, Carried, Motion, Pattern, Tolerance, carry, make_pattern
from app.core.errors import BadInput, WrongUse
from app.core.holder import Axis
from app.core.sight import View
from app.model.scan import Scan
from app.simulate.scene_building import build_scene, lay_grid
from app.simulate.scene_file import decode_scene, get_scene, load_document
from app.simulate.series import vary
from app.simulate.simulation import run_simulation
from app.simulate.surfaces import Scene
from app.simulate.virtual_scan import find_instrument, simulate

WHOLE = 0.99
STAGE = Axis.through((2.16, 0.0, 1.6), (0.0, 0.0, 1.0))
FRAME = Axis.through((4.0, 0.0, 1.2), (0.0, 0.0, 1.0))


def scan_scene(name: str, path: str, value: float, step_deg: float | None = None) -> Scan:
    document = vary(load_document(name), path, value)
    return simulate(decode_scene(document, name), step_deg=step_deg).scan


def view_of(scan: Scan) -> View:
    return View(scan.xyz, scan.scanner("a test"), scan.valid)


def patterns_of(scan: Scan, tolerance: Tolerance = Tolerance()) -> list[Pattern]:  # noqa: B008
    labels = scan.attributes["truth_leaf"]
    return [
        make_pattern(view_of(scan), np.flatnonzero(labels == leaf), tolerance)
        for leaf in range(labels.max() + 1)
    ]


def judge(scan: Scan, leaf: int, found: Carried) -> tuple[float, float, float]:
    """Precision; recall of points of the leaf that are no ghosts; recall of whole hits."""
    mine = scan.attributes["truth_leaf"] == leaf
    chosen = np.zeros(len(mine), bool)
    chosen[found.rows] = True
    good = mine & (scan.attributes["truth_ghost"] == 0)
    full = mine & (scan.attributes["truth_hit_fraction"] >= WHOLE)
    whole = chosen[full].mean() if full.any() else np.nan
    return mine[chosen].mean(), chosen[good].mean(), float(whole)


@pytest.fixture(scope="module")
def stage() -> dict[int, Scan]:
    return {angle: scan_scene("goniometer", "stage.angle_deg", angle) for angle in range(0, 90, 5)}


def test_a_leaf_on_a_stage_at_all_angles(stage: dict[int, Scan]) -> None:
    """The stage is 1 mm behind the leaf, nearer than the noise: the outline alone tells."""
    patterns = patterns_of(stage[0])
    assert not patterns[0].free
    for angle, scan in stage.items():
        turn = Motion(STAGE, np.deg2rad(angle))
        (found,) = carry(view_of(scan), patterns, turn)
        precision, recall, whole = judge(scan, 0, found)
        assert precision > 0.94, angle
        assert recall > (0.93 if angle <= 60 else 0.84), angle
        assert np.isnan(whole) or whole > 0.99, angle  # at 85° the beam is wider than the leaf
        assert found.share > 0.8
        assert abs(found.offset) < 0.002
        (wrong,) = carry(view_of(scan), patterns, Motion(STAGE, -turn.angle))
        assert wrong.share <= found.share


def test_from_a_tilted_scan_to_a_frontal_one(stage: dict[int, Scan]) -> None:
    patterns = patterns_of(stage[60])
    (found,) = carry(view_of(stage[0]), patterns, Motion(STAGE, np.deg2rad(-60)))
    precision, recall, whole = judge(stage[0], 0, found)
    assert precision > 0.9
    assert recall > 0.9
    assert whole > 0.95


def test_twelve_leaves_in_a_frame() -> None:
    first = scan_scene("leaf_frame", "frame.angle_deg", 0.0)
    patterns = patterns_of(first)
    assert all(pattern.free for pattern in patterns)
    for angle in (-50, 20, 50):
        scan = scan_scene("leaf_frame", "frame.angle_deg", angle)
        found = carry(view_of(scan), patterns, Motion(FRAME, np.deg2rad(angle)))
        scores = np.array([judge(scan, leaf, one) for leaf, one in enumerate(found)])
        assert scores[:, 0].min() > 0.97
        assert scores[:, 1].min() > 0.94
        assert np.nanmin(scores[:, 2]) == 1.0
        assert max(one.overlap for one in found) == 0.0


def dry_scan(shrink: float, turn_deg: float, droop: float, seed: int = 1, drop: int = -1) -> Scan:
    """The frame of drying leaves: each smaller, turned about its midrib, and lower."""
    file = get_scene("drying")
    tool = find_instrument(file.instrument)
    scene = build_scene(file, tool.wavelengths_nm)
    leaves = []
    for number, leaf in enumerate(scene.leaves):
        along, normal = leaf.frame()[0], np.array(leaf.normal)
        angle = np.deg2rad(turn_deg) * (-1) ** number
        turned = np.cos(angle) * normal + np.sin(angle) * np.cross(along, normal)
        place = np.array(leaf.centre) - [0.0, 0.0, droop]
        leaves.append(
            replace(
                leaf, centre=tuple(place), normal=tuple(turned),
                length=leaf.length * shrink, width=leaf.width * shrink,
            )
        )  # fmt: skip
    if drop >= 0:
        leaves[drop] = replace(leaves[drop], centre=(4.4, 0.9, 1.2))
    grid = lay_grid(file, scene, 0.03)
    made: Scene = replace(scene, leaves=tuple(leaves))
    return run_simulation(made, grid, tool, file.position, seed).scan


@pytest.fixture(scope="module")
def fresh() -> Scan:
    return dry_scan(1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("shrink", "turn", "droop"), [(1.0, 0.0, 0.0), (0.9, 10.0, 0.003), (0.8, 25.0, 0.006)]
)
def test_leaves_that_dry_shrink_turn_and_droop(
    fresh: Scan, shrink: float, turn: float, droop: float
) -> None:
    scan = dry_scan(shrink, turn, droop, seed=2)
    found = carry(view_of(scan), patterns_of(fresh))
    scores = np.array([judge(scan, leaf, one) for leaf, one in enumerate(found)])
    assert scores[:, 0].min() > 0.97
    assert scores[:, 1].min() > 0.97
    assert scores[:, 2].min() == 1.0


def test_a_leaf_that_fell_is_not_found(fresh: Scan) -> None:
    found = carry(view_of(dry_scan(0.9, 5.0, 0.0, drop=4)), patterns_of(fresh))
    assert len(found[4].rows) < 10
    assert found[4].share < 0.2
    assert all(one.share > 0.8 for leaf, one in enumerate(found) if leaf != 4)
    nothing = View(np.full((5, 3), 9.0), np.zeros(3), np.ones(5, bool))
    (gone,) = carry(nothing, patterns_of(fresh)[:1])
    assert (len(gone.rows), gone.share) == (0, 0.0)
    assert np.isnan(gone.offset)


def sheet(
    centre: tuple[float, float, float], size: float = 0.02, step: float = 0.001
) -> np.ndarray:
    """A square seen face-on from the origin."""
    side = np.arange(-size / 2, size / 2 + step / 2, step)
    y, z = (a.ravel() for a in np.meshgrid(side, side))
    return np.column_stack([np.full(len(y), centre[0]), y + centre[1], z + centre[2]])


def lay(*sheets: np.ndarray) -> View:
    xyz = np.concatenate(sheets)
    return View(xyz, np.zeros(3), np.ones(len(xyz), bool))


def test_a_leaf_among_others_keeps_its_outline_and_shares_nothing() -> None:
    first, second = sheet((2.0, 0.0, 0.0)), sheet((2.0, 0.021, 0.0))
    view = lay(first, second)
    rows = np.split(np.arange(len(view.xyz)), 2)
    patterns = [make_pattern(view, mine) for mine in rows]
    assert not any(pattern.free for pattern in patterns)
    for mine, one in zip(rows, carry(view, patterns), strict=True):
        np.testing.assert_array_equal(one.rows, mine)
    moved = lay(first + np.array([0.0, 0.0105, 0.0]))
    both = carry(moved, patterns)
    every = np.concatenate([one.rows for one in both])
    assert len(every) == len(np.unique(every))
    assert 0.3 < both[0].share < 0.7


def test_what_stands_behind_or_far_off_is_not_taken() -> None:
    leaf, behind = sheet((2.0, 0.0, 0.0)), sheet((2.05, 0.0, 0.0))
    pattern, near = make_pattern(lay(leaf), np.arange(len(leaf))), np.array([0.004, 0.003, 0.0])
    assert pattern.free
    (found,) = carry(lay(leaf + near, behind), [pattern])
    np.testing.assert_array_equal(found.rows, np.arange(len(leaf)))
    assert found.offset == pytest.approx(0.004, abs=1e-4)
    (found,) = carry(lay(behind), [pattern])
    assert len(found.rows) == 0
    (strict,) = carry(lay(leaf + near), [pattern], STILL, Tolerance(0.0, 0.0, 0.0))
    assert strict.share < 1.0


def test_range_noise_of_the_reference_does_not_fray_the_outline() -> None:
    rng = np.random.default_rng(2)
    leaf = sheet((2.0, 0.0, 0.0), 0.04)
    noisy = leaf * (1 + 0.001 * rng.standard_normal(len(leaf)))[:, None]
    pattern = make_pattern(lay(noisy), np.arange(len(leaf)))
    off = np.abs(pattern.xyz[:, 0] - 2.0)
    assert np.sqrt(np.mean(off**2)) < 0.35 * 0.002
    assert pattern.thickness == pytest.approx(0.002, rel=0.2)


def test_bad_input() -> None:
    with pytest.raises(BadInput):
        make_pattern(lay(sheet((2.0, 0.0, 0.0))), np.arange(2))
    with pytest.raises(WrongUse, match="movement"):
        Tolerance(movement=-1.0)
