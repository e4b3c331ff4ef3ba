"""The truth beside every point, and the scan that carries it."""

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.phase import MODELS, get_model
from app.core.progress import LiveProgress
from app.simulate.instrument import get_instrument
from app.simulate.material import Sheen, glossy, matt
from app.simulate.scene_file import get_scene
from app.simulate.simulation import scan_scene
from app.simulate.tables import sample_phase, tabulate_optics
from app.simulate.virtual_scan import simulate


@pytest.fixture(scope="module")
def scan():
    return simulate("branch", step_deg=0.06).scan


def column(scan, name):
    return scan.attributes[f"truth_{name}"]


def test_the_truth_is_complete_and_finite(scan):
    names = {name for name in scan.attributes if name.startswith("truth_")}
    assert names == {
        *(f"truth_{n}" for n in ("leaf", "incidence", "ghost", "range", "distance", "range_shift")),
        *(f"truth_{n}" for n in ("components", "sigma_range", "normal_x", "normal_y", "normal_z")),
        *(f"truth_{n}{t}" for n in ("surface", "hit_fraction") for t in ("", "_2", "_3")),
        *(f"truth_{n}_{nm}" for n in ("rho", "reflectance") for nm in (1063, 1545)),
        *(f"truth_sigma_reflectance_{nm}" for nm in (1063, 1545)),
    }
    for name in names:
        assert len(scan.attributes[name]) == len(scan)
        assert np.isfinite(scan.attributes[name]).all()


def test_ghosts_follow_from_the_distance(scan):
    distance, ghost = column(scan, "distance"), column(scan, "ghost")
    np.testing.assert_array_equal(ghost == 1, distance > np.float32(0.006))
    np.testing.assert_array_equal(ghost == 2, (distance > 0.002) & (distance <= 0.006))


def test_the_normal_makes_the_angle_of_incidence(scan):
    normal = np.stack([column(scan, f"normal_{axis}") for axis in "xyz"], axis=1)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-6)
    beam = scan.xyz - np.array(scan.pose.position)
    cosine = -(normal * beam).sum(axis=1) / np.linalg.norm(beam, axis=1)
    assert (cosine > -1e-3).all()
    omega = np.rad2deg(np.arccos(np.clip(cosine, -1, 1)))
    # The facet is met by the most central sub-ray on it, which leans a little.
    assert np.abs(omega - column(scan, "incidence")).max() < 0.2


def test_reflectance_is_rho_times_its_phase_function():
    scan = simulate("leaf_row", step_deg=0.04).scan
    whole = (column(scan, "hit_fraction") > 0.9999) & (column(scan, "leaf") >= 0)
    rho, full = column(scan, "rho_1063")[whole], column(scan, "reflectance_1063")[whole]
    omega = np.deg2rad(column(scan, "incidence")[whole])
    phase = get_model("lambert-beckmann").evaluate(omega, {"f": 1.0, "k_d": 0.88, "m": 0.22})
    np.testing.assert_allclose(full, rho * phase, rtol=2e-5)
    noise = scan.channel_values("reflectance_1063")[whole] / full - 1
    assert noise.std() == pytest.approx(0.03, rel=0.1)
    sigma = column(scan, "sigma_reflectance_1063")[whole]
    np.testing.assert_allclose(sigma, 0.03 * full, rtol=0.1)


def test_range_noise_has_its_sigma_white_or_filtered():
    for noise, correlation in (("white", 0.0), ("filtered", 2 / 3)):
        scan = simulate("wall_edge", step_deg=0.01, noise=noise).scan
        error = np.linalg.norm(scan.xyz - np.array(scan.pose.position), axis=1)
        error = (error - column(scan, "range")) / column(scan, "sigma_range")
        assert error.std() == pytest.approx(1.0, abs=0.03)
        image = np.full((scan.grid.rows, scan.grid.columns), np.nan)
        image[scan.grid.row, scan.grid.column] = error
        product = image[:, 1:] * image[:, :-1]
        assert np.nanmean(product) == pytest.approx(correlation, abs=0.04)


def test_no_noise_means_none():
    scan = simulate("leaf", step_deg=0.05, noise="none").scan
    away = np.linalg.norm(scan.xyz - np.array(scan.pose.position), axis=1)
    np.testing.assert_allclose(away, column(scan, "range"), atol=1e-12)


