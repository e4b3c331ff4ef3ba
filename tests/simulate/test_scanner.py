"""The tracer against closed forms and against a plain loop."""

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.simulate.beam import Bundle, grid_of_field
from app.simulate.branch import LEAF, MATT
from app.simulate.instrument import get_instrument
from app.simulate.material import matt
from app.simulate.ranging import phase_range
from app.simulate.receiver import Receiver
from app.simulate.scanner import trace_beams
from app.simulate.scenes import leaves_scan, plane_scan
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Leaf, Scene, Stem, Wall

SILENT = replace(get_instrument("two_colour"), receiver=Receiver())
THIN = replace(SILENT, bundle=Bundle(0.0, 0.0, rays=1))
BLACK = (matt(0.0), matt(0.0))
HERE = (0.0, 0.0, 0.0)


def with_bundle(bundle):
    return replace(SILENT, bundle=bundle)


def beckmann(omega, sheen):
    k_d, m = (dict(sheen.parameters)[name] for name in ("k_d", "m"))
    specular = np.exp(-(np.tan(omega) ** 2) / m**2) / np.cos(omega) ** 5
    return sheen.rho * (k_d * np.cos(omega) + (1 - k_d) * specular)


@pytest.mark.parametrize("degrees", [0, 10, 30, 45, 60, 70, 80])
def test_plane_at_every_angle(degrees):
    scan = plane_scan(degrees, distance=2.5, size=0.1, step_deg=0.05)
    omega = np.deg2rad(degrees)
    normal = np.array([-np.cos(omega), -np.sin(omega), 0.0])
    beams = scan.xyz / np.linalg.norm(scan.xyz, axis=1)[:, None]
    exact = 2.5 * normal[0] / (beams @ normal)
    incidence = np.arccos(np.abs(beams @ normal))
    full = scan.attributes["truth_hit_fraction"] > 0.9999
    assert full.sum() > 50
    np.testing.assert_allclose(scan.attributes["truth_range"][full], exact[full], atol=1e-4)
    found = scan.attributes["truth_incidence"][full]
    np.testing.assert_allclose(found, np.rad2deg(incidence[full]), atol=1e-4)
    for name, sheen in zip(("reflectance_1063", "reflectance_1545"), LEAF, strict=True):
        values = scan.channel_values(name)[full]
        np.testing.assert_allclose(values, beckmann(incidence[full], sheen), rtol=0.01)
    assert not (scan.attributes["truth_ghost"] == 1).any()


def test_matt_plane_follows_the_cosine():
    scan = plane_scan(55, step_deg=0.05, material=MATT)
    full = scan.attributes["truth_hit_fraction"] > 0.9999
    cosine = np.cos(np.deg2rad(scan.attributes["truth_incidence"][full]))
    np.testing.assert_allclose(scan.channel_values("reflectance_1063")[full], 0.6 * cosine, 1e-3)


def half_plane(edge):
    """A wall at 3 m, seen face-on, that ends at y = `edge`."""
    return Scene("edge", walls=(Wall((3.0, edge - 1.0, 0.0), (0, 1.0, 0), (0, 0, 1.0), MATT),))


@pytest.mark.parametrize("offset", [-0.6, -0.3, 0.02, 0.25, 0.55])
def test_share_of_a_beam_on_an_edge(offset):
    bundle = Bundle(rays=1261)
    grid = replace(grid_of_field(1.0, (-1, 1), (-1, 1)), top=0.0, left=0.0, rows=1, columns=1)
    edge = offset * bundle.radius(3.0)
    echoes = trace_beams(half_plane(edge), grid, with_bundle(bundle), HERE)
    x = np.linspace(-1, 1, 2001)
    x, y = np.meshgrid(x, x)
    energy = np.exp(-2 * (x**2 + y**2)) * (x**2 + y**2 <= 1)
    share = energy[x <= offset].sum() / energy.sum()
    assert echoes.share[0, 0] == pytest.approx(share, abs=0.01)
    assert echoes.energy[0, 0] == pytest.approx(0.6 * share, abs=0.01)


