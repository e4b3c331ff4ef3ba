"""Parts of scenes: each builds what its numbers say."""

import time

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.simulate.branch import BARK, LEAF
from app.simulate.leaf_table import measure_areas, name_kind, tabulate_leaves
from app.simulate.parts import KINDS, AnyPart, Pieces, Surroundings, assemble
from app.simulate.parts.foliage import Drying
from app.simulate.surfaces import Leaf, Stem, Wall

SCANNER = (0.3, -0.2, 1.6)
SMALL = {
    "crown": {"count": 200},
    "pear_row": {"trees": 4, "leaves_per_tree": 9},
    "stem": {"start": [1, 2, 3], "end": [1, 2, 4]},
}


def build(kind, seed=1, hours=0.0, wavelengths=(1063.0, 1545.0), **keys):
    part = msgspec.convert({"kind": kind} | keys, AnyPart, strict=True)
    return part.build(Surroundings(np.random.default_rng(seed), SCANNER, wavelengths, hours))


def truth(pieces):
    return tabulate_leaves(assemble((pieces,)), SCANNER)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_kind_builds_as_many_surfaces_as_it_says_in_the_channels_asked_for(kind):
    keys = SMALL.get(kind, {})
    pieces = build(kind, wavelengths=(532.0, 785.0, 1545.0), **keys)
    surfaces = (*pieces.leaves, *pieces.stems, *pieces.walls)
    part = msgspec.convert({"kind": kind} | keys, AnyPart, strict=True)
    assert len(surfaces) == part.count_surfaces() > 0
    assert {len(surface.material) for surface in surfaces} == {3}
    assert pieces == build(kind, wavelengths=(532.0, 785.0, 1545.0), **keys)


def test_needles_are_numbered_after_all_leaves():
    leaf = Leaf((2, 0, 0), (0, 0, -1), (-1, 0, 0), 0.08, 0.05, LEAF)
    needle, twig = (Stem((2, 0, 0), (2, 0, 1), 0.01, BARK, label) for label in (1, -1))
    first = Stem((2, 0, 0), (2, 0, 1), 0.01, BARK, 0)
    panel = Wall((2, 0, 0), (0, 1, 0), (0, 0, 1), BARK)
    pieces = (Pieces((leaf,), (first, needle, twig), (panel,)), Pieces((leaf,), (first,)))
    scene = assemble(pieces, "both", (1063.0, 1545.0))
    assert list(scene.labels()) == [0, 1, 2, 3, -1, 4, -1]
    assert [row.number for row in tabulate_leaves(scene)] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("tilt", [0, 20, -35, 75])
@pytest.mark.parametrize("direction", [{}, {"azimuth_deg": 40, "elevation_deg": 25}])
def test_leaf_stands_in_its_direction_at_its_tilt(tilt, direction):
    (row,) = truth(build("leaf", range=3.2, tilt_deg=tilt, **direction))
    away = np.subtract(row.centre, SCANNER)
    assert np.linalg.norm(away) == pytest.approx(3.2)
    azimuth, elevation = np.arctan2(away[1], away[0]), np.arcsin(away[2] / 3.2)
    expected = (direction.get("azimuth_deg", 0), direction.get("elevation_deg", 0))
    assert np.rad2deg([azimuth, elevation]) == pytest.approx(expected)
    assert row.tilt_deg == pytest.approx(abs(tilt), abs=1e-6)


def test_leaf_by_its_normal_hangs_tip_down_unless_rolled():
    hanging = build("leaf", normal=[-1, 0, 0], centre=[2, 0, 1]).leaves[0]
    np.testing.assert_allclose(hanging.frame()[0], (0, 0, -1), atol=1e-12)
    # As the scanner, which looks along x, sees it: anticlockwise from down is right, −y.
    rolled = build("leaf", normal=[-1, 0, 0], centre=[2, 0, 1], roll_deg=90).leaves[0]
    np.testing.assert_allclose(rolled.frame()[0], (0, -1, 0), atol=1e-12)
    level = build("leaf", normal=[0, 0, 1], centre=[2, 0, 1]).leaves[0]
    np.testing.assert_allclose(level.frame()[0], (1, 0, 0), atol=1e-12)


