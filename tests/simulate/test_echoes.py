"""Returns of the tracer against the plain reference functions of `ranging`."""

from dataclasses import replace

import numpy as np
import pytest

from app.simulate.beam import BeamGrid, Bundle
from app.simulate.instrument import get_instrument
from app.simulate.material import matt
from app.simulate.ranging import PhaseShift, Pulsed, Waveform, phase_range, pulsed_ranges
from app.simulate.receiver import Receiver
from app.simulate.scanner import trace_beams
from app.simulate.surfaces import Scene, Wall

HERE = (0.0, 0.0, 0.0)
ONE_BEAM = BeamGrid(0.0, 0.0, 0.01, 1, 1)
BUNDLE = Bundle()


def steps(distances, edges, rho):
    """Walls that each hide a share of the beam: the nearest covers y < its edge, and so on."""
    walls = []
    for distance, edge, value in zip(distances, edges, rho, strict=True):
        materials = (matt(value), matt(value * 0.7))
        width = BUNDLE.radius(distance)
        walls.append(Wall((distance, edge * width - 1.0, 0.0), (0, 1.0, 0), (0, 0, 1.0), materials))
    return Scene("steps", walls=tuple(walls))


def plain_echoes(scene):
    """Distance, energy in both channels and share of each sub-ray, by looking at every wall."""
    found = []
    for a, _, share in BUNDLE.subrays():
        best = None
        for wall in scene.walls:
            distance = wall.centre[0]
            y = a * BUNDLE.radius(distance)  # the beam's left is +y
            if y <= wall.centre[1] + 1.0 and (best is None or distance < best[0]):
                best = (distance, wall.material)
        if best is not None:
            distance, material = best
            # A sub-ray leans by its place times the spread; its facet is square to the beam.
            energy = [share * sheen.rho / distance**2 for sheen in material]
            found.append((distance, *energy, share))
    return np.array(found)


def trace(scene, ranging, seed=0, keep=False):
    two = get_instrument("two_colour")
    tool = replace(two, ranging=ranging, receiver=Receiver(), bundle=BUNDLE, ranging_channel=0)
    return trace_beams(scene, ONE_BEAM, tool, HERE, seed, keep_waveforms=keep)


SCENES = [
    steps([3.0], [1.5], [0.5]),
    steps([3.0, 3.1], [-0.2, 2], [0.5, 0.6]),
    steps([3.0, 3.4], [0.4, 2], [0.3, 0.9]),
    steps([2.0, 2.2, 4.0], [-0.5, 0.3, 2], [0.5, 0.1, 0.6]),
    steps([2.0, 3.5, 5.0, 9.0], [-0.6, -0.1, 0.4, 2], [0.5, 0.4, 0.6, 0.9]),
    steps([2.0, 3.5], [-0.9, 0.2], [0.5, 0.4]),
]


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("waves", [(76.8, 9.6, 1.2), (16.0, 4.0), (25.0,)])
def test_phase_shift_range_is_that_of_the_plain_sum(scene, waves):
    echoes = trace(scene, PhaseShift(waves))
    plain = plain_echoes(scene)
    expected = phase_range(plain[:, 0], plain[:, 1], waves)
    assert echoes.distance[0] == pytest.approx(expected, abs=1e-6)
    for channel in (0, 1):
        energy = plain[:, 1 + channel].sum() * echoes.distance[0] ** 2
        assert echoes.energy[0, channel] == pytest.approx(energy, rel=1e-6)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("pick", ["first", "strongest", "last", "all"])
@pytest.mark.parametrize(("blend", "least"), [(0.25, 0.05), (0.05, 0.3), (2.0, 0.0)])
def test_pulsed_returns_are_those_of_the_plain_groups(scene, pick, blend, least):
    ranging = Pulsed(0.6, blend, pick, least, most=2)
    echoes = trace(scene, ranging)
    plain = plain_echoes(scene)
    expected = pulsed_ranges(plain[:, 0], plain[:, 1], ranging)
    found = list(zip(echoes.distance, echoes.energy[:, 0] / echoes.distance**2, strict=True))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_waveforms_and_their_returns_are_those_of_the_plain_sums(scene, noise):
    ranging = Pulsed(0.15, 0.15, "all", 0.02, waveform=Waveform(0.05, 160, noise))
    echoes = trace(scene, ranging, seed=5, keep=True)
    plain = plain_echoes(scene)
    near = plain[:, 0].min()
    drawn = np.random.default_rng((5, 0)).standard_normal((1, 2, 160), np.float32)[0, 0]
    weights = plain[:, 1] * near**2
    expected = pulsed_ranges(plain[:, 0], weights, ranging, drawn)
    reported = echoes.distance + echoes.wander[:, 0]
    found = list(zip(reported, echoes.received[:, 0] * (near / reported) ** 2, strict=True))
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    if noise == 0:
        assert not echoes.wander.any()
        np.testing.assert_array_equal(echoes.energy, echoes.received)
    waves = echoes.waveforms
    assert waves.samples.shape == (1, 2, 160)
    assert waves.start[0] == pytest.approx(near - 0.3, abs=1e-6)
    assert (waves.of_return == 0).all()