def test_beam_on_two_surfaces_reports_the_phase_of_both():
    front = half_plane(0.0).walls[0]
    back = Wall((3.2, 0.0, 0.0), (0, 2.0, 0), (0, 0, 2.0), MATT)
    grid = replace(grid_of_field(1.0, (-1, 1), (-1, 1)), top=0.0, left=0.0004, rows=1, columns=1)
    scene = Scene("two", walls=(front, back))
    echoes = trace_beams(scene, grid, with_bundle(Bundle(rays=217)), HERE)
    main = echoes.share[0, 0]
    assert echoes.share[0].sum() == pytest.approx(1)
    first = echoes.surface[0, 0] == 0
    energies = np.array([main, 1 - main]) if first else np.array([1 - main, main])
    expected = phase_range([3.0, 3.2], energies / np.array([3.0, 3.2]) ** 2)
    assert echoes.distance[0] == pytest.approx(expected, abs=1e-5)
    off = min(abs(echoes.distance[0] - 3.0), abs(echoes.distance[0] - 3.2))
    assert echoes.off_surface[0] == pytest.approx(off, abs=1e-5)
    assert echoes.off_surface[0] > 0.006


def test_nothing_comes_back_from_black_or_empty():
    grid = grid_of_field(0.5, (-2, 2), (-2, 2))
    wall = Wall((3.0, 0.0, 0.0), (0, 1.0, 0), (0, 0, 1.0), BLACK)
    for scene in (Scene("empty"), Scene("black", walls=(wall,))):
        scan = scan_scene(scene, grid, SILENT)
        assert len(scan) == 0
        assert len(scan.grid.no_return) == grid.rows * grid.columns


def curved_leaf(**shape):
    return Leaf((2.0, 0.01, -0.02), (0, 0.3, 1), (-1, 0.6, 0.4), 0.09, 0.06, LEAF, 0.3, **shape)


@pytest.mark.parametrize(
    "shape",
    [
        {"curvature": 12.0, "bend_direction": 0.4},
        {"curvature": -9.0},
        {"wrinkle_height": 0.002, "wrinkle_phases": (0.3, 1.0)},
        {"curvature": 4.0, "wrinkle_height": -0.0015, "wrinkle_lengths": (0.02, 0.035)},
    ],
)
def test_thin_beams_end_on_the_height_field(shape):
    leaf = curved_leaf(**shape)
    scan = scan_scene(Scene("leaf", (leaf,)), grid_of_field(0.1, (-3, 3), (-3, 3)), THIN)
    x, y, z = leaf.frame() @ (scan.xyz - leaf.centre).T

    def height(x, y):
        s = x * np.cos(leaf.bend_direction) + y * np.sin(leaf.bend_direction)
        c = leaf.curvature
        bend = (1 - np.sqrt(1 - (c * s) ** 2)) / c if c else 0 * s
        (lx, ly), (px, py) = leaf.wrinkle_lengths, leaf.wrinkle_phases
        wave = np.sin(2 * np.pi * x / lx + px) * np.sin(2 * np.pi * y / ly + py)
        return bend + leaf.wrinkle_height * wave

    assert len(scan) > 150
    np.testing.assert_allclose(z, height(x, y), atol=1e-8)
    step = 1e-6
    slope_x = (height(x + step, y) - height(x - step, y)) / (2 * step)
    slope_y = (height(x, y + step) - height(x, y - step)) / (2 * step)
    normal = np.stack([-slope_x, -slope_y, np.ones_like(x)])
    beam = leaf.frame() @ (scan.xyz / np.linalg.norm(scan.xyz, axis=1)[:, None]).T
    facing = np.abs((normal * beam).sum(axis=0)) / np.linalg.norm(normal, axis=0)
    expected = np.rad2deg(np.arccos(facing))
    np.testing.assert_allclose(scan.attributes["truth_incidence"], expected, atol=0.01)


def test_leaf_bent_beyond_its_length_is_refused():
    with pytest.raises(WrongUse, match="cannot be bent"):
        curved_leaf(curvature=25.0)


