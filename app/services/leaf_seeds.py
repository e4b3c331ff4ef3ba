"""A table of seeds: points that say which leaves are one, and which are several.

Each row names a leaf and a place on it. Places of one name on several found leaves make them one;
places of several names on one found leaf split it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.core.units import MM_PER_M
from app.model.leaf import Leaf
from app.model.operations import PutLeaf, Several
from app.model.points import PointSet
from app.model.project import Project
from app.model.selection import Explicit
from app.model.state import make_key, next_leaf_key
from app.services.leaf_edits import share_out
from app.services.leaves import find_leaves, key_number, leaves_from_labels
from app.services.tables import read_table

REACH = 0.02
"""Metres from a seed up to which the nearest point of a leaf is meant."""


@dataclass(frozen=True, slots=True, eq=False)
class Seeds:
    """Names of leaves and places on them.

    Attributes
    ----------
    table : str
        The file, for messages.
    names : tuple of str
    places : (n, 3) metres
    lines : tuple of int
        Of the file.
    """

    table: str
    names: tuple[str, ...]
    places: Floats
    lines: tuple[int, ...]


def read_seeds(path: Path) -> Seeds:
    """Read a table with the columns ``leaf``, ``x``, ``y`` and ``z`` (metres, as in the scan).

    Raises
    ------
    BadInput
        It cannot be read, or a row lacks a name or a coordinate.
    """
    table = read_table(path, ("leaf", "x", "y", "z"))
    names = table.columns["leaf"]
    places = np.stack([table.numbers(axis) for axis in "xyz"], axis=1)
    for name, place, line in zip(names, places, table.lines, strict=True):
        if not name or not np.isfinite(place).all():
            raise BadInput(f"{table.name}, row {line}: a seed needs a leaf's name and x, y, z.")
    return Seeds(table.name, names, places, table.lines)


def make_leaves(
    project: Project, scan: str, label_field: str | None, seeds: Seeds | None,
    progress: Progress = QUIET,
) -> None:  # fmt: skip
    """Find the leaves of a scan, or take those of a label field; then put them right by seeds."""
    if label_field is None:
        find_leaves(project, scan, progress.part(0.0, 0.8))
    else:
        leaves_from_labels(project, scan, label_field)
    if seeds is not None:
        apply_seeds(project, scan, seeds, progress.part(0.8, 1.0))


def apply_seeds(project: Project, scan: str, seeds: Seeds, progress: Progress = QUIET) -> None:
    """Split, merge and name the leaves of a scan as seeds say, as one step.

    Leaves without a seed stay as they are.

    Raises
    ------
    BadInput
        A seed lies on no leaf.
    WrongUse
        Two seeds of different names mean the same point.
    """
    leaves = project.state.leaves_of(scan)
    rows = _find_points(project, scan, leaves, seeds)
    pieces: dict[str, list[Ints]] = {}
    taken: dict[str, Leaf] = {}
    for place, leaf in enumerate(leaves):
        inside = np.isin(rows, leaf.members.indices)
        names = list(dict.fromkeys(np.array(seeds.names, object)[inside]))
        if not names:
            continue
        progress.report(place / len(leaves), "Applying seeds")
        taken[leaf.key] = leaf
        groups = [PointSet(rows[inside & (np.array(seeds.names) == name)]) for name in names]
        owner = np.zeros(len(leaf.members), np.int64)
        if len(names) > 1:
            owner = share_out(project, leaf, groups, progress)
        for number, name in enumerate(names):
            pieces.setdefault(name, []).append(leaf.members.indices[owner == number])
    _put(project, scan, pieces, taken)


def _find_points(project: Project, scan: str, leaves: Sequence[Leaf], seeds: Seeds) -> Ints:
    """Row of the leaf point nearest to each seed."""
    from scipy.spatial import cKDTree

    if not leaves:
        raise BadInput("No leaf was found that seeds could lie on.")
    xyz = project.state.scan(scan).scan.xyz
    rows = np.unique(np.concatenate([leaf.members.indices for leaf in leaves]))
    rows = rows[np.isfinite(xyz[rows]).all(axis=1)]
    found = cKDTree(xyz[rows]).query(seeds.places)
    away, near = np.asarray(found[0]), np.asarray(found[1])
    for far, name, line in zip(away, seeds.names, seeds.lines, strict=True):
        if far > REACH:
            raise BadInput(
                f"{seeds.table}, row {line}: the seed of leaf {name} lies {far * MM_PER_M:.0f} mm "
                f"from the nearest point of a leaf; {REACH * MM_PER_M:.0f} mm are allowed.",
                "Take coordinates of points of the scan, in metres.",
            )
    return np.asarray(rows[near])


def _put(
    project: Project, scan: str, pieces: dict[str, list[Ints]], taken: dict[str, Leaf]
) -> None:
    """Leaves by name; their keys are those of the leaves they come from, as far as these go."""
    number = key_number(next_leaf_key(project.state))
    free = list(taken)
    fresh = [make_key("leaf", number + k) for k in range(max(len(pieces) - len(free), 0))]
    steps = []
    for key, (name, parts) in zip([*free, *fresh], pieces.items(), strict=False):
        members = PointSet(np.concatenate(parts))
        steps.append(PutLeaf(key, Leaf(key, scan, name, members, (Explicit(members),)), "Seed"))
    steps += [PutLeaf(key, None) for key in free[len(pieces) :]]
    project.do(Several(f"Put {len(pieces)} leaves right by seeds", tuple(steps)))
