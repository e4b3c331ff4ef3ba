"""Boxes hold their surfaces, and the hierarchy finds what the plain loop finds."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.simulate.beam import Bundle, grid_of_field
from app.simulate.bounds import FEW, enclose, plant_tree, widen
from app.simulate.instrument import get_instrument
from app.simulate.scanner import trace_beams
from app.simulate.scene_building import build_scene, lay_grid
from app.simulate.scene_file import get_scene
from app.simulate.surfaces import Leaf, Scene
from app.simulate.tables import tabulate_surfaces


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6))
def test_a_leaf_lies_in_its_box(seed):
    random = np.random.default_rng(seed)
    leaf = Leaf(
        tuple(random.normal(size=3)),
        tuple(random.normal(size=3)),
        tuple(random.normal(size=3)),
        0.08,
        0.05,
        (),
        taper=0.3,
        curvature=float(random.uniform(-14, 14)),
        bend_direction=float(random.uniform(0, 6)),
        wrinkle_height=float(random.uniform(-0.003, 0.003)),
    )
    s, side = random.uniform(-1, 1, 400), random.uniform(-1, 1, 400)
    x, y = s * 0.04, side * 0.025 * (1 - 0.3 * s) * np.sqrt(1 - s**2)
    reach = x * np.cos(leaf.bend_direction) + y * np.sin(leaf.bend_direction)
    bend = (1 - np.sqrt(1 - (leaf.curvature * reach) ** 2)) / leaf.curvature
    waves = 2 * np.pi / 0.03
    z = bend + leaf.wrinkle_height * np.sin(waves * x) * np.sin(waves * y)
    points = np.stack([x, y, z], axis=1) @ leaf.frame() + leaf.centre
    low, high = enclose(Scene("leaf", (leaf,)))
    assert (points >= low[0] - 1e-12).all()
    assert (points <= high[0] + 1e-12).all()


@pytest.mark.parametrize("count", [0, 1, FEW, 50, 777])
def test_every_surface_is_in_one_node_and_every_node_in_its_parent(count):
    random = np.random.default_rng(count)
    low = random.uniform(-1, 1, (count, 3))
    high = low + random.uniform(0, 0.2, (count, 3))
    tree = plant_tree(low, high)
    members = [
        surface
        for first, many in zip(tree.first, tree.count, strict=True)
        for surface in tree.order[first : first + many]
    ]
    assert sorted(members) == list(range(count))
    assert tree.count.max(initial=0) <= max(FEW, 0)
    for node in np.flatnonzero((tree.count == 0) & (tree.first > 0)):
        for child in (tree.first[node], tree.first[node] + 1):
            assert (tree.low[node] <= tree.low[child]).all()
            assert (tree.high[node] >= tree.high[child]).all()


def test_widening_grows_with_the_distance_to_the_far_side():
    low, high = np.array([[1.0, 0, 0]]), np.array([[3.0, 0, 0]])
    wide = widen((low, high), Bundle(0.002, 0.001), np.zeros(3))
    np.testing.assert_allclose(low - wide[0], 0.001 + 3 * np.tan(0.001))
    np.testing.assert_allclose(wide[1] - high, 0.001 + 3 * np.tan(0.001))


@pytest.mark.parametrize("name", ["branch", "crown", "shoot", "leaf_frame", "panels"])
def test_the_hierarchy_changes_nothing(name):
    scene_file = get_scene(name)
    tool = replace(get_instrument("two_colour"), bundle=Bundle(rays=19))
    scene = build_scene(scene_file, tool.wavelengths_nm)
    grid = lay_grid(scene_file, scene, 0.6 if name == "crown" else 0.15)
    plain, clever = (
        trace_beams(scene, grid, tool, scene_file.position, hierarchy=choice)
        for choice in (False, True)
    )
    assert len(plain) > 20
    for field in ("cell", "distance", "surface", "share", "energy", "normal", "off_surface"):
        np.testing.assert_array_equal(getattr(plain, field), getattr(clever, field))


def test_a_swaying_leaf_stays_in_its_box_and_moves_with_the_columns():
    still = Leaf((2.0, 0.0, 0.0), (0, 0, 1), (-1, 0, 0), 0.08, 0.05, get_leaf(), 0.3)
    sways = replace(still, sway=(0.0, 0.01, 0.0), sway_rate=0.5, sway_phase=0.2)
    tool = replace(get_instrument("two_colour"), bundle=Bundle(0, 0, rays=1))
    grid = grid_of_field(0.02, (-1.5, 1.5), (-1.5, 1.5))
    echoes = trace_beams(Scene("wind", (sways,)), grid, tool, (0.0, 0.0, 0.0))
    column = echoes.cell % grid.columns
    points = echoes.distance[:, None] * grid.directions_of(echoes.cell)
    shift = 0.01 * np.sin(0.5 * column + 0.2)
    y, s = points[:, 1] - shift, points[:, 2] / 0.04
    assert (np.abs(y) <= 0.025 * (1 - 0.3 * s) * np.sqrt(1 - s**2) + 1e-9).all()
    assert np.ptp(shift[np.abs(s) < 0.2]) > 0.015
    assert len(tabulate_surfaces(Scene("wind", (sways,))).leaves.sway) == 1


def get_leaf():
    from app.simulate.material import matt

    return (matt(0.5), matt(0.3))
