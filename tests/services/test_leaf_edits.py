"""Leaves merged and split by hand: undoable steps."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.model.leaf import Leaf
from app.model.operations import PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Grid, Pose, Scan
from app.services.leaf_edits import merge_leaves, split_leaf
from app.services.opening import add_scans

KEY = "scan-00001"


def make_plates(grid: bool = True) -> tuple[Project, np.ndarray]:
    """Two flat plates side by side, one leaning; they meet at a third of the way."""
    row, column = (a.ravel() for a in np.mgrid[:30, :60])
    side, up = (column - 30) * 0.001, (row - 15) * 0.001
    second = side > -0.01
    depth = np.where(second, 1.0 + (side + 0.01) * 1.5, 1.0)
    xyz = np.stack([depth, depth * side, depth * up], axis=1)
    scan = Scan(
        "plates", xyz, grid=Grid(30, 60, row, column) if grid else None, pose=Pose((0, 0, 0))
    )
    project = Project()
    add_scans(project, [scan])
    leaf = Leaf("leaf-00001", KEY, "Leaf 1", PointSet(range(len(xyz))))
    project.do(PutLeaf(leaf.key, leaf))
    return project, second


def at(row: int, column: int) -> PointSet:
    return PointSet([row * 60 + column])


@pytest.mark.parametrize("grid", [True, False])
def test_two_seeds_make_two_leaves(grid) -> None:
    project, second = make_plates(grid)
    before = project.state.leaves
    keys = split_leaf(project, "leaf-00001", [at(15, 15), at(15, 55)])
    assert keys == ["leaf-00001", "leaf-00002"]
    one, other = (project.state.leaves[key] for key in keys)
    assert (one.name, other.name) == ("Leaf 1", "Leaf 2")
    assert len(one.members) + len(other.members) == 1800
    # The fold is at column 20; half way between the seeds lies column 29, where shapes say nothing.
    wrong = (~other.members.mask(1800) & second).sum()
    assert wrong < (30 if grid else 300)
    project.undo()
    assert project.state.leaves == before


def test_a_lassoed_patch_is_a_seed() -> None:
    project, _ = make_plates()
    patch = PointSet(np.arange(1800)[np.arange(1800) % 60 > 45])
    _, taken = split_leaf(project, "leaf-00001", [at(2, 2), patch])
    assert project.state.leaves[taken].members.mask(1800)[patch.indices].all()
    assert not project.state.leaves[taken].members.mask(1800)[:60:60].any()


def test_merging_is_the_way_back() -> None:
    project, _ = make_plates()
    keys = split_leaf(project, "leaf-00001", [at(15, 5), at(15, 50)])
    merge_leaves(project, keys)
    (leaf,) = project.state.leaves.values()
    assert leaf.name == "Leaf 1"
    assert len(leaf.members) == 1800
    project.undo()
    assert len(project.state.leaves) == 2


def test_what_cannot_be_split_or_merged() -> None:
    project, _ = make_plates()
    with pytest.raises(WrongUse, match="both sides"):
        split_leaf(project, "leaf-00001", [at(1, 1)])
    with pytest.raises(WrongUse, match="two leaves"):
        split_leaf(project, "leaf-00001", [at(1, 1), at(1, 1)])
    small = Leaf("leaf-00002", KEY, "Small", PointSet([1, 2, 3]))
    project.do(PutLeaf(small.key, small))
    with pytest.raises(WrongUse, match="not lie on Small"):
        split_leaf(project, small.key, [PointSet([1]), at(20, 20)])
    with pytest.raises(WrongUse, match="alone"):
        merge_leaves(project, ["leaf-00001", "leaf-00001"])
    add_scans(project, [Scan("other", np.zeros((3, 3)))])
    away = Leaf("leaf-00003", "scan-00002", "Away", PointSet([0]))
    project.do(PutLeaf(away.key, away))
    with pytest.raises(WrongUse, match="several scans"):
        merge_leaves(project, ["leaf-00001", "leaf-00003"])