def test_leaf_takes_its_shape_from_its_numbers():
    shapes = {
        "flat": {},
        "bent": {"curvature": 9, "bend_direction_deg": 90},
        "wrinkled": {"wrinkle_height": 0.001, "wrinkle_phases_deg": [90, 0]},
        "lobed": {"lobes": 5, "lobe_depth": 0.3},
    }
    for kind, keys in shapes.items():
        leaf = build("leaf", **keys).leaves[0]
        assert name_kind(leaf) == kind
    bent, wrinkled = (build("leaf", **shapes[kind]).leaves[0] for kind in ("bent", "wrinkled"))
    assert (bent.bend_direction, wrinkled.wrinkle_phases[0]) == pytest.approx((np.pi / 2,) * 2)


def test_leaf_row_keeps_its_tilts_and_spacing():
    rows = truth(build("leaf_row", tilts_deg=[0, -30, 60], spacing=0.1, range=2))
    assert [row.tilt_deg for row in rows] == pytest.approx([0, 30, 60], abs=1e-6)
    assert np.diff([row.centre[1] for row in rows]) == pytest.approx(-0.1)


def test_scattered_leaves_keep_to_their_field_and_differ():
    keys = {"count": 300, "ranges": [2, 3], "azimuth_deg": [10, 20], "elevation_deg": [-5, 30]}
    rows = truth(build("scatter", steepest_deg=40, **keys))
    away = np.array([row.centre for row in rows]) - SCANNER
    distance = np.linalg.norm(away, axis=1)
    azimuth = np.rad2deg(np.arctan2(away[:, 1], away[:, 0]))
    elevation = np.rad2deg(np.arcsin(away[:, 2] / distance))
    bounds = (keys["ranges"], keys["azimuth_deg"], keys["elevation_deg"])
    for values, (low, high) in zip((distance, azimuth, elevation), bounds, strict=True):
        assert low <= values.min() < low + 0.05 * (high - low)
        assert high >= values.max() > high - 0.05 * (high - low)
    assert 35 < max(row.tilt_deg for row in rows) <= 40 + 1e-6
    assert [row.kind for row in rows[:3]] == ["flat", "bent", "wrinkled"]
    rho = np.array([row.rho for row in rows])
    scatter = rho.std(axis=0) / rho.mean(axis=0)
    assert 0.01 < scatter[0] < 0.03 < scatter[1] < 0.1
    assert np.std([row.water for row in rows]) == pytest.approx(0.1, rel=0.15)


def test_wall_and_ground():
    wall = build("wall", range=5, width=2, height=1, tilt_deg=30).walls[0]
    assert (wall.name, wall.label) == ("wall", -1)
    normal = np.cross(wall.across, wall.up) / (1.0 * 0.5)
    assert abs(normal[0]) == pytest.approx(np.cos(np.deg2rad(30)))
    ground = build("wall", centre=[3, 0, 0], level=True, height=4).walls[0]
    assert ground.name == "ground"
    assert np.abs(np.cross(ground.across, ground.up)) == pytest.approx([0, 0, 6])


def test_panels_face_the_scanner_at_their_range_and_reflectance():
    panel = build("panel", rho=0.25, range=7.5, azimuth_deg=-20).walls[0]
    assert panel.name == "panel 25 %"
    assert [sheen.rho for sheen in panel.material] == [0.25, 0.25]
    assert np.linalg.norm(np.subtract(panel.centre, SCANNER)) == pytest.approx(7.5)
    beam = np.subtract(panel.centre, SCANNER)
    assert np.dot(beam, panel.across) == pytest.approx(0, abs=1e-9)
    row = build("panel_set", rhos=[0.99, 0.5, 0.12], size=0.2, gap=0.1).walls
    assert [wall.material[0].rho for wall in row] == [0.99, 0.5, 0.12]
    assert np.diff([wall.centre[1] for wall in row]) == pytest.approx(-0.3)


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize("angle", [0, 30, 85, -60])
def test_goniometer_turns_its_leaf_and_plate_as_one(axis, angle):
    pieces = build("goniometer", angle_deg=angle, axis=axis, elevation_deg=15, azimuth_deg=30)
    (row,) = truth(pieces)
    assert row.tilt_deg == pytest.approx(abs(angle), abs=1e-6)
    plate, leaf = pieces.walls[0], pieces.leaves[0]
    frame = leaf.frame()
    np.testing.assert_allclose(np.dot(frame[2], plate.across), 0, atol=1e-12)
    np.testing.assert_allclose(np.dot(frame[2], plate.up), 0, atol=1e-12)
    behind = np.subtract(leaf.centre, plate.centre)
    np.testing.assert_allclose(behind, 0.001 * np.array(row.normal), atol=1e-12)


