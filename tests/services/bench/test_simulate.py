"""The bench of the virtual scanner: its checks pass and can fail, its costs are measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import BadInput
from app.services.bench.simulate import costs, energy, plane, shapes
from app.services.bench.simulate.against_other import compare_measure, compare_with_other
from app.services.bench.simulate.distributions import count_borders, measure_widths, summarise
from app.services.bench.simulate.edge import cut_gaussian
from app.services.bench.simulate.hierarchy import count_differences
from app.services.bench.simulate.marks import Marks, measure_strongest, read_marks
from app.services.bench.simulate.other_scene import COLUMNS, ROWS, rebuild
from app.services.bench.simulate.rig import (
    beam_row,
    greys,
    half_wall,
    send,
    silent,
    split_at_edge,
    wall_at,
)
from app.services.bench.simulate.validation import CHECKS
from app.simulate.beam import Bundle
from app.simulate.material import matt
from app.simulate.surfaces import Scene


@pytest.mark.parametrize("name", CHECKS)
def test_the_virtual_scanner_passes_its_checks(name):
    found = CHECKS[name](True)
    assert found
    assert not [check for check in found if not check.passed]


def test_a_wrong_wall_is_noticed(monkeypatch):
    def dim_wall(distance, material):
        return wall_at(distance, tuple(matt(0.999 * sheen.rho) for sheen in material))

    monkeypatch.setattr(energy, "wall_at", dim_wall)
    bad = [check.what for check in energy.check_energy(True) if not check.passed]
    assert "a matt wall at 1 to 50 m returns its reflectance" in bad


def test_a_wrong_phase_function_is_noticed(monkeypatch):
    monkeypatch.setattr(
        plane, "_lambert", lambda omega: np.outer(np.cos(omega) ** 1.01, [0.6, 0.4])
    )
    bad = [check.what for check in plane.check_plane(True) if not check.passed]
    assert any("Lambertian" in what and "intensity" in what for what in bad)


def test_a_wrong_height_is_noticed(monkeypatch):
    flat = shapes.LocalSurface.height
    monkeypatch.setattr(shapes.LocalSurface, "height", lambda *at: flat(*at) + 1e-5)
    assert not all(check.passed for check in shapes.check_shapes(True))


def test_one_bit_is_a_difference():
    echoes = send([half_wall(2.0, greys(0.5, 0.3))], silent())
    assert count_differences(echoes, echoes) == 0
    moved = replace(echoes, distance=np.nextafter(echoes.distance, 9))
    assert count_differences(echoes, moved) == 1
    assert count_differences(echoes, echoes.take(np.arange(0))) == np.inf


def test_a_cut_gaussian_runs_from_none_to_all():
    share = cut_gaussian(np.array([-1.5, -1.0, 0.0, 1.0, 2.0]))
    np.testing.assert_allclose(share, [0, 0, 0.5, 1, 1], atol=1e-6)
    assert np.diff(cut_gaussian(np.linspace(-1, 1, 50))).min() > 0


def test_quick_costs_have_every_curve():
    compiling = costs.warm_up()
    table = costs.measure_costs(compiling, quick=True)
    curves = {row["curve"] for row in table.rows}
    assert {"sub-rays", "leaves", "step, °"} <= curves
    assert all(row["beams per second"] > 0 for row in table.rows)
    plain = [row["plain loop, µs per beam"] for row in table.rows if row["curve"] == "leaves"]
    assert np.isfinite(plain).all()
    first, second = costs.draw_costs(table)
    assert len(first.curves) == 2
    assert list(second.curves[0].x) == [1, 7, 19, 37, 61, 91]


def test_rebuilt_scenes_are_drawn_alike():
    ranges = np.linspace(1.6, 4.5, 70)
    (one, kinds), (again, _) = (rebuild("phase_shift", ranges, 3) for _ in range(2))
    assert one == again
    assert one != rebuild("phase_shift", ranges, 4)[0]
    away = np.sort([np.linalg.norm(leaf.centre) for leaf in one.leaves])
    np.testing.assert_allclose(away, ranges)
    for leaf, kind in zip(one.leaves, kinds, strict=True):
        assert (leaf.curvature == 0) == (kind == 0)
        assert (leaf.wrinkle_height > 0) == (kind == 2)


def toy_marks():
    """Two leaves of 40 × 40 cells before a wall, the first with a rim of two split cells."""
    leaf = np.full((ROWS, COLUMNS), -1)
    leaf[100:140, 100:140], leaf[300:340, 300:340] = 0, 1
    part = np.ones((ROWS, COLUMNS))
    part[100:140, 138:140] = 0.7
    ghost = part < 1
    zero = np.zeros(ROWS * COLUMNS)
    return Marks(
        np.arange(ROWS * COLUMNS),
        leaf.ravel(),
        np.where(leaf >= 0, 0, -1).ravel(),
        ghost.ravel(),
        zero > 1,
        zero + 0.01 * ghost.ravel(),
        zero + 2.0,
        zero + 4.0,
        zero - 0.01 * ghost.ravel(),
        part.ravel(),
        zero,
        np.full((ROWS * COLUMNS, 2), 0.3),
    )


def test_distributions_of_a_scan_made_by_hand():
    marks = toy_marks()
    assert count_borders(marks.image()) == 2 * 4 * 40
    found = summarise(marks)
    assert found["split beams per cell of border"] == pytest.approx(80 / 320)
    assert found["ghosts per split beam"] == 1
    assert found["ghost to its nearest surface, 50% quantile, m"] == pytest.approx(0.01)
    assert found["ghost off its strongest surface, 75% quantile, m"] == pytest.approx(0.01)
    assert found["ρ at 1545 nm from flat"] == pytest.approx(0.3)
    widths = measure_widths(marks)
    diameter = 2 * Bundle().radius(2.0)
    assert len(widths) == 8 * 40 - 4
    assert widths.max() == pytest.approx(2 * 2.0 * np.deg2rad(0.018) / diameter)
    assert (widths > 0).sum() == 40


def test_the_strongest_surface_is_the_one_that_sends_most():
    walls = [half_wall(2.0, greys(0.1, 0.1)), wall_at(2.5, greys(0.5, 0.5))]
    grid, tool = beam_row(41, 4e-5), silent()
    scene = Scene("two walls", walls=tuple(walls))
    echoes = send(walls, tool, grid)
    front, distance, facing = split_at_edge(grid, tool.bundle, 2.0, 2.5)
    energy = tool.bundle.subrays()[:, 2] * np.where(front, 0.1, 0.5) * facing / distance**2
    part = (energy * front).sum(axis=1) / energy.sum(axis=1)
    found = measure_strongest(scene, echoes, tool.ranging_channel)
    np.testing.assert_allclose(found, np.maximum(part, 1 - part), atol=2e-5)
    np.testing.assert_array_equal(echoes.surface[:, 0] == 0, part > 0.5)


def test_verdicts_allow_for_the_spread_of_scenes():
    near, far = np.array([1.0, 1.01, 0.99]), np.array([1.0, 2.0, 0.1])
    assert compare_measure("s", "m", 1.04, near)["verdict"] == "agrees"
    assert compare_measure("s", "m", 1.5, near)["verdict"] == "DIFFERS"
    assert compare_measure("s", "m", 1.5, far)["verdict"] == "too spread"
    spread = np.array([1.0, 1.05, 0.95])
    assert compare_measure("s", "m", 1.1, spread)["verdict"] == "agrees"
    assert compare_measure("s", "m", np.nan, near)["verdict"] == "too few points"


def test_a_folder_without_scans_is_refused(tmp_path):
    with pytest.raises(BadInput, match="cannot be read"):
        read_marks(tmp_path, "pulsed")


CLOSE = {
    "ghosts per split beam": 0.1,
    "split beams per cell of border": 0.1,
    "ghost to its nearest surface, 50% quantile, m": 0.12,
    "part of the strongest surface, ghosts, 50% quantile": 0.03,
    "part of the strongest surface, split beams, 50% quantile": 0.02,
    "border width, 50% quantile, beam diameters": 0.05,
    "ρ at 1063 nm from all leaves, 30–45°": 0.06,
    "ρ at 1545 nm from all leaves, 30–45°": 0.06,
    "ρ at 1545 nm from the wall": 0.001,
}
"""Measures that scenes drawn alike share, and how near the mean of two must be to one."""


@pytest.mark.data
def test_another_simulator_agrees(shared_data):
    folder = shared_data / "truth_scenes"
    if not folder.is_dir():
        pytest.skip(f"the other simulator's scans are not here: {folder}")
    rows = compare_with_other(folder, seeds=2).rows
    for scene in ("phase_shift", "pulsed"):
        away = {r["measure"]: r["difference"] for r in rows if r["scene"] == scene}
        far = {name: away[name] for name, most in CLOSE.items() if not abs(away[name]) <= most}
        assert not far, scene
