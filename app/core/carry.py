"""Leaves of one scan found again in another: same pose, or turned with their holder.

The points of a leaf are laid where they must be in the other scan. There a point belongs to the
leaf when a carried point lies in nearly the same direction, at nearly the same range. Both
tolerances are stated. Leaves that stand free may also have moved a little: what is connected with
the points found, and near, is theirs as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.core.holder import Axis, turn_points, turn_vectors
from app.core.robust_plane import MEDIAN_TO_SIGMA
from app.core.sight import Sight, View, beam_step, connected, smooth_ranges

HALF_DIAGONAL = 0.75
"""Of a cell of beams, with a little more: so far a point stands for its surroundings."""
SIGMAS = 4.0
"""Standard deviations of the leaf's thickness that are added to the tolerance along the beam."""
FREE = 0.05
"""A leaf stands free when so little, as a share of it, is connected with it and near."""
FEWEST = 3


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far a leaf may be from where it was carried to; metres.

    Attributes
    ----------
    along : float
        In range, beside four times the thickness of the leaf in its own scan.
    across : float
        At right angles to the beam, beside half a cell of beams.
    movement : float
        In any direction, for leaves that stand free: drooping, wind, an inexact holder.
    """

    along: float = 0.005
    across: float = 0.0
    movement: float = 0.01

    def __post_init__(self) -> None:
        for name, length in (
            ("along", self.along), ("across", self.across), ("movement", self.movement)
        ):  # fmt: skip
            if not 0.0 <= length < np.inf:
                raise WrongUse(f"The tolerance {name} the beam must be a length from 0 m on.")


USUAL = Tolerance()


@dataclass(frozen=True, slots=True)
class Motion:
    """How leaves came from one scan to the other: turned about an axis (radians), or not."""

    axis: Axis | None = None
    angle: float = 0.0

    def place(self, xyz: Floats) -> Floats:
        """Points, (k, 3), where they are afterwards."""
        return xyz if self.axis is None else turn_points(xyz, self.axis, self.angle)

    def turn(self, normal: Floats) -> Floats:
        """A direction, (3,), afterwards."""
        if self.axis is None:
            return normal
        return turn_vectors(normal, self.axis.direction, self.angle)


STILL = Motion()


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """A leaf as it is carried.

    Attributes
    ----------
    xyz : (k, 3) metres
        Its points without their noise: on a smooth surface, each on its beam.
    scanner : (3,) metres
        Where it was seen from.
    normal : (3,)
        Of its plane, towards the scanner.
    step : float
        Metres between beams at the leaf, in its own scan.
    thickness : float
        Metres along the beam by which points lie off the surface: noise and wrinkles.
    free : bool
        Nothing else is connected with it and near, so that it may have moved.
    """

    xyz: Floats
    scanner: Floats
    normal: Floats
    step: float
    thickness: float
    free: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Carried:
    """What was found of one leaf in another scan.

    Attributes
    ----------
    rows : (m,) int64
        Its points, in rising order.
    share : float
        Of the carried points, those that have one of `rows` near.
    offset : float
        Metres: median range of `rows` beyond the carried leaf; NaN without points.
    overlap : float
        Share of the points found that another leaf could claim as well.
    normal : (3,)
        Of the leaf's plane as carried; its sign is that of the pattern.
    """

    rows: Ints
    share: float
    offset: float
    overlap: float
    normal: Floats


def make_pattern(view: View, rows: Ints, tolerance: Tolerance = USUAL) -> Pattern:
    """Prepare a leaf of a scan to be carried.

    Parameters
    ----------
    view : View
    rows : (k,) int64
        Its points.
    tolerance : Tolerance
        Within its movement it is looked whether the leaf stands free.

    Raises
    ------
    BadInput
        The points have no plane: too few, or all on a line.
    """
    from app.core.inverse_plane import inverse_range_plane

    rows = rows[view.usable[rows]]
    xyz = view.xyz[rows]
    plane = inverse_range_plane(xyz, view.scanner)
    sight = Sight(xyz.mean(axis=0), view.scanner)
    seen = sight.look(xyz)
    smooth = smooth_ranges(seen)
    thickness = MEDIAN_TO_SIGMA * float(np.median(np.abs(seen[:, 2] - smooth)))
    surface = sight.lift(np.column_stack([seen[:, :2], smooth]))
    pattern = Pattern(surface, view.scanner, plane.normal, beam_step(seen), thickness, True)
    grown = _Laid(pattern, STILL, view, tolerance).grow(rows)
    return replace(pattern, free=len(grown) <= (1.0 + FREE) * len(rows))


def carry(
    view: View,
    patterns: Sequence[Pattern],
    motion: Motion = STILL,
    tolerance: Tolerance = USUAL,
) -> list[Carried]:
    """Find the points of leaves in another scan; where two could claim one, the nearer has it.

    Parameters
    ----------
    view : View
        The other scan.
    patterns : sequence of Pattern
    motion : Motion
        From the patterns' scan to this one.
    tolerance : Tolerance

    Returns
    -------
    list of Carried
        One for each pattern; without points for a leaf that is not there.
    """
    laid = [_Laid(pattern, motion, view, tolerance) for pattern in patterns]
    found = [one.find() for one in laid]
    nearest = np.full(len(view.xyz), np.inf)
    owner = np.full(len(view.xyz), -1)
    claims = np.zeros(len(view.xyz), np.int64)
    for number, (rows, far) in enumerate(found):
        claims[rows] += 1
        wins = far < nearest[rows]
        nearest[rows[wins]], owner[rows[wins]] = far[wins], number
    told = []
    for number, (one, (rows, _)) in enumerate(zip(laid, found, strict=True)):
        overlap = float(np.mean(claims[rows] > 1)) if len(rows) else 0.0
        told.append(one.tell(rows[owner[rows] == number], overlap))
    return told


class _Laid:
    """A leaf laid into another view, to be compared with the points about it.

    Points are known by their place in `rows`, those of the view that may be near enough.
    """

    def __init__(self, pattern: Pattern, motion: Motion, view: View, tolerance: Tolerance) -> None:
        self.pattern, self.movement = pattern, tolerance.movement
        self.normal = motion.turn(pattern.normal)
        placed = motion.place(pattern.xyz)
        centre = placed.mean(axis=0)
        self.sight = Sight(centre, view.scanner)
        self.seen = self.sight.look(placed)
        across = tolerance.across + HALF_DIAGONAL * pattern.step * self._stretch(motion)
        along = tolerance.along + SIGMAS * pattern.thickness
        self.radii = np.array([across, across, along])
        size = float(np.linalg.norm(placed - centre, axis=1).max())
        self.rows = _within(view, centre, size + across + along + 2.0 * self.movement)
        self.around = self.sight.look(view.xyz[self.rows])

    def _stretch(self, motion: Motion) -> float:
        """How much farther apart than in their own scan points lie; 1 where they move together."""
        before = Sight(self.pattern.xyz.mean(axis=0), self.pattern.scanner)
        along = before.steepest(self.pattern.normal)
        length = max(before.foreshorten(along), 0.1)
        return max(1.0, self.sight.foreshorten(motion.turn(along)) / length)

    def find(self) -> tuple[Ints, Floats]:
        """Rows of the leaf's points, and how far each is from it, as a share of the tolerance."""
        found = self._near(0.0)
        if self.pattern.free and self.movement and len(found) >= FEWEST:
            found = self._grow(found)
        return self.rows[found], self._distance(found, self.radii)

    def grow(self, rows: Ints) -> Ints:
        """Rows connected with some, within the movement that is allowed."""
        return self.rows[self._grow(np.flatnonzero(np.isin(self.rows, rows)))]

    def _grow(self, found: Ints) -> Ints:
        near = np.union1d(self._near(self.movement), found)
        seeds = np.isin(near, found, assume_unique=True)
        seen = self.around[near]
        return near[connected(seen, seeds, beam_step(seen))]

    def _near(self, slack: float) -> Ints:
        radii = self.radii + slack
        low, high = self.seen.min(axis=0) - radii, self.seen.max(axis=0) + radii
        places = np.flatnonzero(((self.around >= low) & (self.around <= high)).all(axis=1))
        return places[self._distance(places, radii) <= 1.0]

    def _distance(self, places: Ints, radii: Floats) -> Floats:
        from scipy.spatial import cKDTree

        far, _ = cKDTree(self.seen / radii).query(self.around[places] / radii)
        return np.asarray(far)

    def tell(self, rows: Ints, overlap: float) -> Carried:
        """What was found, compared with what was carried."""
        from scipy.spatial import cKDTree

        if not len(rows):
            return Carried(rows, 0.0, float("nan"), overlap, self.normal)
        seen = self.around[np.searchsorted(self.rows, rows)]
        radii = self.radii + (self.movement if self.pattern.free else 0.0)
        far, _ = cKDTree(seen / radii).query(self.seen / radii)
        _, nearest = cKDTree(self.seen[:, :2]).query(seen[:, :2])
        offset = float(np.median(seen[:, 2] - self.seen[nearest, 2]))
        return Carried(rows, float(np.mean(far <= 1.0)), offset, overlap, self.normal)


def _within(view: View, centre: Floats, reach: float) -> Ints:
    """Usable points in a box about a place, in rising order."""
    rows = np.flatnonzero(np.abs(view.xyz[:, 0] - centre[0]) <= reach)
    for axis in (1, 2):
        rows = rows[np.abs(view.xyz[rows, axis] - centre[axis]) <= reach]
    return rows[view.usable[rows]]