def test_same_arguments_same_scan_and_another_seed_another():
    first, again, other = (simulate("leaf", step_deg=0.1, seed=seed).scan for seed in (1, 1, 2))
    assert first.xyz.tobytes() == again.xyz.tobytes()
    for name, values in first.attributes.items():
        np.testing.assert_array_equal(values, again.attributes[name])
    assert first.xyz.tobytes() != other.xyz.tobytes()


def test_several_returns_of_a_beam_are_numbered():
    scan = simulate("leaf_frame", step_deg=0.1).scan
    number, count = (scan.attributes[n] for n in ("return_number", "number_of_returns"))
    cell = scan.grid.row.astype(np.int64) * scan.grid.columns + scan.grid.column
    _, per_cell = np.unique(cell, return_counts=True)
    assert (per_cell > 1).any()
    np.testing.assert_array_equal(np.repeat(per_cell, per_cell), count)
    assert (number <= count).all()
    ranges = column(scan, "range")
    same = cell[1:] == cell[:-1]
    assert (ranges[1:][same] > ranges[:-1][same]).all()


def test_waveforms_belong_to_the_points():
    made = simulate("leaf_frame", step_deg=0.3, keep_waveforms=True)
    waves = made.waveforms
    assert len(waves.of_return) == len(made.scan)
    near = column(made.scan, "range") - waves.start[waves.of_return]
    peak = waves.samples[waves.of_return, 0].argmax(axis=1) * waves.step
    single = made.scan.attributes["number_of_returns"] == 1
    assert np.abs(near - peak)[single].mean() < 0.1
    assert simulate("leaf_frame", step_deg=0.3).waveforms is None


def test_cancel_stops_between_bands():
    from app.core.errors import Cancelled

    seen = []

    def listen(fraction, _text):
        seen.append(fraction)

    with pytest.raises(Cancelled):
        simulate("branch", step_deg=0.05, progress=LiveProgress(listen, lambda: len(seen) > 3))
    assert max(seen) < 0.5


@pytest.mark.parametrize("name", sorted(MODELS))
def test_every_phase_function_can_shape_a_reflectance(name):
    model = MODELS[name]
    random = np.random.default_rng(1)
    typical: dict[str, float] = {}
    while not typical or not model.evaluate(np.zeros(1), typical)[0] > 0:
        typical = {p.name: float(random.uniform(*p.typical)) for p in model.parameters}
    samples = sample_phase(Sheen(0.5, name, tuple(typical.items())))
    place = np.linspace(0, 1, len(samples))
    omega = 2 * np.arcsin(place / np.sqrt(2))
    exact = model.evaluate(np.minimum(omega, np.pi / 2), typical)
    exact = np.maximum(exact / exact[0], 0)
    np.testing.assert_allclose(samples, exact, atol=1e-12)
    between = (place[1:] + place[:-1]) / 2
    middle = model.evaluate(np.minimum(2 * np.arcsin(between / np.sqrt(2)), np.pi / 2), typical)
    middle = np.maximum(middle / model.evaluate(np.zeros(1), typical)[0], 0)
    between = (samples[1:] + samples[:-1]) / 2
    smooth = np.minimum(samples[1:], samples[:-1]) > 0
    np.testing.assert_allclose(between[smooth], middle[smooth], atol=2e-5)


def test_what_cannot_be_is_refused():
    with pytest.raises(WrongUse, match="needs"):
        sample_phase(Sheen(0.5, "lambert-beckmann", (("k_d", 0.5),)))
    with pytest.raises(WrongUse, match="reflectance"):
        matt(-0.1)
    branch = simulate("leaf", step_deg=0.2)
    hsl = get_instrument("hsl")
    with pytest.raises(WrongUse, match="nm"):
        scan_scene(branch.scene, None, hsl)
    mixed = replace(branch.scene.leaves[0], material=(glossy(0.5, 0.9, 0.2),))
    scene = replace(branch.scene, leaves=(mixed,))
    with pytest.raises(WrongUse, match="channels"):
        tabulate_optics(scene)
    assert get_scene("leaf").seed == 0
