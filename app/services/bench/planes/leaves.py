"""Single leaves before a wall, at known angles: without noise first, then with noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.units import to_degrees, to_radians
from app.services.bench.planes.methods import HERE
from app.simulate.beam import angles_of, grid_of_field
from app.simulate.branch import LEAF, MATT
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.leaf_shapes import Shape, shape_leaf, tilted_normal, unit, vector
from app.simulate.receiver import Receiver
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Leaf, Scene, Wall

Kind = Literal["flat", "curved", "wrinkled"]
Points = Literal["true points", "with mixed pixels", "nothing behind"]
POINTS: tuple[Points, ...] = get_args(Points)
SHAPES: dict[Kind, Shape] = {"flat": "flat", "curved": "bent", "wrinkled": "wrinkled"}
DISTANCE, WALL = 2.5, 5.0
"""Metres."""
STEP_DEG = 0.018
MARGIN = 0.01
"""Metres that the field reaches beyond a leaf."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenLeaf:
    """A leaf as it is seen without noise, the scanner at the origin.

    Attributes
    ----------
    xyz : (n, 3) metres
        All points of which the leaf is the main surface, before a wall.
    ghost : (n,) bool
        Mixed pixels: farther than 2 mm from all that their beam touched.
    alone : (m, 3) metres
        All points without the wall: where a beam's axis passes the leaf, what it catches counts.
    normal : (3,)
        Of the frame on which the leaf was built: its mean plane, where it is bent or wrinkled.
    """

    xyz: Floats
    ghost: Bools
    alone: Floats
    normal: Floats

    def draw(self, points: Points, sigma: float, seed: int) -> Floats:
        """Points with white noise along their beams, (k, 3)."""
        xyz = self.alone if points == "nothing behind" else self.xyz
        xyz = xyz[~self.ghost] if points == "true points" else xyz
        away = np.linalg.norm(xyz, axis=1, keepdims=True)
        noise = np.random.default_rng(seed).normal(0.0, sigma, away.shape)
        return np.asarray(xyz * (1.0 + noise / away))


def see_leaf(kind: Kind, tilt_deg: float, seed: int) -> SeenLeaf:
    """A leaf of random size, shape and turn in its plane, 2.5 m away, 2.5 m before a wall."""
    random = np.random.default_rng([seed, 20261122])
    up, side = random.uniform(-0.3, 0.3, 2)
    centre = DISTANCE * unit(np.array([1.0, side, up]))
    normal = tilted_normal(centre, HERE, float(to_radians(tilt_deg)))
    along = vector(random.normal(size=3))
    length, width = float(random.uniform(0.06, 0.09)), float(random.uniform(0.04, 0.06))
    flat = Leaf(vector(centre), along, normal, length, width, LEAF, 0.3)
    leaf = shape_leaf(flat, SHAPES[kind], random)
    back = unit(centre)
    left = unit(np.cross([0.0, 0.0, 1.0], back))
    wall = Wall(vector(back * WALL), vector(left), vector(np.cross(back, left)), MATT)
    reach = leaf.reach() + MARGIN
    elevation, azimuth = (float(to_degrees(a)[0]) for a in angles_of(centre[None], HERE))
    half = float(to_degrees(np.array([reach / DISTANCE]))[0])
    grid = grid_of_field(
        STEP_DEG, (azimuth - half, azimuth + half), (elevation - half, elevation + half)
    )
    scan, bare = (
        scan_scene(Scene(kind, (leaf,), walls=walls), grid, _silent(), seed=seed)
        for walls in ((wall,), ())
    )
    mine = scan.attributes["truth_leaf"] == 0
    ghost = scan.attributes["truth_ghost"][mine] > 0
    return SeenLeaf(scan.xyz[mine], ghost, bare.xyz, leaf.frame()[2])


def _silent() -> Instrument:
    return replace(get_instrument("two_colour"), receiver=Receiver())
