"""A holder that turns leaves about an axis: turning points, and finding the axis from leaves.

A plane that turns with the holder keeps its angle to the axis and its distance from it, and the
middle of a leaf its place on the holder. With known angles, the same leaves in several scans
therefore give the axis by least squares.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse

NORMAL_SIGMA = 0.005
"""Radians by which a leaf's plane is usually unsure: the scale of the robust loss."""
OFFSET_SIGMA = 0.0005
"""The same for its place, metres."""
MIDDLE_SIGMA = 0.001
"""The same for the middle of a leaf, metres."""
NEAR = 0.1
"""Metres: a holder's axis is usually so near its leaves. Decides only what small turns leave open,
as does `SQUARE`."""
SQUARE = 0.05
"""Tangent of the angle by which the axis is off the common right angle to the leaves' normals."""
LEAST_TURN = 0.03
"""Radians that a holder must have turned for its axis to be told, about 2°."""


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """An axis in world coordinates; it turns by the right-hand rule.

    Attributes
    ----------
    point : (3,) metres
    direction : (3,)
        Unit vector.
    """

    point: Floats
    direction: Floats

    @classmethod
    def through(cls, point: Sequence[float] | Floats, direction: Sequence[float] | Floats) -> Axis:
        """An axis of any two triples of numbers; raises `WrongUse` where they make none."""
        place, along = np.array(point, np.float64), np.array(direction, np.float64)
        length = float(np.linalg.norm(along)) if along.shape == (3,) else 0.0
        if place.shape != (3,) or not np.isfinite(place).all() or not 0.0 < length < np.inf:
            raise WrongUse(
                "An axis needs a point and a direction that is not zero.",
                "Give six numbers: x, y, z in metres, and the direction's x, y, z.",
            )
        return cls(place, along / length)

    def reversed(self) -> Axis:
        """The same line; it turns the other way round."""
        return Axis(self.point, -self.direction)


@dataclass(frozen=True, slots=True, eq=False)
class SeenPlane:
    """The plane of a leaf in one scan.

    Attributes
    ----------
    leaf : int
        Which leaf.
    angle : float
        Radians, of the holder in that scan.
    normal : (3,)
    point : (3,) metres
        In the plane.
    weight : float
        σ of a usual plane over that of this one.
    whole : bool
        `point` is the middle of the leaf, not only of a part of it.
    """

    leaf: int
    angle: float
    normal: Floats
    point: Floats
    weight: float = 1.0
    whole: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class FittedAxis:
    """An axis found from planes, and how well they agree with it.

    Attributes
    ----------
    axis : Axis
        Turns by the right-hand rule when the holder's angle grows.
    tilt_rms : float
        Radians between the planes seen and the planes turned, root mean square.
    offset_rms : float
        Metres between them, across the plane.
    planes : int
    normals : mapping of int to (3,)
        Mean normal of each leaf at angle 0, of all its planes.
    """

    axis: Axis
    tilt_rms: float
    offset_rms: float
    planes: int
    normals: Mapping[int, Floats]


def turn_vectors(vectors: Floats, direction: Floats, angle: float) -> Floats:
    """Turn (k, 3) vectors about a unit direction by an angle in radians (Rodrigues)."""
    along = (vectors @ direction)[..., None] * direction
    across = vectors - along
    turned: Floats = along + np.cos(angle) * across + np.sin(angle) * np.cross(direction, vectors)
    return turned


def turn_points(xyz: Floats, axis: Axis, angle: float) -> Floats:
    """Turn (k, 3) points about an axis by an angle in radians."""
    return turn_vectors(xyz - axis.point, axis.direction, angle) + axis.point


