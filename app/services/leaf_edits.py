"""Leaves put right by hand: several made one, one split by seeds; each is one step."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from app.core.arrays import Ints
from app.core.errors import WrongUse
from app.core.neighbours.steps import UnusableGrid, as_cells, measure_steps
from app.core.progress import QUIET, Progress
from app.model.leaf import Leaf
from app.model.neighbours import neighbours_of
from app.model.operations import PutLeaf, Several
from app.model.points import PointSet
from app.model.project import Project
from app.model.selection import Explicit
from app.model.state import make_key, next_leaf_key
from app.services.leaves import key_number


def merge_leaves(project: Project, keys: Sequence[str]) -> None:
    """Make one leaf of several: the first keeps its key and its name.

    Raises
    ------
    WrongUse
        Fewer than two leaves, or they are of several scans.
    """
    leaves = [project.state.leaves[key] for key in dict.fromkeys(keys)]
    if len(leaves) < 2:
        raise WrongUse("One leaf alone cannot be merged.", "Choose two leaves or more.")
    if len({leaf.scan for leaf in leaves}) > 1:
        raise WrongUse("Leaves of several scans cannot be one leaf.")
    first, *others = join_leaves(leaves)
    project.do(Several(f"Merge {len(leaves)} leaves", (first, *others)))


def join_leaves(leaves: Sequence[Leaf]) -> list[PutLeaf]:
    """Steps that give all points to the first leaf and remove the others."""
    members = PointSet(np.concatenate([leaf.members.indices for leaf in leaves]))
    basis = tuple(part for leaf in leaves for part in leaf.basis)
    merged = msgspec.structs.replace(leaves[0], members=members, basis=basis)
    others = [PutLeaf(leaf.key, None) for leaf in leaves[1:]]
    return [PutLeaf(merged.key, merged, "Merge into"), *others]


def split_leaf(
    project: Project, key: str, seeds: Sequence[PointSet], progress: Progress = QUIET
) -> list[str]:
    """Split a leaf so that each group of seeds is a leaf of its own, as one step.

    The first group keeps the leaf's key and name.

    Parameters
    ----------
    seeds : sequence of PointSet
        Points of the leaf; what is none of them is left out.

    Returns
    -------
    list of str
        Keys of the leaves, in the order of the seeds.

    Raises
    ------
    WrongUse
        Fewer than two groups, a point in two, or a group without a point of the leaf.
    """
    leaf = project.state.leaves[key]
    owner = share_out(project, leaf, seeds, progress)
    number = key_number(next_leaf_key(project.state))
    keys = [key, *(make_key("leaf", number + k) for k in range(len(seeds) - 1))]
    steps = []
    for place, own in enumerate(keys):
        members = PointSet(leaf.members.indices[owner == place])
        name = leaf.name if own == key else f"Leaf {key_number(own)}"
        verb = "Split" if own == key else "Make"
        made = Leaf(own, leaf.scan, name, members, (Explicit(members),))
        steps.append(PutLeaf(own, made, verb))
    project.do(Several(f"Split {leaf.name} into {len(keys)} leaves", tuple(steps)))
    return keys


def share_out(
    project: Project, leaf: Leaf, seeds: Sequence[PointSet], progress: Progress = QUIET
) -> Ints:
    """Number of the seeds that each member of a leaf goes with; raises as `split_leaf` does."""
    from app.core.segment_edits import settle_split, split_points

    scan, members = project.state.scan(leaf.scan).scan, leaf.members.indices
    groups = [np.flatnonzero(np.isin(members, group.indices)) for group in seeds]
    if not all(map(len, groups)):
        raise WrongUse(f"A seed does not lie on {leaf.name}.", "Take points of that leaf.")
    grid = neighbours_of(scan, progress.part(0.0, 0.5)).grid
    progress.report(0.5, f"Splitting {leaf.name}")
    owner = split_points(scan.xyz[members], groups)
    if scan.pose is None or grid is None:
        return owner
    scanner, cells = scan.scanner("the shape of leaves"), as_cells(grid)
    try:
        turn = cells.columns if measure_steps(scan.xyz, scanner, cells).seam else None
    except UnusableGrid:
        return owner
    beams, row, column = scan.xyz[members] - scanner, cells.row[members], cells.column[members]
    return settle_split(beams, row, column, turn, owner, groups)
