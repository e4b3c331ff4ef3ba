"""The kind of scene that the other simulator scanned, and its beam, rebuilt for ours.

Its README tells the instrument; sizes, shapes and reflectances of the leaves were measured on its
points: areas of π/4 · length · width, curvatures up to 15 per metre, waves 12 to 25 mm long.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.units import to_radians
from app.model.scan import Vector
from app.services.bench.simulate.rig import HERE, greys
from app.simulate.beam import BeamGrid, Bundle
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.leaf_shapes import tilted_normal, vector
from app.simulate.material import glossy
from app.simulate.receiver import Receiver
from app.simulate.surfaces import Leaf, Scene, Wall

Name = Literal["phase_shift", "pulsed"]
GLOSS = ((0.88, 0.22), (0.72, 0.30))
"""k_d and m of its leaves at 1063 and 1545 nm."""
STEP = float(to_radians(0.018))
ROWS, COLUMNS = 636, 827


@dataclass(frozen=True, slots=True)
class OtherScene:
    """How many leaves stand where, and the wall behind them; metres."""

    instrument: str
    leaves: int
    wall: float


SCENES: dict[Name, OtherScene] = {
    "phase_shift": OtherScene("two_colour", 70, 6.0),
    "pulsed": OtherScene("pulsed", 90, 2.6),
}


def rebuild(name: Name, ranges: Floats, seed: int) -> tuple[Scene, tuple[int, ...]]:
    """A scene of that kind, and the kind of each leaf: 0 flat, 1 bent, 2 wrinkled.

    `ranges` are those at which its leaves stand, metres: a near leaf has so many more points
    that scenes of 70 leaves with other ranges differ by more than simulators do.
    """
    random = np.random.default_rng(seed)
    plan = SCENES[name]
    kinds = tuple(int(kind) for kind in random.integers(0, 3, plan.leaves))
    away = np.resize(random.permutation(ranges), plan.leaves)
    leaves = tuple(_grow(kind, float(r), random) for kind, r in zip(kinds, away, strict=True))
    wall = Wall((plan.wall, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 3.0), greys(0.12, 0.12))
    return Scene(name, leaves, (), (wall,)), kinds


def imitate(name: Name) -> tuple[Instrument, BeamGrid]:
    """The instrument without noise, with its 37 sub-rays; and the grid."""
    tool = replace(
        get_instrument(SCENES[name].instrument), receiver=Receiver(threshold=0.0), bundle=Bundle()
    )
    return tool, BeamGrid((ROWS - 1) * STEP / 2, (COLUMNS - 1) * STEP / 2, STEP, ROWS, COLUMNS)


def _grow(kind: int, away: float, random: np.random.Generator) -> Leaf:
    side, rise = to_radians(np.array([random.uniform(-7.2, 7.2), random.uniform(-5.5, 5.5)]))
    beam = np.array([np.cos(rise) * np.cos(side), np.cos(rise) * np.sin(side), np.sin(rise)])
    centre = away * beam
    normal = _lean(centre, float(to_radians(random.uniform(5.0, 88.0))), random)
    rho = 1 + 0.08 * random.standard_normal(2)
    leaf = Leaf(
        vector(centre),
        vector(random.normal(size=3)),
        normal,
        random.uniform(0.055, 0.085),
        random.uniform(0.03, 0.06),
        (glossy(0.48 * rho[0], *GLOSS[0]), glossy(0.27 * rho[1], *GLOSS[1])),
    )
    if kind == 0:
        return leaf
    leaf = replace(leaf, curvature=random.uniform(-15.0, 15.0))
    return leaf if kind == 1 else _wrinkle(leaf, random)


def _lean(centre: Floats, tilt: float, random: np.random.Generator) -> Vector:
    """Normal at `tilt` from the beam to `centre`, to any side."""
    upright = np.array(tilted_normal(centre, np.array(HERE), tilt))
    back = -centre / np.linalg.norm(centre)
    turn = random.uniform(0.0, 2 * np.pi)
    across = upright - back * (back @ upright)
    spun = np.cos(turn) * across + np.sin(turn) * np.cross(back, across)
    return vector(back * (back @ upright) + spun)


def _wrinkle(leaf: Leaf, random: np.random.Generator) -> Leaf:
    """Plane waves along or across the leaf: the other wave is too long to bend it."""
    length, phase = random.uniform(0.012, 0.025), random.uniform(0.0, 2 * np.pi)
    along = random.random() < 0.5
    return replace(
        leaf,
        wrinkle_height=random.uniform(0.0006, 0.0016),
        wrinkle_lengths=(length, 1000.0) if along else (1000.0, length),
        wrinkle_phases=(phase, np.pi / 2) if along else (np.pi / 2, phase),
    )
