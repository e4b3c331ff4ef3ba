"""A table of seeds splits, merges and names leaves."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.model.leaf import Leaf
from app.model.operations import PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.services.leaf_seeds import apply_seeds, read_seeds
from app.services.leaf_tables import tabulate_leaves
from app.services.opening import Opening, add_scans
from app.services.reading import read_file

KEY = "scan-00001"


@pytest.fixture
def project() -> Project:
    """Three strips of 10 cm one above the other: leaves 1, 2 and 3."""
    made = Project()
    x, y = (a.ravel() for a in np.meshgrid(np.arange(50) * 0.002, np.arange(5) * 0.002))
    strips = [np.stack([x, y + 0.1 * k, 0 * x], axis=1) for k in range(3)]
    add_scans(made, [Scan("s", np.concatenate(strips))])
    for k in range(3):
        members = PointSet(range(k * 250, k * 250 + 250))
        leaf = Leaf(f"leaf-{k + 1:05}", KEY, f"Leaf {k + 1}", members)
        made.do(PutLeaf(leaf.key, leaf))
    return made


def write(tmp_path, *rows: str):
    path = tmp_path / "seeds.csv"
    path.write_text("\n".join(("leaf,x,y,z", *rows)), encoding="utf-8")
    return path


def sizes(project: Project) -> dict[str, int]:
    return {leaf.name: len(leaf.members) for leaf in project.state.leaves_of(KEY)}


def test_two_names_split_and_one_name_merges(project, tmp_path) -> None:
    path = write(tmp_path, "a,0,0,0", "b,0.098,0.004,0", "b,0.05,0.1,0")
    apply_seeds(project, KEY, read_seeds(path))
    assert sizes(project) == {"a": 125, "b": 375, "Leaf 3": 250}
    project.undo()
    assert sizes(project) == {"Leaf 1": 250, "Leaf 2": 250, "Leaf 3": 250}


def test_merged_leaves_are_one(project, tmp_path) -> None:
    path = write(tmp_path, "a,0,0,0", "a,0.05,0.1,0", "a,0.05,0.2,0.01")
    apply_seeds(project, KEY, read_seeds(path))
    assert sizes(project) == {"a": 750}
    assert list(project.state.leaves) == ["leaf-00001"]


def test_a_leaf_split_into_more_than_there_were(project, tmp_path) -> None:
    rows = [f"{k},{0.02 * k},0,0" for k in range(5)]
    apply_seeds(project, KEY, read_seeds(write(tmp_path, *rows)))
    assert len(sizes(project)) == 7
    assert sum(sizes(project).values()) == 750


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (["a,0,0,0.03"], "30 mm"),
        (["a,0,,0"], "row 2: a seed needs"),
        ([",0,0,0"], "row 2: a seed needs"),
        (["a,0,0,x"], "not a number"),
        ([], "no rows"),
    ],
)
def test_bad_seeds(project, tmp_path, rows, words) -> None:
    before = project.state
    with pytest.raises(BadInput, match=words):
        apply_seeds(project, KEY, read_seeds(write(tmp_path, *rows)))
    assert project.state is before


def test_one_point_for_two_leaves(project, tmp_path) -> None:
    with pytest.raises(WrongUse, match="two leaves"):
        apply_seeds(project, KEY, read_seeds(write(tmp_path, "a,0,0,0", "b,0,0,0.001")))


def test_a_scan_without_leaves(tmp_path) -> None:
    empty = Project()
    add_scans(empty, [Scan("s", np.zeros((3, 3)))])
    with pytest.raises(BadInput, match="No leaf"):
        apply_seeds(empty, KEY, read_seeds(write(tmp_path, "a,0,0,0")))


def test_the_command_takes_seeds(leaves_file, tmp_path) -> None:
    out, again = tmp_path / "leaves.csv", tmp_path / "again.csv"
    rows = tabulate_leaves(Opening(leaves_file), out, "truth_leaf")
    scan = read_file(leaves_file)[0]
    label = scan.attributes["truth_leaf"]
    first, second = (scan.xyz[label == k].tolist() for k in (0, 1))
    seeds = write(tmp_path, *(f"both,{x},{y},{z}" for x, y, z in (first[0], second[0])))
    merged = tabulate_leaves(Opening(leaves_file), again, "truth_leaf", seeds=seeds)
    assert len(merged) == len(rows) - 1
    both = next(row for row in merged if row["name"] == "both")
    assert both["points"] == (label == 0).sum() + (label == 1).sum()
    with pytest.raises(BadInput, match="what is read"):
        tabulate_leaves(Opening(leaves_file), seeds, "truth_leaf", overwrite=True, seeds=seeds)