def test_leaf_frame_turns_as_one_and_keeps_its_leaves():
    straight, turned = (build("leaf_frame", angle_deg=angle) for angle in (0, 40))
    assert len(straight.leaves) == 12
    a, b = (np.array([leaf.centre for leaf in p.leaves]) for p in (straight, turned))
    middle = a.mean(axis=0)
    c, s = np.cos(np.deg2rad(40)), np.sin(np.deg2rad(40))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(b, (a - middle) @ turn.T + middle, atol=1e-12)
    normals = [np.array([leaf.frame()[2] for leaf in p.leaves]) for p in (straight, turned)]
    np.testing.assert_allclose(normals[1], normals[0] @ turn.T, atol=1e-12)
    assert [p.material for p in straight.leaves] == [p.material for p in turned.leaves]
    tilts = [row.tilt_deg for row in truth(straight)]
    assert 3 < np.mean(tilts) < 12
    threads = [stem for stem in straight.stems if stem.radius < 0.001]
    assert all(abs(t.start[2] - t.end[2]) > 0 for t in threads)


def test_leaves_dry_by_their_law_and_keep_their_places():
    wet, dry = (build("leaf_frame", hours=hours) for hours in (0.0, 77.0))
    assert [leaf.centre for leaf in wet.leaves] == [leaf.centre for leaf in dry.leaves]
    assert all(b.water < 0.4 < a.water for a, b in zip(wet.leaves, dry.leaves, strict=True))
    assert all(
        b.material[1].rho > 1.2 * a.material[1].rho
        for a, b in zip(wet.leaves, dry.leaves, strict=True)
    )
    exact = {"drying": {"hours": 20.0, "final": 0.2, "scatter": 0.0}}
    leaf = build("leaf", hours=30.0, **exact).leaves[0]
    assert leaf.water == pytest.approx(0.2 + 0.8 * np.exp(-1.5))


def test_drying_scatters_from_leaf_to_leaf():
    random = np.random.default_rng(3)
    left = np.array([Drying(scatter=0.3).water(24.0, random) for _ in range(2000)])
    assert np.median(left) == pytest.approx(0.1 + 0.9 * np.exp(-1), abs=0.02)
    assert 0.05 < left.std() < 0.2
    assert Drying(scatter=0.5).water(0.0, random) == pytest.approx(1.0)


def test_needles_lie_side_by_side_before_the_cloth():
    pieces = build("needle_row", count=10, diameter=0.002, gap=0.001, angle_deg=35, roll_deg=20)
    assert [stem.label for stem in pieces.stems] == list(range(10))
    middles = np.array([np.add(s.start, s.end) / 2 for s in pieces.stems])
    assert np.linalg.norm(np.diff(middles, axis=0), axis=1) == pytest.approx(0.003)
    cloth = pieces.walls[0]
    normal = np.cross(cloth.across, cloth.up)
    normal /= np.linalg.norm(normal)
    normal *= np.sign(normal @ np.subtract(SCANNER, cloth.centre))
    before = (middles - cloth.centre) @ normal
    assert before == pytest.approx(0.002)
    assert all(row.kind == "needle" for row in truth(pieces))


def test_shoot_has_needles_at_their_angle_around_its_twig():
    twig, *needles = build("shoot", needles=300, spread_deg=50, scatter_deg=5, angle_deg=20).stems
    assert (twig.label, [needle.label for needle in needles]) == (-1, list(range(300)))
    axis = np.subtract(twig.end, twig.start)
    assert np.linalg.norm(axis) == pytest.approx(0.12)
    ahead = np.array([np.subtract(n.end, n.start) for n in needles])
    cosine = ahead @ axis / np.linalg.norm(ahead, axis=1) / np.linalg.norm(axis)
    angle = np.rad2deg(np.arccos(cosine))
    assert (angle.mean(), angle.std()) == pytest.approx((50, 5), rel=0.1)
    around = ahead - np.outer(ahead @ axis, axis) / (axis @ axis)
    assert np.linalg.norm(around.mean(axis=0)) < 0.1 * np.linalg.norm(around, axis=1).mean()


