from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.model.history import Entry, settle
from app.model.operations import AddScan, MarkGhosts, SetDeleted, SetParameters
from app.model.parameters import Parameters
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan


@pytest.fixture
def project() -> Project:
    project = Project()
    key = project.shelve(Scan("s", np.zeros((10, 3))))
    project.do(AddScan(key, "s", None))
    return project


def test_the_steps_of_a_drag_are_one_step(project: Project) -> None:
    for radius in (0.005, 0.006, 0.007):
        project.do(SetParameters("scan-00001", Parameters(radius=radius), drag="radius-1"))
    assert len(project.history.done) == 2
    project.undo()
    assert project.state.scan("scan-00001").parameters.radius == Parameters().radius
    project.redo()
    assert project.state.scan("scan-00001").parameters.radius == 0.007


def test_another_drag_is_another_step(project: Project) -> None:
    project.do(SetParameters("scan-00001", Parameters(radius=0.005), drag="radius-1"))
    project.do(SetParameters("scan-00001", Parameters(radius=0.006), drag="radius-2"))
    assert len(project.history.done) == 3


def test_the_log_keeps_what_was_undone_and_overwritten(project: Project) -> None:
    project.do(SetDeleted("scan-00001", PointSet([1])))
    project.undo()
    project.do(SetDeleted("scan-00001", PointSet([2])))
    assert [entry.deed for entry in project.history.log] == ["do", "do", "undo", "do"]
    assert not project.history.undone


def test_deleting_twice_is_undone_once(project: Project) -> None:
    project.do(SetDeleted("scan-00001", PointSet([1, 2])))
    project.do(SetDeleted("scan-00001", PointSet([2, 3])))
    project.undo()
    assert np.flatnonzero(project.state.scan("scan-00001").deleted).tolist() == [1, 2]


def test_points_outside_the_scan_are_refused_and_change_nothing(project: Project) -> None:
    before = project.state
    with pytest.raises(WrongUse, match="not all in s, which has 10"):
        project.do(MarkGhosts("scan-00001", ghosts=PointSet([10])))
    assert project.state is before
    assert len(project.history.log) == 1


def test_oldest_inverses_go_to_disk_first(project: Project) -> None:
    project.history._cap = 500
    for step in range(8):
        project.do(SetDeleted("scan-00001", PointSet(range(step + 1)), deleted=step % 2 == 0))
    on_disk = [isinstance(step.inverse, Path) for step in project.history._done]
    assert 0 < project.history.on_disk < len(on_disk)
    assert on_disk == sorted(on_disk, reverse=True)
    for _ in range(8):
        project.undo()
    assert not project.state.scan("scan-00001").deleted.any()


def test_modified_follows_the_log(project: Project) -> None:
    project.saved_at = len(project.history.log)
    assert not project.modified
    project.do(SetDeleted("scan-00001", PointSet([1])))
    assert project.modified


@pytest.mark.parametrize("deeds", [["undo"], ["redo"], ["do", "undo", "undo"]])
def test_a_log_that_takes_back_too_much_is_refused(deeds: list[str]) -> None:
    step = SetDeleted("scan-00001", PointSet([1]))
    log = [Entry(deed, step if deed == "do" else None) for deed in deeds]
    with pytest.raises(BadInput, match="too many"):
        settle(log)


def test_lost_undo_data_is_a_sentence_and_no_step_is_lost(project: Project) -> None:
    project.history._cap = 0
    project.do(SetDeleted("scan-00001", PointSet([1, 2])))
    project.do(SetDeleted("scan-00001", PointSet([3])))
    project.undo()
    project.history._done[-1].inverse.unlink()
    with pytest.raises(BadInput, match="undo data"):
        project.undo()
    assert len(project.history.done) == 2
