"""Small scans as a scanner sees them, with and without rows and columns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from app.model.scan import Grid, Pose, Scan

SCANNER = np.array([1.0, -2.0, 0.5])
ROWS, COLUMNS = 12, 20
STEP = 0.5
"""Degrees."""


def aim(azimuth: np.ndarray, elevation: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Points in those directions (degrees), (n, 3)."""
    turn, rise = np.deg2rad(azimuth), np.deg2rad(elevation)
    beam = np.stack((np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)), 1)
    return SCANNER + beam * np.asarray(distance)[:, None]


def make_scan(
    swap: bool = False, upside_down: bool = False, mirrored: bool = False, middle: float = 170.0
) -> tuple[Scan, np.ndarray, np.ndarray]:
    """A scan with two points in some cells; its rows and columns as the scanner sees them."""
    chance = np.random.default_rng(3)
    cell = chance.permutation(ROWS * COLUMNS)[:200]
    cell = np.concatenate((cell, cell[:60]))
    row, column = np.divmod(cell, COLUMNS)
    azimuth = middle - STEP * (column - COLUMNS / 2)
    elevation = 10.0 - STEP * row
    xyz = aim(azimuth, elevation, chance.uniform(2.0, 9.0, len(cell)))
    xyz[5] = np.nan
    xyz[6] = SCANNER  # a point without a direction
    free = np.setdiff1d(np.arange(ROWS * COLUMNS), cell)[:15]
    down = np.where(upside_down, ROWS - 1 - row, row)
    across = np.where(mirrored, COLUMNS - 1 - column, column)
    silent = np.divmod(free, COLUMNS)
    silent_down = np.where(upside_down, ROWS - 1 - silent[0], silent[0])
    silent_across = np.where(mirrored, COLUMNS - 1 - silent[1], silent[1])
    if swap:
        grid = Grid(
            COLUMNS, ROWS, across.astype(np.int32), down.astype(np.int32),
            silent_across * ROWS + silent_down,
        )  # fmt: skip
    else:
        grid = Grid(
            ROWS, COLUMNS, down.astype(np.int32), across.astype(np.int32),
            silent_down * COLUMNS + silent_across,
        )  # fmt: skip
    return Scan("s", xyz, pose=Pose(tuple(SCANNER)), grid=grid), cell, free


@pytest.fixture
def build() -> Callable[..., tuple[Scan, np.ndarray, np.ndarray]]:
    return make_scan


@pytest.fixture
def point_at() -> Callable[..., np.ndarray]:
    return aim
