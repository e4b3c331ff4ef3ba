"""The truth of a scene is what its parts, the noise and the closed forms say."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.services.bench.ghosts import scenes
from app.services.bench.ghosts.goals import F1
from app.services.bench.ghosts.parts import list_ranges
from app.services.bench.ghosts.plans import PLANS
from app.services.bench.ghosts.scenes import OTHERS, list_plans, make_scene, read_other
from app.simulate.ranging import phase_range
from app.simulate.virtual_scan import arrange, find_instrument, find_scene, set_noise


@pytest.fixture(scope="module")
def wall():
    return make_scene("leaves before a wall", 7, step_deg=0.12)


def test_a_method_sees_no_truth_and_a_scanner_and_a_grid(wall):
    assert list(wall.scan.attributes) == ["intensity_785"]
    assert list(wall.channels) == ["intensity_785"]
    assert not [key for key in wall.scan.metadata if "truth" in key]
    assert wall.grid.row.shape == wall.off.shape
    assert wall.scanner.tolist() == [0.0, 0.0, 1.6]
    assert wall.beam.radius == 0.0015


def test_the_same_seed_is_the_same_scene_and_another_is_another(wall):
    again = make_scene("leaves before a wall", 7, step_deg=0.12)
    other = make_scene("leaves before a wall", 8, step_deg=0.12)
    np.testing.assert_array_equal(again.xyz, wall.xyz)
    np.testing.assert_array_equal(again.off, wall.off)
    assert not np.array_equal(other.off[: len(wall)], wall.off[: len(other)])


def test_points_on_one_surface_scatter_about_it_by_their_own_noise(wall):
    """Noise of 0.7 mm at 90 % reflectance, more on darker leaves, none of it in the truth."""
    off = (wall.own - wall.main)[wall.full] / wall.sigma[wall.full]
    assert off.std() == pytest.approx(1.0, abs=0.05)
    assert abs(off.mean()) < 0.05
    assert 0.0007 <= wall.sigma[wall.full].min() < 0.0012
    assert (wall.off[wall.full] < 1e-9).all()


def test_ghosts_are_off_their_main_surface_by_more_than_their_distance(wall):
    away = np.abs(wall.own - wall.main)[wall.ghost]
    assert (away > 0.006 - 6 * wall.sigma[wall.ghost]).all()
    assert 0.02 < wall.ghost.mean() < 0.08
    assert 0.005 < (~wall.ghost & ~wall.good).mean() < 0.03


def test_the_wall_behind_stands_where_it_should(wall):
    on = (wall.leaf < 0) & (wall.off < 1e-9)
    np.testing.assert_allclose(wall.main[on] * (wall.xyz[on, 0] / wall.own[on]), 6.0, atol=2e-4)


@pytest.mark.parametrize("name", [plan.name for plan in PLANS if not plan.slow])
def test_every_scene_can_be_made_and_has_the_ghosts_of_its_group(name):
    scene = make_scene(name, 3, quick=True, step_deg=0.15)
    for values in (scene.off, scene.full, scene.leaf, scene.main, scene.sigma, scene.exact):
        assert values.shape == (len(scene),)
    assert np.isfinite(scene.main).all()
    assert not (scene.full & (scene.leaf < 0)).any()
    assert not (scene.full & scene.ghost).any()
    assert scene.ghost.any() == (scene.group != "clean")
    if scene.group in F1:
        assert scene.ghost.mean() > 0.005


def test_leaves_of_close_scenes_stand_within_a_pulse_and_others_do_not():
    close = make_scene("pulsed, close", 3, step_deg=0.15, others=True)
    apart = make_scene("pulsed leaves, apart", 3, step_deg=0.15, others=True)
    for scene in (close, apart):
        between = np.abs(scene.others[:, 0] - scene.main)[scene.ghost]
        assert np.nanmax(between) < 0.5
    assert close.own.max() - close.own.min() < 0.6
    assert apart.own.max() - apart.own.min() > 3.0
    assert apart.ghost.mean() < close.ghost.mean()


def test_the_other_surfaces_ranges_explain_the_phase_range():
    """Two walls: the reported range follows from both ranges and the beam's shares.

    The front one faces the scanner with its middle, 10 cm beside the edge.
    """
    tool = set_noise(find_instrument("two_colour"), "none")
    setup = arrange(find_scene("wall_edge"), tool, 0.03)
    scan = setup.scan().scan
    at = scan.attributes
    ranges = list_ranges(setup, scan)
    mixed = at["truth_components"] == 2
    assert mixed.sum() > 20
    np.testing.assert_array_equal(np.isfinite(ranges[:, 0]), mixed)
    assert np.isnan(ranges[:, 1]).all()
    main = at["truth_range"] - at["truth_range_shift"]
    beams = scan.xyz - scan.scanner("the test")
    cosine = beams[:, 0] / np.linalg.norm(beams, axis=1)
    walls = np.sort(np.column_stack((main, ranges[:, 0]))[mixed] * cosine[mixed, None], axis=1)
    np.testing.assert_allclose(
        walls, np.tile([3.0 + 0.1**2 / 3.0, 3.4], (len(walls), 1)), atol=1e-4
    )
    # Both walls are alike: energies go by shares, and the inverse square of the range.
    away = np.column_stack((main, ranges[:, 0]))[mixed]
    share = np.column_stack((at["truth_hit_fraction"], at["truth_hit_fraction_2"]))[mixed]
    expected = [phase_range(r, s / r**2) for r, s in zip(away, share, strict=True)]
    np.testing.assert_allclose(at["truth_range"][mixed], expected, atol=2e-3)


def test_an_unknown_scene_is_refused():
    with pytest.raises(WrongUse, match="no scene 'forest'"):
        make_scene("forest", 1)
    assert "crown, 4 m" in list_plans()


@pytest.mark.data
@pytest.mark.parametrize("name", OTHERS)
def test_the_other_simulators_wall_is_exact_and_its_leaves_hold_their_noise(shared_data, name):
    scene = read_other(shared_data / "truth_scenes", name)
    with np.load(shared_data / "truth_scenes" / f"{name}_truth.npz") as file:
        np.testing.assert_array_equal(scene.ghost, file["ghost"])
        shift = file["range_shift_m"].astype(float)
        np.testing.assert_array_equal(scene.ghost | scene.good, ~file["unsure"])
    # Scanned less shift less the wall's plane is the noise alone, at ghosts too.
    for some in (scene.exact, scene.exact & scene.ghost):
        noise = ((scene.own - shift - scene.main) / scene.sigma)[some]
        assert noise.std() == pytest.approx(1.0, abs=0.03)
        assert abs(noise.mean()) < 0.05
    assert (scene.leaf[scene.exact] == -1).all()
    assert np.isnan(scene.others).all()


def test_truth_that_cannot_be_read_is_refused(tmp_path, monkeypatch, wall):
    monkeypatch.setattr(scenes, "read_file", lambda _: [wall.scan])
    with pytest.raises(BadInput, match="cannot be read"):
        read_other(tmp_path, "pulsed")
    columns = {key: np.zeros(3) for key in scenes.NEEDED}
    np.savez(tmp_path / "pulsed_truth.npz", **columns)
    with pytest.raises(BadInput, match="its scan has"):
        read_other(tmp_path, "pulsed")
