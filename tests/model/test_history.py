from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.model.history import Entry, settle
from app.model.operations import AddScan, MarkGhosts, Select, SetDeleted, SetParameters
from app.model.parameters import Parameters
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.model.selection import FieldRange


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


def brush(project: Project, stop: int, drag: str = "brush-1") -> None:
    basis = FieldRange("range", 0.0, float(stop))
    project.do(Select("scan-00001", PointSet(range(stop)), basis, drag))


def test_a_brush_is_one_step_and_one_line_of_the_log(project: Project) -> None:
    project.do(Select("scan-00001", PointSet([9])))
    for stop in (2, 4, 7):
        brush(project, stop)
    assert len(project.history.done) == 3
    assert len(project.history.log) == 3
    assert project.history.log[-1].operation is project.history.done[-1]
    project.undo()
    assert project.state.scan("scan-00001").selection == PointSet([9])
    project.redo()
    assert project.state.scan("scan-00001").selection == PointSet(range(7))


def test_a_brush_after_undo_keeps_the_lines_that_undo_refers_to(project: Project) -> None:
    brush(project, 2)
    project.do(SetDeleted("scan-00001", PointSet([1])))
    project.undo()
    brush(project, 5)
    assert [entry.deed for entry in project.history.log] == ["do", "do", "do", "undo", "do"]
    done, undone = settle(project.history.log)
    assert tuple(done) == project.history.done
    assert undone == []


@pytest.mark.parametrize("other", ["brush-2", ""])
def test_another_brush_is_another_step(project: Project, other: str) -> None:
    brush(project, 2)
    brush(project, 3, other)
    assert len(project.history.done) == 3


def test_a_parameter_between_two_strokes_parts_them(project: Project) -> None:
    brush(project, 2)
    project.do(SetParameters("scan-00001", Parameters(radius=0.005), drag="brush-1"))
    brush(project, 3)
    assert len(project.history.done) == 4


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
    project.saved_at = project.history.deeds
    assert not project.modified
    project.do(SetDeleted("scan-00001", PointSet([1])))
    assert project.modified


def test_a_drag_that_goes_on_after_saving_is_a_change(project: Project) -> None:
    brush(project, 2)
    project.saved_at = project.history.deeds
    brush(project, 3)
    assert len(project.history.log) == 2
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
