"""Ghosts put back: on the right surface, along their beams, and only where that is sure."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.ghosts import SURE, Reason, correct_ghosts, explain_points, lay_out, score_ghosts

ORIGIN = np.zeros(3)


def test_ghosts_come_back_on_the_surface_that_owns_them(make_scene):
    scene = make_scene()
    ghosts = np.flatnonzero(scene.ghost)
    score = np.where(scene.ghost, 1.0, 0.0)
    found = correct_ghosts(scene.xyz, ORIGIN, ghosts, score, scene.grid)
    assert found.corrected.mean() > 0.4
    error = np.abs(np.linalg.norm(found.moved, axis=1) - scene.clean[ghosts])
    sure = found.corrected & (np.abs(scene.share[ghosts] - 0.5) > 0.1)
    assert np.mean(error[sure] < 0.005) > 0.95
    assert np.linalg.norm(np.cross(scene.xyz[ghosts], found.moved), axis=1).max() < 1e-9
    stays = ~found.corrected
    assert np.array_equal(found.moved[stays], scene.xyz[ghosts[stays]])


def test_without_rows_and_columns_nothing_is_moved(make_scene):
    scene = make_scene()
    ghosts = np.flatnonzero(scene.ghost)
    found = correct_ghosts(scene.xyz, ORIGIN, ghosts, np.zeros(len(scene.xyz)), sure=0.0)
    assert not found.corrected.any()
    assert np.array_equal(found.moved, scene.xyz[ghosts])
    assert (found.confidence == 0.0).all()


def test_surer_means_fewer_and_better(make_scene):
    scene = make_scene()
    ghosts = np.flatnonzero(scene.ghost)
    score = np.where(scene.ghost, 1.0, 0.0)
    few = correct_ghosts(scene.xyz, ORIGIN, ghosts, score, scene.grid, sure=0.95)
    many = correct_ghosts(scene.xyz, ORIGIN, ghosts, score, scene.grid, sure=0.0)
    assert not (few.corrected & ~many.corrected).any()
    assert few.corrected.sum() < many.corrected.sum()
    right = np.abs(many.ranges - scene.clean[ghosts]) < 0.0015
    assert right[few.corrected].mean() > right[many.corrected].mean()
    assert (few.confidence[few.corrected] >= 0.95).all()


def test_ghost_without_a_surface_stays(make_scene):
    scene = make_scene()
    scene.xyz[(scene.from_centre < 20) & (scene.from_centre > 0)] = np.nan
    lonely = np.flatnonzero(scene.from_centre == 0)
    nothing = np.flatnonzero(np.isnan(scene.xyz[:, 0]))[:1]
    asked = np.append(lonely, nothing)
    score = np.zeros(len(scene.xyz))
    for chosen in (scene.grid, None):
        found = correct_ghosts(scene.xyz, ORIGIN, asked, score, chosen)
        assert not found.corrected.any()
        assert (found.confidence < SURE).all()
        assert np.array_equal(found.moved[0], scene.xyz[lonely[0]])
    none = correct_ghosts(scene.xyz, ORIGIN, np.empty(0, np.int64), score, scene.grid)
    assert none.moved.shape == (0, 3)


def test_reasons_tell_both_surfaces_and_the_border(make_scene):
    scene = make_scene()
    image = lay_out(scene.xyz, ORIGIN, scene.grid)
    score = score_ghosts(scene.xyz, ORIGIN, None, scene.grid).score
    ghosts = np.flatnonzero(scene.ghost & (score > 0.5))
    light = np.log(np.where(scene.share > 0.5, 0.4, 0.1))
    found = explain_points(image, ghosts, score, light=light)
    between = found.reason == Reason.BETWEEN
    assert between.mean() > 0.8
    leaf = (scene.leaf - scene.own)[ghosts]
    wall = (scene.wall - scene.own)[ghosts]
    near = np.where(np.abs(leaf) < np.abs(wall), leaf, wall)
    assert np.median(np.abs(found.offset[between, 0] - near[between])) < 0.002
    assert (found.offset[between].prod(axis=1) < 0).all()
    on_leaf = scene.share[found.member[between, 0]] > 0.5
    assert np.mean(on_leaf == (np.abs(leaf) < np.abs(wall))[between]) > 0.95
    assert np.nanmax(np.abs(found.border)) < 3.0
    own_light = np.exp(light[ghosts])
    beside = np.exp(light[found.member[:, 0]])
    assert np.median(np.abs(found.light - own_light / beside)[between]) < 0.2


def test_points_on_a_surface_say_so(make_scene):
    scene = make_scene()
    image = lay_out(scene.xyz, ORIGIN, scene.grid)
    score = score_ghosts(scene.xyz, ORIGIN, None, scene.grid).score
    inside = np.flatnonzero(scene.from_centre < 20)
    found = explain_points(image, inside, score)
    assert (found.reason == Reason.ON_SURFACE).all()
    assert np.abs(found.offset[:, 0]).max() < 0.003
    assert found.light is None
    assert np.median(np.rad2deg(found.incidence)) == pytest.approx(np.rad2deg(0.6), abs=2.0)
