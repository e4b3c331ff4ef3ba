"""A scene whose truth is known by construction."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

STEP = 3e-4
SIDE = 140


def _make_scene(tilt=0.6, noise=0.0005, seed=0):
    """A round leaf at 2 m before a wall at 2.5 m; beams on its border give ranges between."""
    row, column = (a.ravel() for a in np.mgrid[:SIDE, :SIDE])
    el, az = (row - 70) * STEP, (column - 70) * STEP
    beams = np.stack([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)], axis=1)
    wall = 2.5 / beams[:, 0]
    normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    leaf = 2.0 * np.cos(tilt) / (beams @ normal)
    from_centre = np.hypot(row - 70, column - 70)
    share = np.clip((42.0 - from_centre) / 3.0 + 0.5, 0.0, 1.0)
    clean = np.where(share > 0.5, leaf, wall)
    ghost = (share > 0.02) & (share < 0.98)
    rng = np.random.default_rng(seed)
    mixed = share * leaf + (1 - share) * wall + rng.normal(0, noise, len(row))
    grid = SimpleNamespace(rows=SIDE, columns=SIDE, row=row, column=column)
    return SimpleNamespace(
        xyz=beams * mixed[:, None], grid=grid, ghost=ghost, clean=clean, share=share,
        leaf=leaf, wall=wall, own=mixed, from_centre=from_centre,
    )  # fmt: skip


@pytest.fixture(scope="session")
def make_scene():
    """Builds the scene; a tilt of the leaf, noise of the range in metres, a seed."""
    return _make_scene
