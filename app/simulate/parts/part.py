"""What every part of a scene is: a few numbers in a file, and the surfaces they stand for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import chain
from typing import Annotated, TypeVar

import msgspec
import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.core.units import to_radians
from app.model.scan import Vector
from app.simulate.leaf_shapes import check_apart, turn_about_vertical
from app.simulate.material import Material
from app.simulate.painting import AnyMaterial, material_at
from app.simulate.surfaces import Leaf, Scene, Stem, Wall

Metres = Annotated[float, Meta(gt=0, le=1000)]
Count = Annotated[int, Meta(ge=1, le=1_000_000)]
Share = Annotated[float, Meta(ge=0, le=1)]
Tilt = Annotated[float, Meta(gt=-90, lt=90)]
Turn = Annotated[float, Meta(ge=-360, le=360)]
Elevation = Annotated[float, Meta(gt=-90, lt=90)]
Coordinate = Annotated[float, Meta(ge=-100_000, le=100_000)]
Point = tuple[Coordinate, Coordinate, Coordinate]
LeafSize = Annotated[float, Meta(gt=0, le=5)]
Interval = tuple[LeafSize, LeafSize]
"""Shortest and longest leaf, metres."""
Paint = Callable[[float], Material]
"""The material of a leaf that has a share of a fresh leaf's water."""

Labelled = TypeVar("Labelled", Stem, Wall)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a part is built into.

    Attributes
    ----------
    random : numpy.random.Generator
        The part's own, so that a part more or less changes no other.
    scanner : Vector
        Metres.
    wavelengths_nm : tuple of float
        Channels of the instrument.
    hours : float
        Since the leaves were cut.
    """

    random: np.random.Generator
    scanner: Vector = (0.0, 0.0, 0.0)
    wavelengths_nm: tuple[float, ...] = (1063.0, 1545.0)
    hours: float = 0.0

    def paint(self, material: AnyMaterial, water: float = 1.0) -> Material:
        """The material in the channels of the instrument."""
        return material_at(material, self.wavelengths_nm, water)

    def mix(self, material: AnyMaterial) -> Paint:
        """The material by water; each share of water is looked up once."""
        return lru_cache(maxsize=None)(partial(self.paint, material))


@dataclass(frozen=True, slots=True)
class Pieces:
    """Surfaces of a part; the labels ≥ 0 of its stems and walls count from 0."""

    leaves: tuple[Leaf, ...] = ()
    stems: tuple[Stem, ...] = ()
    walls: tuple[Wall, ...] = ()


class Part(msgspec.Struct, frozen=True, tag_field="kind", forbid_unknown_fields=True, kw_only=True):
    """Something that stands in a scene.

    Attributes
    ----------
    name : str
        A handle for series; the scan does not depend on it.
    """

    name: str = ""

    def build(self, surroundings: Surroundings) -> Pieces:
        """Its surfaces in world metres."""
        raise NotImplementedError

    def count_surfaces(self) -> int:
        """How many surfaces `build` makes."""
        return 1


class Placed(Part, frozen=True, kw_only=True):
    """A part that stands in a direction from the scanner, or at a place.

    Attributes
    ----------
    range : float, optional
        Distance of its centre from the scanner, metres; 2.5 when no `centre` is given.
    azimuth_deg, elevation_deg : float
        Direction of the centre; azimuth 0 looks along x and grows to the left.
    centre : point, optional
        The centre in world metres, instead of a direction.
    """

    range: Metres | None = None
    azimuth_deg: Turn = 0.0
    elevation_deg: Elevation = 0.0
    centre: Point | None = None

    def __post_init__(self) -> None:
        if self.centre is not None and (self.range, self.azimuth_deg, self.elevation_deg) != (
            None,
            0.0,
            0.0,
        ):
            raise ValueError("`centre` stands instead of `range`, `azimuth_deg`, `elevation_deg`")

    def place(self, scanner: Vector) -> Floats:
        """Its centre, (3,) metres; raises `WrongUse` when that is where the scanner is."""
        here = np.array(scanner, float)
        centre = here + self._reach() if self.centre is None else np.array(self.centre, float)
        check_apart(centre, here)
        return centre

    def face(self, scanner: Vector, turn_deg: float = 0.0) -> Floats:
        """Axes of an upright board that faces the scanner: rows left, up, towards it; (3, 3).

        `turn_deg` turns the board about the vertical.
        """
        back = (np.array(scanner) - self.place(scanner)) * [1.0, 1.0, 0.0]
        length = np.linalg.norm(back)
        back = back / length if length > 0 else np.array([-1.0, 0.0, 0.0])
        axes = np.vstack([np.cross(back, UP), UP, back])
        return turn_about_vertical(axes, float(to_radians(turn_deg)))

    def _reach(self) -> Floats:
        """From the scanner to the centre, (3,) metres."""
        side, rise = to_radians(self.azimuth_deg), to_radians(self.elevation_deg)
        beam = np.array([np.cos(rise) * np.cos(side), np.cos(rise) * np.sin(side), np.sin(rise)])
        return (2.5 if self.range is None else self.range) * beam


def assemble(
    pieces: tuple[Pieces, ...],
    name: str = "scene",
    wavelengths_nm: tuple[float, ...] = (1063.0, 1545.0),
) -> Scene:
    """All pieces as one scene; needles are numbered after the last leaf, part by part."""
    first = sum(len(piece.leaves) for piece in pieces)
    stems: list[Stem] = []
    walls: list[Wall] = []
    for piece in pieces:
        labels = [s.label for s in piece.stems] + [w.label for w in piece.walls]
        stems += [_shift(stem, first) for stem in piece.stems]
        walls += [_shift(wall, first) for wall in piece.walls]
        first += max(labels, default=-1) + 1
    leaves = tuple(chain.from_iterable(piece.leaves for piece in pieces))
    return Scene(name, leaves, tuple(stems), tuple(walls), wavelengths_nm)


def _shift(surface: Labelled, by: int) -> Labelled:
    return surface if surface.label < 0 else replace(surface, label=surface.label + by)


def check_order(**intervals: tuple[float, float]) -> None:
    """Refuse intervals that are turned round; for `__post_init__` of parts."""
    for name, (low, high) in intervals.items():
        if low > high:
            raise ValueError(f"`{name}` is turned round: {low:g} to {high:g}")
