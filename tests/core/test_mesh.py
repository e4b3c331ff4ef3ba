"""Meshes and areas of leaves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.mesh import WHOLE, estimate_beam, estimate_hidden, lay_out, mesh_leaf
from app.core.neighbours.steps import Cells, UnusableGrid

ORIGIN = np.zeros(3)
STEP, SIDE = 4e-4, 100


def scan_ellipse(tilt=0.3, noise=0.0, behind=3.0, radius=(0.022, 0.015), seed=1):
    """An ellipse on a plane at 2 m before a wall, by point beams; its area, and the parts."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:SIDE, :SIDE])
    side, up = (SIDE / 2 - column) * STEP, (SIDE / 2 - row) * STEP
    beams = np.stack([np.ones(len(row)), side, up], axis=1)
    normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    depth = 2.0 * normal[0] / (beams @ normal)
    places = beams * depth[:, None] - [2.0, 0.0, 0.0]
    along = places @ [-np.sin(tilt), np.cos(tilt), 0.0]
    on = (along / radius[0]) ** 2 + (places[:, 2] / radius[1]) ** 2 < 1.0
    ranges = np.where(on, depth, behind)
    ranges = ranges + noise * np.random.default_rng(seed).standard_normal(len(row))
    area = np.pi * radius[0] * radius[1]
    return beams * ranges[:, None], Cells(SIDE, SIDE, row, column), on, area


@given(tilt=st.floats(-1.0, 1.0))
def test_area_of_an_ellipse(tilt):
    xyz, cells, on, area = scan_ellipse(tilt)
    found = mesh_leaf(lay_out(xyz, ORIGIN, cells), np.flatnonzero(on), beam=(0.0, 0.0))
    assert found.area.value == pytest.approx(area, rel=0.02)
    assert found.area.low < found.area.value < found.area.high
    assert found.area.whole


@pytest.mark.parametrize("noise", [0.0007, 0.002])
def test_noise_does_not_inflate_the_area(noise):
    xyz, cells, on, area = scan_ellipse(0.6, noise)
    found = mesh_leaf(lay_out(xyz, ORIGIN, cells), np.flatnonzero(on), beam=(0.0, 0.0))
    assert found.area.value == pytest.approx(area, rel=0.03)
    assert found.sigma == pytest.approx(noise, rel=0.25)


def test_faces_lie_on_the_leaf_and_face_the_scanner():
    xyz, cells, on, _ = scan_ellipse(0.5)
    mesh = mesh_leaf(lay_out(xyz, ORIGIN, cells), np.flatnonzero(on))
    normal = np.array([np.cos(0.5), np.sin(0.5), 0.0])
    assert np.abs((mesh.vertices - [2.0, 0.0, 0.0]) @ normal).max() < 1e-9
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", across, -corners.mean(axis=1)) > 0).all()
    assert 0.5 * np.linalg.norm(across, axis=1).sum() == pytest.approx(mesh.area.value)
    assert np.degrees(np.median(mesh.omega)) == pytest.approx(np.degrees(0.5), abs=0.5)


