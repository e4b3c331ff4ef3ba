"""Wind: leaves that move while the scanner turns from column to column."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from app.core.units import to_radians
from app.simulate.leaf_shapes import vector
from app.simulate.surfaces import Scene


class Wind(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How leaves sway.

    Attributes
    ----------
    amplitude : float
        Metres to each side, of a usual leaf.
    columns : float
        Columns of the scan that one swing takes.
    azimuth_deg : float
        Direction to which it blows; 0 is along x, 90 to the left.
    """

    amplitude: Annotated[float, Meta(ge=0, le=1)] = 0.005
    columns: Annotated[float, Meta(gt=2, le=1e7)] = 60.0
    azimuth_deg: Annotated[float, Meta(ge=-360, le=360)] = 90.0


def apply_wind(scene: Scene, wind: Wind, random: np.random.Generator) -> Scene:
    """The scene with its leaves swaying; stems, needles and walls stand still.

    Each leaf has an amplitude, a direction, a rate and a phase of its own, so that neighbours are
    not in step.
    """
    if wind.amplitude == 0.0:
        return scene
    count = len(scene.leaves)
    strength = wind.amplitude * np.exp(random.normal(0.0, 0.3, count))
    azimuth = to_radians(wind.azimuth_deg) + random.normal(0.0, 0.2, count)
    lift = random.normal(0.0, 0.2, count)
    sway = strength[:, None] * np.column_stack([np.cos(azimuth), np.sin(azimuth), lift])
    rate = 2 * np.pi / wind.columns * np.exp(random.normal(0.0, 0.2, count))
    phase = random.uniform(0.0, 2 * np.pi, count)
    leaves = tuple(
        replace(leaf, sway=vector(s), sway_rate=float(r), sway_phase=float(p))
        for leaf, s, r, p in zip(scene.leaves, sway, rate, phase, strict=True)
    )
    return replace(scene, leaves=leaves)
