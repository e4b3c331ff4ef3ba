"""The choice of neighbours and its reason."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from app.core.neighbours.choice import choose_neighbours


def make_scan(rows=1060, columns=30):
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    rise, turn = 0.3 - np.deg2rad(0.02) * row, -np.deg2rad(0.05) * column
    beams = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], 1)
    return 2.0 * beams


def test_given_grid_is_taken_as_it_is():
    grid = SimpleNamespace(rows=1, columns=1, row=np.zeros(3, int), column=np.zeros(3, int))
    chosen = choose_neighbours(np.zeros((3, 3)), np.zeros(3), grid)
    assert (chosen.grid, chosen.method) == (grid, "scan grid")
    assert chosen.reason == "rows and columns are in the file"


def test_recovered_grid_tells_its_steps():
    chosen = choose_neighbours(make_scan(), [0.0, 0.0, 0.0], None)
    assert chosen.method == "recovered grid"
    assert chosen.reason.endswith(": 0.02° × 0.05°, 1 060 × 30 cells")


def test_refusal_becomes_the_reason():
    cloud = np.random.default_rng(0).normal(size=(20_000, 3))
    chosen = choose_neighbours(cloud, np.zeros(3), None)
    assert (chosen.grid, chosen.method) == (None, "voxel hash")
    assert "do not lie on rows and columns" in chosen.reason


def test_unknown_scanner():
    chosen = choose_neighbours(make_scan(), None, None)
    assert (chosen.grid, chosen.reason) == (None, "the scanner's position is unknown")
