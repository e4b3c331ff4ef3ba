"""Scans made on the spot: the demo, and small ones with exact truth to try things on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.model.scan import Scan, Vector
from app.simulate.beam import BeamGrid, angles_of, grid_of_field
from app.simulate.branch import (
    LEAF,
    MATT,
    SCANNER,
    TILTS,
    build_branch,
    tilted_row,
    water_leaf,
)
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.large import large_scan
from app.simulate.leaf_shapes import IN_TURN, shape_leaf, tilted_normal, vector
from app.simulate.material import Material
from app.simulate.receiver import Receiver
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Leaf, Scene, Wall

__all__ = ["demo_scan", "large_scan", "leaf_row_scan", "leaves_scan", "plane_scan"]

STEP_DEG = 0.018
NOISY = Receiver(range_noise=0.0007, intensity_noise=0.03)
"""With the filtered range noise of a FARO LS880."""


def demo_scan(seed: int = 1, step_deg: float | None = None) -> Scan:
    """A branch of pear-like leaves, with a row of leaves at known tilts, before a wall.

    Leaves 0 to 5 are flat and tilted by 0, 15 … 75°; 6 to 24 hang on the branch, flat, bent and
    wrinkled in turn.

    Parameters
    ----------
    seed : int
    step_deg : float, optional
        Step of the scanner, degrees; 0.018 when left out (about 420 000 points).
    """
    step = STEP_DEG if step_deg is None else step_deg
    grid = grid_of_field(step, (-6.9, 7.7), (-5.1, 5.0))
    scan = scan_scene(build_branch(seed), grid, _two_colour(NOISY), SCANNER, seed)
    row = ", ".join(f"{tilt:.0f}" for tilt in TILTS)
    return replace(scan, metadata=dict(scan.metadata) | {"tilts of leaves 0 to 5, degrees": row})


def plane_scan(
    incidence_deg: float,
    distance: float = 3.0,
    size: float = 0.2,
    step_deg: float = 0.02,
    noise_m: float = 0.0,
    seed: int = 0,
    intensity_noise: float = 0.0,
    material: Material = LEAF,
) -> Scan:
    """One square plane with a rim of no-return cells; the scanner is at the origin.

    `incidence_deg` holds for the beam to the middle of the plane (turned about the vertical);
    `truth_incidence` says it for every point. `truth_leaf` is 0, and the range noise is
    `noise_m` whatever the reflectance.

    Raises
    ------
    WrongUse
        The incidence is not within 0 to 90°, 90 excluded.
    """
    if not 0 <= incidence_deg < 90:
        raise WrongUse(f"A plane cannot be scanned at {incidence_deg}°; use 0 to below 90.")
    centre = np.array([distance, 0.0, 0.0])
    normal = np.array(tilted_normal(centre, np.zeros(3), float(np.deg2rad(incidence_deg))))
    across = np.cross([0.0, 0.0, 1.0], normal) * size / 2
    up = np.array([0.0, 0.0, size / 2])
    wall = Wall(vector(centre), vector(across), vector(up), material, label=0)
    corners = [centre + a * across + b * up for a in (-1, 1) for b in (-1, 1)]
    receiver = Receiver(noise_m, 0.0, intensity_noise)
    scene = Scene(f"plane at {incidence_deg:g}°", walls=(wall,))
    grid = _fit_grid(np.array(corners), step_deg)
    return scan_scene(scene, grid, _two_colour(receiver), seed=seed)


def leaf_row_scan(
    tilts_deg: tuple[float, ...] = TILTS,
    distance: float = 2.5,
    step_deg: float = 0.03,
    noise_m: float = 0.0,
    seed: int = 0,
) -> Scan:
    """Flat leaves side by side at known tilts, a wall 2 m behind them."""
    centre = np.array([distance, 0.0, SCANNER[2]])
    leaves = tilted_row(centre, 0.08, tilts_deg)
    half = 0.08 * len(tilts_deg) / 2
    corners = centre + np.array([(0, a * half, b * 0.06) for a in (-1, 1) for b in (-1, 1)])
    wall = Wall((distance + 2, 0.0, SCANNER[2]), (0.0, 3.0, 0.0), (0.0, 0.0, 3.0), MATT)
    instrument = _two_colour(Receiver(noise_m, intensity_noise=0.03 if noise_m else 0.0))
    grid = _fit_grid(corners - SCANNER, step_deg)
    return scan_scene(Scene("leaf row", leaves, (), (wall,)), grid, instrument, SCANNER, seed)


def leaves_scan(
    seed: int, leaves: int = 12, step_deg: float = 0.03, instrument: Instrument | None = None
) -> Scan:
    """Random leaves, flat, bent and wrinkled in turn, at 1.8–4.2 m before a wall at 5.5 m."""
    random = np.random.default_rng(seed)
    made = tuple(_scatter_leaf(index, random) for index in range(leaves))
    wall = Wall((5.5, 0.0, SCANNER[2]), (0.0, 3.0, 0.0), (0.0, 0.0, 3.0), MATT)
    scene = Scene(f"{leaves} leaves", made, (), (wall,))
    grid = grid_of_field(step_deg, (-4.0, 4.0), (-3.0, 3.0))
    return scan_scene(scene, grid, instrument or _two_colour(NOISY), SCANNER, seed)


def _two_colour(receiver: Receiver) -> Instrument:
    return replace(get_instrument("two_colour"), receiver=receiver)


def _scatter_leaf(index: int, random: np.random.Generator) -> Leaf:
    away = random.uniform(1.8, 4.2)
    side, rise = np.deg2rad(random.uniform(-3.5, 3.5)), np.deg2rad(random.uniform(-2.5, 2.5))
    centre = np.array(SCANNER) + away * np.array([1.0, np.tan(side), np.tan(rise)])
    normal: Vector = tilted_normal(centre, np.array(SCANNER), random.uniform(-1.2, 1.2))
    along = vector(random.normal(size=3))
    length, width = random.uniform(0.06, 0.09), random.uniform(0.04, 0.06)
    material, water = water_leaf(random)
    leaf = Leaf(vector(centre), along, normal, length, width, material, 0.3, water=water)
    return shape_leaf(leaf, IN_TURN[index % 3], random)


def _fit_grid(corners: Floats, step_deg: float, rim: int = 3) -> BeamGrid:
    """Grid that holds all corners, given as seen from the scanner, and a rim of cells."""
    elevation, azimuth = (np.rad2deg(a) for a in angles_of(corners, np.zeros(3)))
    edge = rim * step_deg
    return grid_of_field(
        step_deg,
        (float(azimuth.min()) - edge, float(azimuth.max()) + edge),
        (float(elevation.min()) - edge, float(elevation.max()) + edge),
    )
