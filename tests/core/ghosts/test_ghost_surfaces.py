"""Surfaces carried on to a beam, against a plain weighted fit and against planes that are known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.footprint import BeamShape
from app.core.ghosts import lay_out
from app.core.ghosts.surfaces import GAP, find_surfaces, lay_ground, number_members
from app.core.kernels.ghost_surfaces import MEMBERS, STEEPEST, WIDEST

ORIGIN = np.zeros(3)
BEAM = BeamShape(0.0015, 2.5e-4)


def _fit_plainly(image, mixed, point):
    """The surface nearest in range by growing a sorted list, then weighted least squares."""
    own, row, column = image.own[point], image.cells.row[point], image.cells.column[point]
    step = own * np.sqrt(image.steps.down[column] * image.steps.across[row])
    blur = (BEAM.radius + own * np.tan(BEAM.half_divergence)) / step
    half = min(max(int(np.ceil(2.0 * blur)) + 3, 4), WIDEST)
    dy, dx = image.cells.row - row, image.cells.column - column
    near = (np.maximum(abs(dy), abs(dx)) <= half) & ~mixed & ((dy != 0) | (dx != 0))
    some = np.flatnonzero(near)
    some = some[np.argsort(image.own[some])]
    parts = np.split(some, np.flatnonzero(np.diff(image.own[some]) > GAP + STEEPEST * step) + 1)
    parts = [part for part in parts if len(part) >= MEMBERS]
    part = min(parts, key=lambda part: np.abs(image.own[part] - own).min())
    y, x = image.cells.row, image.cells.column
    bad = np.flatnonzero(mixed)
    away = np.maximum(abs(y[part, None] - y[bad]), abs(x[part, None] - x[bad]))
    depth = np.minimum(away.min(axis=1, initial=4), 4)
    fall = np.exp(-0.5 * (dy[part] ** 2 + dx[part] ** 2) / max(blur**2, 1.0))
    weight = (fall + 0.02) * 4.0**depth
    centred = np.column_stack([dy[part], dx[part]]) * 1.0
    middle, value = np.average(centred, axis=0, weights=weight), 1.0 / image.own[part]
    mean = np.average(value, weights=weight)
    share = weight / weight.sum()
    square = (share[:, None] * (centred - middle)).T @ (centred - middle) + 0.02 * np.eye(2)
    slope = np.linalg.solve(square, (share * (value - mean)) @ (centred - middle))
    return 1.0 / (mean - slope @ middle), len(part)


def test_nearest_surface_is_that_of_a_plain_fit(make_scene):
    scene = make_scene(noise=0.0008)
    image = lay_out(scene.xyz, ORIGIN, scene.grid)
    some = np.flatnonzero(scene.ghost)[::23]
    found = find_surfaces(lay_ground(image, scene.ghost), some, BEAM)
    plain = np.array([_fit_plainly(image, scene.ghost, point) for point in some])
    np.testing.assert_array_equal(found.beams[:, 0], plain[:, 1])
    np.testing.assert_allclose(found.distance[:, 0], plain[:, 0], atol=2e-5)


def test_planes_are_carried_on_exactly(make_scene):
    scene = make_scene(noise=0.0)
    image = lay_out(scene.xyz, ORIGIN, scene.grid)
    some = np.flatnonzero(scene.ghost)
    light = np.where(scene.share > 0.5, 3.0, 7.0)
    found = find_surfaces(lay_ground(image, scene.ghost, light), some, BEAM)
    for place, surface in ((scene.leaf, 3.0), (scene.wall, 7.0)):
        off = np.abs(found.distance[:, :2] - place[some, None])
        which = off.argmin(axis=1)
        each = np.arange(len(some))
        assert np.median(off[each, which]) < 3e-5  # metres
        # Few beams on one side: there the stiffness of the fit shows.
        assert off[each, which].max() < 5e-4
        np.testing.assert_allclose(found.light[each, which], surface, rtol=1e-6)
        assert found.scatter[each, which].max() < 5e-4  # sums are held as float32
    which = np.arange(len(some)), np.nanargmin(np.abs(found.distance - 2.0), axis=1)
    tangent = found.slope[which] * scene.own[some] / found.distance[which]
    assert np.median(tangent) == pytest.approx(np.tan(0.6), rel=0.03)


def test_a_surface_seen_by_later_returns_only_counts():
    """Leaves let part of every beam through: the wall is in the second layer alone."""
    side, step = 24, 4e-4
    row, column = (a.ravel() for a in np.mgrid[:side, :side])
    beams = np.stack([np.ones(len(row)), (column - 12) * step, (row - 12) * step], axis=1)
    beams /= np.linalg.norm(beams, axis=1)[:, None]
    first, second = 2.0 / beams[:, 0], 2.6 / beams[:, 0]
    middle = 12 * side + 12
    first[middle] = 2.35
    ranges = np.concatenate([second, first])  # the farther ones first, as some files have them
    grid = SimpleNamespace(rows=side, columns=side, row=np.tile(row, 2), column=np.tile(column, 2))
    xyz = np.tile(beams, (2, 1)) * ranges[:, None]
    image = lay_out(xyz, ORIGIN, grid)
    assert (image.layer[: side * side] == 1).all()
    ghost = side * side + middle
    mixed = np.arange(len(xyz)) == ghost
    found = find_surfaces(lay_ground(image, mixed), np.array([ghost]), BEAM)
    assert found.distance[0, :2] == pytest.approx([2.6, 2.0], abs=1e-5)
    members = number_members(image, np.array([ghost]), found)[0]
    assert members[0] < side * side <= members[1]
    assert members[2] == -1
    assert np.isnan(found.distance[0, 2])


def test_nothing_around_is_no_surface():
    row, column = (a.ravel() for a in np.mgrid[:20, :20])
    xyz = np.stack([np.full(400, 3.0), (column - 10) * 1e-3, (row - 10) * 1e-3], axis=1)
    grid = SimpleNamespace(rows=20, columns=20, row=row, column=column)
    image = lay_out(xyz, ORIGIN, grid)
    found = find_surfaces(lay_ground(image, np.ones(400, bool)), np.array([190, 210]), BEAM)
    assert np.isnan(found.distance).all()
    assert (found.beams == 0).all()
    assert (found.share == 0).all()
