from __future__ import annotations

import numpy as np
import pytest

from app.model.operations import AddScan, MarkGhosts
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.services.cleaning import correct_ghosts, delete_ghosts, mark_ghosts

KEY = "scan-00001"


@pytest.fixture
def project(leaves: Scan) -> Project:
    project = Project()
    project.do(AddScan(project.shelve(leaves), "leaves", None))
    return project


def test_most_ghosts_are_found_and_few_points_are_called_so(project: Project) -> None:
    mark_ghosts(project, KEY)
    truth = project.state.scan(KEY).scan.attributes["truth_ghost"]
    marked = project.state.scan(KEY).marks == 1
    assert marked[truth == 1].mean() > 0.6
    assert marked[truth == 0].mean() < 0.05


def test_deleting_is_a_mask_that_undo_lifts(project: Project, leaves: Scan) -> None:
    count = delete_ghosts(project, KEY)
    assert project.state.scan(KEY).shown == len(leaves) - count
    project.undo()
    assert project.state.scan(KEY).shown == len(leaves)


def test_corrected_ghosts_come_nearer_to_a_surface(project: Project, leaves: Scan) -> None:
    corrected, left = correct_ghosts(project, KEY)
    after = project.state.scan(KEY)
    moved = np.flatnonzero(np.any(after.scan.xyz != leaves.xyz, axis=1))
    assert 0 < len(moved) <= corrected
    assert np.count_nonzero(after.marks == 1) == left
    eye = np.array(leaves.pose.position)
    before = leaves.xyz[moved] - eye
    now = after.scan.xyz[moved] - eye
    along = np.abs(np.einsum("ij,ij->i", before, now))
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(now, axis=1)
    np.testing.assert_allclose(along, lengths, rtol=1e-9)  # moved along the beam only
    project.undo()
    np.testing.assert_array_equal(project.state.scan(KEY).scan.xyz, leaves.xyz)
    assert not project.state.scan(KEY).marks.any()


def test_what_the_user_keeps_is_not_deleted(project: Project) -> None:
    ghosts = np.flatnonzero(project.field(KEY, "ghost") == 1)
    project.do(MarkGhosts(KEY, kept=PointSet(ghosts[:3])))
    delete_ghosts(project, KEY)
    assert not project.state.scan(KEY).deleted[ghosts[:3]].any()