def test_stem_is_a_cylinder_with_round_ends():
    stem = Stem((2.0, -0.1, 0.0), (2.1, 0.1, 0.05), 0.02, MATT)
    scan = scan_scene(Scene("stem", stems=(stem,)), grid_of_field(0.1, (-6, 6), (-4, 4)), THIN)
    start, axis = np.array(stem.start), np.subtract(stem.end, stem.start)
    place = np.clip((scan.xyz - start) @ axis / (axis @ axis), 0, 1)
    away = np.linalg.norm(scan.xyz - start - place[:, None] * axis, axis=1)
    assert len(scan) > 500
    np.testing.assert_allclose(away, 0.02, atol=1e-9)
    assert (place == 0).any()
    assert (place == 1).any()


def flat_truth(leaves, beams, scanner):
    """Leaf of each thin beam by looking at every leaf."""
    best, owner = np.full(len(beams), np.inf), np.full(len(beams), -1)
    for index, leaf in enumerate(leaves):
        frame = leaf.frame()
        o, d = frame @ (np.array(scanner) - leaf.centre), beams @ frame.T
        t = -o[2] / d[:, 2]
        x, y = o[0] + t * d[:, 0], o[1] + t * d[:, 1]
        s = 2 * x / leaf.length
        inside = (np.abs(s) < 1) & (
            np.abs(y) <= leaf.width / 2 * (1 - leaf.taper * s) * np.sqrt(np.maximum(1 - s * s, 0))
        )
        nearer = inside & (t > 0) & (t < best)
        best[nearer], owner[nearer] = t[nearer], index
    return owner


@pytest.mark.parametrize("tall", [(-2.0, 2.0), (70.0, 89.0)])
def test_the_hierarchy_loses_no_leaf(tall):
    random = np.random.default_rng(4)
    grid = grid_of_field(0.1, (-3, 3), tall)
    beams = grid.directions.reshape(-1, 3)
    leaves = tuple(
        Leaf(
            tuple(random.uniform(1.0, 4.0) * beam),
            tuple(random.normal(size=3)),
            tuple(random.normal(size=3)),
            0.08,
            0.05,
            LEAF,
            0.3,
        )
        for beam in random.choice(beams, 40)
    )
    echoes = trace_beams(
        Scene("many", leaves),
        grid,
        replace(THIN, receiver=Receiver(threshold=0.0)),
        (0.0, 0.0, 0.0),
    )
    expected = flat_truth(leaves, beams, (0, 0, 0))
    assert (expected >= 0).sum() > 500
    found = np.full(len(beams), -1)
    found[echoes.cell] = echoes.surface[:, 0]
    np.testing.assert_array_equal(found, expected)


def test_noise_has_the_stated_size_and_grows_on_dark_surfaces():
    scan = plane_scan(0, noise_m=0.002, step_deg=0.05, intensity_noise=0.03)
    full = scan.attributes["truth_hit_fraction"] > 0.9999
    error = np.linalg.norm(scan.xyz, axis=1) - scan.attributes["truth_range"]
    assert error[full].std() == pytest.approx(0.002, rel=0.05)
    values = scan.channel_values("reflectance_1063")[full]
    assert values.std() / values.mean() == pytest.approx(0.03, rel=0.05)
    sigma = []
    for rho in (0.9, 0.1):
        wall = Wall((10.0, 0, 0), (0, 0.5, 0), (0, 0, 0.5), (matt(rho), matt(rho)))
        instrument = replace(SILENT, receiver=Receiver(0.0026))
        scan = scan_scene(
            Scene("wall", walls=(wall,)), grid_of_field(0.05, (-2, 2), (-2, 2)), instrument
        )
        error = np.linalg.norm(scan.xyz, axis=1) - scan.attributes["truth_range"]
        sigma.append(error.std())
    assert sigma == pytest.approx([0.0026, 0.0052], rel=0.05)


def test_same_seed_same_scan_other_seed_other_scan():
    first, again, other = (leaves_scan(seed, step_deg=0.1) for seed in (3, 3, 4))
    assert first.xyz.tobytes() == again.xyz.tobytes()
    assert all((first.attributes[k] == again.attributes[k]).all() for k in first.attributes)
    assert first.xyz.tobytes() != other.xyz.tobytes()
