"""Truth per leaf against closed forms and against a plain sum."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.simulate.branch import BARK, LEAF, TILTS, build_branch
from app.simulate.leaf_table import measure_areas, name_kind, tabulate_leaves
from app.simulate.surfaces import Leaf, Scene, Stem, Wall

EGG = Leaf((2.0, 0.0, 0.0), (0, 0, -1), (-1, 0, 0), 0.08, 0.05, LEAF, 0.3)


def area(leaf):
    return measure_areas([leaf])[0]


@given(st.floats(0.01, 2), st.floats(0.01, 2), st.floats(-0.9, 0.9))
def test_flat_leaf_has_the_area_of_its_ellipse(length, width, taper):
    leaf = replace(EGG, length=length, width=width, taper=taper)
    assert area(leaf) == pytest.approx(np.pi * length * width / 4, rel=1e-6)


@given(st.integers(1, 12), st.floats(0, 0.9))
def test_lobed_leaf_has_the_area_of_its_cosine(lobes, depth):
    leaf = replace(EGG, taper=0.0, lobes=lobes, lobe_depth=depth)
    share = 1 - depth + 3 * depth**2 / 8
    assert area(leaf) == pytest.approx(np.pi * 0.08 * 0.05 / 4 * share, rel=1e-6)


@settings(max_examples=30)
@given(st.floats(-18, 18), st.sampled_from([0.0, np.pi / 2]))
def test_bent_leaf_has_the_area_of_its_cylinder(curvature, direction):
    leaf = replace(EGG, taper=0.0, curvature=curvature, bend_direction=direction)
    bent, level = (0.04, 0.025) if direction == 0.0 else (0.025, 0.04)
    # Unrolled, the cylinder is a plane: chords over the arc, ∫ 2 b √(1 − (x/a)²) ds.
    phi = np.linspace(-np.pi / 2, np.pi / 2, 20001)
    arc = 1 / np.sqrt(1 - (curvature * bent * np.sin(phi)) ** 2)
    exact = np.trapezoid(2 * level * np.cos(phi) ** 2 * bent * arc, phi)
    assert area(leaf) == pytest.approx(exact, rel=1e-6)


def sum_of_facets(leaf, count=1500):
    """Area by small squares of the local plane, with slopes by differences."""
    half = leaf.length / 2
    edge = (np.arange(count) + 0.5) / count * 2 - 1
    x, y = np.meshgrid(edge * half, edge * leaf.width)
    angle = np.arctan2(y / (leaf.width / 2), x / half)
    f = 1 - leaf.lobe_depth * (1 - np.cos(leaf.lobes * angle)) / 2
    s = x / f / half
    inside = (np.abs(s) < 1) & (
        np.abs(y / f) < leaf.width / 2 * (1 - leaf.taper * s) * np.sqrt(np.maximum(1 - s * s, 0))
    )

    def height(x, y):
        c = leaf.curvature
        u = x * np.cos(leaf.bend_direction) + y * np.sin(leaf.bend_direction)
        root = np.sqrt(np.maximum(1 - (c * u) ** 2, 0))
        (lx, ly), (px, py) = leaf.wrinkle_lengths, leaf.wrinkle_phases
        wave = np.sin(2 * np.pi * x / lx + px) * np.sin(2 * np.pi * y / ly + py)
        return ((1 - root) / c if c else 0) + leaf.wrinkle_height * wave

    step = 1e-6
    hx = (height(x + step, y) - height(x - step, y)) / (2 * step)
    hy = (height(x, y + step) - height(x, y - step)) / (2 * step)
    cell = (2 * half / count) * (2 * leaf.width / count)
    return (np.sqrt(1 + hx**2 + hy**2) * inside).sum() * cell


@pytest.mark.parametrize(
    "shape",
    [
        {"wrinkle_height": 0.002, "wrinkle_phases": (0.3, 1.0)},
        {"wrinkle_height": 0.001, "wrinkle_lengths": (0.007, 0.012)},
        {"wrinkle_height": -0.0015, "curvature": 9.0, "bend_direction": 0.4},
        {"lobes": 5, "lobe_depth": 0.6, "taper": 0.4, "curvature": -14.0},
        {"lobes": 3, "lobe_depth": 0.4, "wrinkle_height": 0.003, "taper": -0.5},
    ],
)
def test_shaped_leaves_agree_with_a_plain_sum(shape):
    leaf = replace(EGG, **shape)
    assert area(leaf) == pytest.approx(sum_of_facets(leaf), rel=3e-4)


def test_one_leaf_is_measured_alike_among_others():
    leaves = build_branch(1).leaves
    together = measure_areas(leaves * 8)
    np.testing.assert_allclose(together[: len(leaves)], [area(leaf) for leaf in leaves], rtol=1e-4)
    assert measure_areas(()).shape == (0,)


def test_table_of_the_demo_tells_its_row():
    scene = build_branch(1)
    rows = tabulate_leaves(scene, (0.0, 0.0, 1.6))
    assert [row.number for row in rows] == list(range(25))
    assert [row.tilt_deg for row in rows[:6]] == pytest.approx(TILTS, abs=1e-6)
    assert [row.kind for row in rows[6:9]] == ["flat", "bent", "wrinkled"]
    assert rows[0].rho == (0.48, 0.27)
    for row, leaf in zip(rows, scene.leaves, strict=True):
        assert row.area >= np.pi * leaf.length * leaf.width / 4 * (1 - 1e-9)
        back = np.array([0, 0, 1.6]) - row.centre
        assert np.dot(row.normal, back) >= 0
        assert row.water == leaf.water


def test_needle_is_half_a_capsule_and_faces_its_beam():
    needle = Stem((3, 0, -0.02), (3, 0, 0.02), 0.001, BARK, label=1)
    plane = Wall((3, 0, 0), (0, 0.1, 0), (0, 0, 0.2), BARK, label=0)
    twig = Stem((3, 0, 0), (3, 1, 0), 0.01, BARK)
    flat, found = tabulate_leaves(Scene("needles", (), (needle, twig), (plane,)), (0, 0, 3))
    assert (flat.number, flat.kind, flat.area) == (0, "flat", pytest.approx(0.08))
    assert found.kind == "needle"
    assert found.area == pytest.approx(np.pi * 0.001 * 0.04 + 2 * np.pi * 0.001**2)
    assert (found.length, found.width) == pytest.approx((0.042, 0.002))
    np.testing.assert_allclose(found.normal, (-1, 0, 0), atol=1e-12)
    assert found.tilt_deg == pytest.approx(45)


def test_kinds_by_what_shapes_a_leaf_most():
    assert name_kind(EGG) == "flat"
    assert name_kind(replace(EGG, curvature=1.0)) == "bent"
    assert name_kind(replace(EGG, curvature=1.0, wrinkle_height=0.001)) == "wrinkled"
    assert name_kind(replace(EGG, wrinkle_height=0.001, lobes=3, lobe_depth=0.2)) == "lobed"


def spread_evenly(leaf, count=3000):
    """Area of a wavy leaf on a raster of squares, slopes in closed form."""
    edge = (np.arange(count) + 0.5) / count * 2 - 1
    s, y = np.meshgrid(edge, edge * leaf.width)
    x = s * leaf.length / 2
    inside = np.abs(y) < leaf.width / 2 * (1 - leaf.taper * s) * np.sqrt(1 - s * s)
    (kx, ky), (px, py) = 2 * np.pi / np.array(leaf.wrinkle_lengths), leaf.wrinkle_phases
    hx = leaf.wrinkle_height * kx * np.cos(kx * x + px) * np.sin(ky * y + py)
    hy = leaf.wrinkle_height * ky * np.sin(kx * x + px) * np.cos(ky * y + py)
    area = (np.sqrt(1 + hx**2 + hy**2) * inside).sum()
    return area * (leaf.length / count) * (2 * leaf.width / count)


@pytest.mark.parametrize("slope", [0.6, 1.5, 3.0])
@pytest.mark.parametrize("lengths", [(0.005, 0.005), (0.005, 10.0), (0.0051, 0.007)])
def test_fine_steep_wrinkles_are_measured_to_a_ten_thousandth(slope, lengths):
    height = slope * min(lengths) / (2 * np.pi) * (1 - 1e-12)
    leaf = replace(EGG, wrinkle_height=height, wrinkle_lengths=lengths, wrinkle_phases=(0.3, 1.0))
    assert area(leaf) == pytest.approx(spread_evenly(leaf), rel=1e-4)


def test_many_finely_wrinkled_leaves_are_measured_in_parts():
    leaf = replace(EGG, wrinkle_height=0.002, wrinkle_lengths=(0.005, 0.006))
    found = measure_areas([replace(leaf, length=0.08 + k / 1e4) for k in range(60)])
    assert found.shape == (60,)
    assert found[0] == pytest.approx(area(leaf), rel=1e-4)
    assert found[-1] / found[0] == pytest.approx(0.0859 / 0.08, rel=5e-3)