def test_components_are_listed_by_what_they_send_back():
    scene = steps([2.0, 3.5, 5.0, 9.0], [-0.6, -0.1, 0.4, 2], [0.5, 0.4, 0.6, 0.9])
    echoes = trace(scene, PhaseShift())
    plain = plain_echoes(scene)
    shares = {d: plain[plain[:, 0] == d, 3].sum() for d in (2.0, 3.5, 5.0, 9.0)}
    rho = {2.0: 0.5, 3.5: 0.4, 5.0: 0.6, 9.0: 0.9}
    ranked = sorted(shares.items(), key=lambda item: -item[1] * rho[item[0]] / item[0] ** 2)
    order = [(2.0, 3.5, 5.0, 9.0).index(distance) for distance, _ in ranked]
    np.testing.assert_array_equal(echoes.surface[0], order[:3])
    np.testing.assert_allclose(echoes.share[0], [share for _, share in ranked[:3]])
    assert echoes.touched[0] == 4
    assert echoes.shift[0] == pytest.approx(echoes.distance[0] - ranked[0][0], abs=1e-6)


def test_a_return_of_one_group_knows_only_its_own_surfaces():
    scene = steps([3.0, 3.1, 6.0], [-0.4, 0.2, 2], [0.5, 0.6, 0.6])
    echoes = trace(scene, Pulsed(0.6, 0.25, "all"))
    assert [set(row[row >= 0]) for row in echoes.surface] == [{0, 1}, {2}]
    assert 3.0 < echoes.distance[0] < 3.1
    # Between two surfaces of its own, but not far from either: no ghost by 6 mm of the last one.
    expected = min(echoes.distance[0] - 3.0, 3.1 - echoes.distance[0])
    assert echoes.off_surface[0] == pytest.approx(expected, abs=1e-6)
    assert echoes.off_surface[1] == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(echoes.normal, [[-1, 0, 0]] * 2, atol=1e-9)


def wall_by(name, rho, **changes):
    tool = replace(get_instrument(name), **changes)
    materials = tuple(matt(rho) for _ in tool.wavelengths_nm)
    wall = Wall((5.0, 0.0, 0.0), (0, 1.0, 0), (0, 0, 1.0), materials)
    scene = Scene("wall", walls=(wall,), wavelengths_nm=tool.wavelengths_nm)
    grid = BeamGrid(0.05, 0.05, 0.002, 50, 50)
    return grid, trace_beams(scene, grid, tool, HERE, 1)


@pytest.mark.parametrize("name", ["salca", "hsl"])
def test_noise_in_waveforms_is_no_part_of_the_truth(name):
    grid, echoes = wall_by(name, 0.05)
    exact = 5.0 / grid.directions_of(echoes.cell)[:, 0]
    assert np.abs(echoes.distance - exact).max() < 0.001
    assert (echoes.off_surface < 0.001).all()
    assert echoes.wander[:, 0].std() == pytest.approx(echoes.wander[:, 1].mean(), rel=0.2)
    spread = (echoes.received - echoes.energy).std(axis=0)
    own = get_instrument(name).ranging_channel
    assert spread[own] == pytest.approx(echoes.wander[:, 2].mean(), rel=0.1)
    assert np.delete(spread, own) == pytest.approx(echoes.wander[:, 3].mean(), rel=0.1)


def test_a_logarithmic_amplifier_adds_up_what_reaches_it():
    front, back = 2.0, 5.0
    tool = replace(get_instrument("ls880"), bundle=BUNDLE)
    width = BUNDLE.radius(front)
    walls = (
        Wall((front, 0.2 * width - 1.0, 0.0), (0, 1.0, 0), (0, 0, 1.0), (matt(0.4),)),
        Wall((back, 0.0, 0.0), (0, 2.0, 0), (0, 0, 2.0), (matt(0.6),)),
    )
    scene = Scene("two", walls=walls, wavelengths_nm=tool.wavelengths_nm)
    echoes = trace_beams(scene, ONE_BEAM, tool, HERE)
    effect = tool.detector.range_effect
    reach = [effect.strength(np.array([d]), 0)[0] for d in (front, back, echoes.distance[0])]
    first = echoes.share[0, list(echoes.surface[0]).index(0)]
    expected = (first * 0.4 * reach[0] + (1 - first) * 0.6 * reach[1]) / reach[2]
    assert echoes.energy[0, 0] == pytest.approx(expected, rel=1e-4)