def test_pear_row_has_the_paper_s_trees():
    pieces = build("pear_row", range=3)
    assert len(pieces.leaves) == 15 * 60
    feet = np.array([stem.start for stem in pieces.stems if stem.radius == 0.012])
    assert len(feet) == 15
    assert np.ptp(feet[:, 1]) == pytest.approx(14 * 0.3, abs=0.1)
    assert np.abs(feet[:, 2]).max() == 0
    top = max(stem.end[2] for stem in pieces.stems if stem.radius == 0.003)
    assert 1.8 <= top <= 2.2
    assert np.mean([leaf.length for leaf in pieces.leaves]) == pytest.approx(0.065, abs=0.001)
    assert np.mean([leaf.width for leaf in pieces.leaves]) / 2 == pytest.approx(0.0219, abs=0.001)
    assert min(leaf.centre[2] for leaf in pieces.leaves) > 0.2


def test_crown_of_ten_thousand_leaves_is_made_in_a_moment():
    start = time.process_time()
    pieces = build("crown", centre=[10, 0, 4])
    assert time.process_time() - start < 2
    place = (np.array([leaf.centre for leaf in pieces.leaves]) - [10, 0, 4]) / [2, 2, 2.2]
    away = np.linalg.norm(place, axis=1)
    assert len(away) == 10_000
    assert 0.45 <= away.min() <= away.max() <= 1.0
    # Evenly over the volume: the shell out to the median radius holds half of it.
    assert np.median(away) == pytest.approx(np.cbrt((1 + 0.45**3) / 2), abs=0.01)
    up = np.abs([leaf.frame()[2][2] for leaf in pieces.leaves[:2000]])
    assert 0.5 < up.mean() < 0.8  # spherical 0.5, level leaves 1
    assert measure_areas(pieces.leaves[:500]).sum() > 500 * 0.0018
    trunk = pieces.stems[0]
    assert trunk.start[2] == pytest.approx(0.0)


def test_branch_takes_materials_of_other_wavelengths():
    pieces = build("branch", leaves=5, wavelengths=(690.0,))
    assert len(pieces.leaves) == 11
    assert pieces.leaves[0].material[0].rho == pytest.approx(0.07)
    with pytest.raises(BadInput, match="1800 nm"):
        build("branch", wavelengths=(1800.0,))


@pytest.mark.parametrize("height", [4.0, -2.0])
@pytest.mark.parametrize("tilt", [0, 30, -50])
def test_leaf_straight_above_or_below_the_scanner_has_its_tilt(height, tilt):
    (row,) = truth(build("leaf", centre=[*SCANNER[:2], height], tilt_deg=tilt))
    assert row.tilt_deg == pytest.approx(abs(tilt), abs=1e-6)


@pytest.mark.parametrize("kind", ["leaf", "leaf_row", "goniometer", "panel", "shoot"])
@pytest.mark.parametrize("place", [{"centre": list(SCANNER)}, {"range": 1e-300}])
def test_nothing_stands_where_the_scanner_is(kind, place):
    with pytest.raises(WrongUse, match="where the scanner is"):
        build(kind, **place)


def test_a_leaf_of_a_row_cannot_be_where_the_scanner_is():
    centre = [SCANNER[0], SCANNER[1] - 0.05, SCANNER[2]]
    with pytest.raises(WrongUse, match="where the scanner is"):
        build("leaf_row", centre=centre, tilts_deg=[0, 0], spacing=0.1)


def test_waves_are_as_long_and_as_gentle_as_the_tracer_needs():
    with pytest.raises(msgspec.ValidationError, match=r"0\.005"):
        build("leaf", wrinkle_lengths=[0.0049, 0.01])
    with pytest.raises(WrongUse, match=r"too steep.*3\.14"):
        build("leaf", wrinkle_height=-0.0025, wrinkle_lengths=[1, 0.005])
    assert build("leaf", wrinkle_height=0.0023, wrinkle_lengths=[1, 0.005]).leaves


def test_a_leaf_as_long_as_its_frame_hangs_on_no_thread():
    leaves = {"length": [0.42, 0.42], "width": [0.1, 0.1], "shapes": ["flat"]}
    pieces = build("leaf_frame", rows=1, columns=1, across=0.42, lean_deg=0, leaves=leaves)
    assert all(stem.radius > 0.001 for stem in pieces.stems)
