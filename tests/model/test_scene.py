"""Leaves that are shown though they are none of the document's."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.leaf import Leaf
from app.model.operations import AddScan, PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.model.scene import differences, resolve
from app.model.view_state import Preview, ViewState
from app.render.picture import ProjectSource, leaf_colour


@pytest.fixture
def two_scans() -> tuple[Project, str, str]:
    project, keys = Project(), []
    for name in ("first", "second"):
        scan = Scan(name, np.zeros((5, 3)), {}, (), None, None)
        keys.append(project.shelve(scan))
        project.do(AddScan(keys[-1], name, None))
    return project, keys[0], keys[1]


def test_a_preview_lies_over_its_own_scan_only(two_scans: tuple[Project, str, str]) -> None:
    project, first, second = two_scans
    plain = ViewState()
    shown = ViewState(previewed=(Preview(second, "leaf-00003", PointSet([1, 2])),))
    before, after = resolve(project, plain), resolve(project, shown)
    assert differences(before, after) == {second: frozenset({"overlay"})}
    assert differences(after, resolve(project, shown)) == {}
    source = ProjectSource(project, shown)
    (mark,) = source.overlay(second).leaves
    assert (mark.key, list(mark.members)) == ("leaf-00003", [1, 2])
    assert mark.colour == leaf_colour("leaf-00003")
    assert source.overlay(first).leaves == []


def test_previews_are_shown_beside_leaves_of_the_document(
    two_scans: tuple[Project, str, str],
) -> None:
    project, first, _ = two_scans
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", first, "own", PointSet([0]), ())))
    previewed = (Preview(first, "leaf-00002", PointSet([4])),)
    view = ViewState(show_leaves=True, previewed=previewed)
    marks = ProjectSource(project, view).overlay(first).leaves
    assert [mark.key for mark in marks] == ["leaf-00001", "leaf-00002"]
    only = ViewState(show_leaves=False, previewed=previewed)
    assert [m.key for m in ProjectSource(project, only).overlay(first).leaves] == ["leaf-00002"]
