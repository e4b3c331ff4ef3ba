"""Angle and intensity of points as fits, plots and tables take them, with whose they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.model.leaf import Leaf, join_members
from app.model.project import Project


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Points that have both an angle and a value, aligned (n,) arrays.

    Attributes
    ----------
    angle : array
        Angle of incidence, degrees.
    value : array
    point : integers
        Number of the point in the scan.
    leaf : integers
        Place of its leaf among those asked for; -1 without one.
    """

    angle: Floats
    value: Floats
    point: Ints
    leaf: Ints

    def __len__(self) -> int:
        return len(self.angle)

    def take(self, chosen: Bools) -> Measured:
        """Some of the points."""
        return Measured(
            self.angle[chosen], self.value[chosen], self.point[chosen], self.leaf[chosen]
        )

    def of_leaf(self, place: int) -> Measured:
        """The points of one leaf."""
        return self.take(self.leaf == place)


def gather(
    project: Project,
    scan: str,
    leaves: Sequence[str],
    channel: str,
    progress: Progress = QUIET,
) -> Measured:
    """Read the living points of leaves (none named: of the whole scan) that can be fitted.

    Raises
    ------
    WrongUse
        A leaf is not there, or belongs to another scan.
    LeafscopeError
        The angle or the channel cannot be had; the sentence says what is missing.
    """
    state = project.state.scan(scan)
    members = members_of(project, scan, leaves)
    points = np.flatnonzero(state.alive) if members is None else members[state.alive[members]]
    angle = project.field(scan, "incidence", points, progress)
    value = project.field(scan, channel, points, progress)
    usable = np.isfinite(angle) & np.isfinite(value)
    points = points[usable]
    chosen = [project.state.leaves[key] for key in leaves]
    whose = _number_leaves(chosen, len(state.scan))[points]
    return Measured(angle[usable], value[usable], points, whose)


def members_of(project: Project, scan: str, leaves: Sequence[str]) -> Ints | None:
    """Points of leaves of a scan; None when none is named.

    Raises
    ------
    WrongUse
        One of them is not there, or belongs to another scan.
    """
    if not leaves:
        return None
    there = {leaf.key: leaf for leaf in project.state.leaves_of(scan)}
    whole = project.state.scan(scan).scan
    for key in leaves:
        if key not in there:
            raise WrongUse(f"There is no {key} in {whole.name}.")
    return join_members([there[key] for key in leaves], len(whole))


def _number_leaves(leaves: Sequence[Leaf], size: int) -> Ints:
    numbers = np.full(size, -1, np.int64)
    for place, leaf in enumerate(leaves):
        numbers[leaf.members.indices] = place
    return numbers