def test_small_holes_are_filled():
    xyz, cells, on, _ = scan_ellipse()
    members = np.flatnonzero(on)
    whole = mesh_leaf(lay_out(xyz, ORIGIN, cells), members).area.value
    lost = xyz.copy()
    lost[members[[len(members) // 2, len(members) // 3]]] = np.nan
    assert mesh_leaf(lay_out(lost, ORIGIN, cells), members).area.value == pytest.approx(whole)


def test_ghosts_around_a_leaf_are_shared():
    """Points between leaf and wall, three cells wide, half of them on the leaf."""
    from scipy.ndimage import binary_dilation, binary_erosion

    xyz, cells, on, area = scan_ellipse(0.0, behind=2.2)
    inside = on.reshape(SIDE, SIDE)
    ghosts = binary_dilation(inside, iterations=2) & ~binary_erosion(inside, iterations=2)
    kept = np.flatnonzero(on & ~ghosts.ravel())
    beam = (2 * STEP * 2.0, 0.0)
    found = mesh_leaf(lay_out(xyz, ORIGIN, cells), kept, ghosts.ravel(), beam)
    assert found.area.value == pytest.approx(area, rel=0.05)
    cut = mesh_leaf(lay_out(xyz, ORIGIN, cells), kept, None, (0.0, 0.0))
    assert cut.area.value < 0.85 * area


def test_partly_hidden_leaf_is_a_lower_bound():
    xyz, cells, on, area = scan_ellipse()
    front = cells.column > SIDE // 2
    xyz[front] *= 1.5 / np.linalg.norm(xyz[front], axis=1)[:, None]
    found = mesh_leaf(lay_out(xyz, ORIGIN, cells), np.flatnonzero(on & ~front)).area
    assert not found.whole
    assert 0.15 < found.hidden < 0.6
    assert found.value < 0.7 * area


def test_order_and_copies_change_nothing():
    xyz, cells, on, _ = scan_ellipse(0.4, 0.0007)
    usual = mesh_leaf(lay_out(xyz, ORIGIN, cells), np.flatnonzero(on)).area.value
    order = np.random.default_rng(2).permutation(len(xyz))
    shuffled = Cells(SIDE, SIDE, cells.row[order], cells.column[order])
    found = mesh_leaf(lay_out(xyz[order], ORIGIN, shuffled), np.flatnonzero(on[order]))
    assert found.area.value == pytest.approx(usual, rel=1e-9)


def test_refusals():
    xyz, cells, on, _ = scan_ellipse()
    layout = lay_out(xyz, ORIGIN, cells)
    with pytest.raises(BadInput, match="has no surface"):
        mesh_leaf(layout, np.flatnonzero(on)[:3])
    row = lay_out(xyz[:40], ORIGIN, Cells(SIDE, SIDE, cells.row[:40], cells.column[:40]))
    with pytest.raises(BadInput, match="one row or column"):
        mesh_leaf(row, np.arange(40))
    with pytest.raises(BadInput, match="all the same way"):
        mesh_leaf(lay_out(np.ones_like(xyz), ORIGIN, cells), np.flatnonzero(on))
    with pytest.raises(BadInput, match="outside the grid"):
        lay_out(xyz, ORIGIN, Cells(SIDE, SIDE, cells.row + SIDE, cells.column))
    mixed = np.random.default_rng(3).permutation(len(xyz))
    with pytest.raises(UnusableGrid):
        mesh_leaf(lay_out(xyz[mixed], ORIGIN, cells), np.flatnonzero(on))


def test_beam_is_estimated_or_not():
    xyz, cells, on, _ = scan_ellipse()
    assert estimate_beam(lay_out(xyz, ORIGIN, cells), [np.flatnonzero(on)]) is None


def test_a_wide_beam_of_a_fine_scan_keeps_all_its_ghosts():
    """Ghosts reach over many cells on either side of the border; all of them are of the border."""
    from scipy.ndimage import distance_transform_edt

    xyz, cells, on, area = scan_ellipse(0.0, behind=2.02)
    inside = on.reshape(SIDE, SIDE)
    cell = STEP * 2.0
    depth = cell * (distance_transform_edt(inside) + distance_transform_edt(~inside) - 0.5)
    ghosts = (depth < 5.0 * cell).ravel()
    kept = np.flatnonzero(on & ~ghosts)
    found = mesh_leaf(lay_out(xyz, ORIGIN, cells), kept, ghosts, (5.0 * cell, 0.0))
    assert found.area.value == pytest.approx(area, rel=0.04)


def test_noise_that_neighbours_share_roughens_no_flat_leaf():
    """A filter of 3 × 3 in the scanner: neighbours predict one another, wrong as they are."""
    from scipy.ndimage import uniform_filter

    xyz, cells, on, area = scan_ellipse(0.5)
    noise = 3.0 * uniform_filter(np.random.default_rng(5).standard_normal((SIDE, SIDE)), 3)
    ranges = np.linalg.norm(xyz, axis=1)
    xyz = xyz * (1.0 + 0.0008 * noise.ravel() / ranges)[:, None]
    found = mesh_leaf(lay_out(xyz, ORIGIN, cells), np.flatnonzero(on), beam=(0.0, 0.0))
    assert found.area.value == pytest.approx(area, rel=0.02)
    assert found.width > 4.0


@pytest.mark.parametrize("scaled", [False, True])
def test_light_of_mixed_ranges_counts_only_where_it_was_measured(scaled):
    """A reflectance is made with a range; that of a beam on leaf and wall is anything."""
    from scipy.ndimage import binary_dilation, binary_erosion, gaussian_filter

    xyz, cells, on, _ = scan_ellipse(0.0, behind=3.0)
    inside = on.reshape(SIDE, SIDE)
    share = gaussian_filter(inside.astype(float), 2.0).ravel()
    ghosts = (binary_dilation(inside, iterations=4) & ~binary_erosion(inside, iterations=4)).ravel()
    # The light of the ghosts is told three times too large.
    echo = (share + 0.1 * (1.0 - share)) * np.where(ghosts, 3.0, 1.0)
    mixed = 2.0 * share + 3.0 * (1.0 - share)
    xyz[ghosts] *= (mixed / np.linalg.norm(xyz, axis=1))[ghosts, None]
    layout = lay_out(xyz, ORIGIN, cells, echo=echo, scaled=scaled)
    kept = np.flatnonzero(on & ~ghosts)
    found = mesh_leaf(layout, kept, ghosts, (4.0 * STEP * 2.0, 0.0)).area.value
    plain = mesh_leaf(lay_out(xyz, ORIGIN, cells), kept, ghosts, (4.0 * STEP * 2.0, 0.0)).area.value
    if scaled:
        assert found == pytest.approx(plain, rel=0.08)
    else:
        assert found > 1.1 * plain


@given(angle=st.floats(0.01, 3.0))
def test_what_a_chord_hides_of_a_circle(angle):
    chord, left = 2.0 * np.sin(angle / 2.0), 2.0 * np.pi - angle
    cut = 0.5 * (angle - np.sin(angle))
    share = chord / (left + chord)
    assert estimate_hidden(share) == pytest.approx(cut / (np.pi - cut), rel=0.02, abs=1e-4)


def test_a_short_hidden_border_widens_the_interval_upwards_only():
    xyz, cells, on, _ = scan_ellipse(0.0)
    corner = (cells.column > 74) & on
    front = xyz.copy()
    front[corner] *= 1.5 / np.linalg.norm(xyz[corner], axis=1)[:, None]
    found = mesh_leaf(lay_out(front, ORIGIN, cells), np.flatnonzero(on & ~corner)).area
    assert 0.0 < found.hidden < WHOLE
    assert found.whole
    assert found.high - found.value > found.value - found.low