def fit_axis(planes: Sequence[SeenPlane]) -> FittedAxis:
    """Find the axis about which planes of one or more leaves turn.

    Least squares of normals, offsets and middles over the axis and one leaf each, with a loss
    that a few wrong planes do not pull (soft L1). What small turns leave open (how far away the
    axis is, and how it leans along the beam) is decided by what is usual.

    Raises
    ------
    BadInput
        No leaf is seen at two angles that differ by 2° or more.
    """
    from scipy.optimize import least_squares

    turned = max((_turn_of(planes, leaf) for leaf in {p.leaf for p in planes}), default=0.0)
    if turned < LEAST_TURN:
        raise BadInput(
            "The axis cannot be told: no leaf was found at two angles 2° or more apart.",
            "Pick the axis by a point and a direction, or add scans.",
        )
    centre = np.mean([p.point for p in planes], axis=0)
    start = _guess_direction(planes)
    first, second = across_of(start)

    def lay(values: Floats) -> Axis:
        direction = start + values[0] * first + values[1] * second
        return Axis(
            centre + values[2] * first + values[3] * second,
            direction / np.linalg.norm(direction),
        )

    def differ(values: Floats) -> Floats:
        unusual = np.concatenate([values[:2] / SQUARE, values[2:] / NEAR])
        return np.concatenate([*_deviate(planes, lay(values)), unusual])

    found = least_squares(differ, np.zeros(4), loss="soft_l1", x_scale=[0.1, 0.1, 0.05, 0.05])
    axis = lay(found.x)
    back = _turn_back(planes, axis)
    return FittedAxis(
        axis,
        _rms(np.concatenate([one.tilt for one in back])),
        _rms(np.concatenate([one.offset for one in back])),
        len(planes),
        {one.leaf: one.normal / np.linalg.norm(one.normal) for one in back},
    )


def _turn_of(planes: Sequence[SeenPlane], leaf: int) -> float:
    angles = [p.angle for p in planes if p.leaf == leaf]
    return max(angles) - min(angles)


def _guess_direction(planes: Sequence[SeenPlane]) -> Floats:
    """Sum of the cross products of normals, in the sense of growing angle."""
    found = np.zeros(3)
    for i, one in enumerate(planes):
        for other in planes[:i]:
            if one.leaf == other.leaf and one.angle != other.angle:
                sense = np.sign(np.sin(one.angle - other.angle))
                found += sense * np.cross(other.normal, one.normal)
    length = float(np.linalg.norm(found))
    if not length:
        raise BadInput("The leaves do not turn with the angle: the axis cannot be told.")
    return np.asarray(found / length)


def across_of(direction: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors at right angles to a direction and to each other."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return first, np.cross(direction, first)


@dataclass(frozen=True, slots=True, eq=False)
class _Turned:
    """Planes of one leaf, turned back to angle 0, as they deviate from their weighted mean."""

    leaf: int
    normal: Floats
    tilt: Floats
    offset: Floats
    middle: Floats
    weight: Floats


def _turn_back(planes: Sequence[SeenPlane], axis: Axis) -> list[_Turned]:
    """For a given axis the mean of a leaf's planes is linear: it needs no unknowns of its own."""
    found = []
    for leaf in sorted({p.leaf for p in planes}):
        mine = [p for p in planes if p.leaf == leaf]
        normal = np.array([turn_vectors(p.normal, axis.direction, -p.angle) for p in mine])
        # Normals face the scanner; past 90° they show the other side of the leaf.
        normal *= np.where(normal @ normal[0] < 0.0, -1.0, 1.0)[:, None]
        place = np.array(
            [turn_vectors(p.point - axis.point, axis.direction, -p.angle) for p in mine]
        )
        weight = np.array([p.weight for p in mine])
        mean = np.average(normal, axis=0, weights=weight)
        offset = place @ mean  # of the mean, lest a lever makes an error of place of one of tilt
        whole = np.array([p.whole for p in mine])
        middle = place[whole] - place[whole].mean(axis=0) if whole.any() else place[whole]
        found.append(
            _Turned(
                leaf,
                mean,
                normal - mean,
                offset - np.average(offset, weights=weight),
                middle,
                weight,
            )
        )
    return found


def _deviate(planes: Sequence[SeenPlane], axis: Axis) -> list[Floats]:
    """All deviations, each over its usual σ."""
    found = []
    for turned in _turn_back(planes, axis):
        found += [
            (turned.tilt * turned.weight[:, None]).ravel() / NORMAL_SIGMA,
            turned.offset * turned.weight / OFFSET_SIGMA,
            turned.middle.ravel() / MIDDLE_SIGMA,
        ]
    return found


def _rms(deviations: Floats) -> float:
    """Root mean square of the lengths of rows, or of numbers."""
    return float(np.sqrt(np.mean((deviations**2).reshape(len(deviations), -1).sum(axis=1))))
