"""A brush in a plot selects; its strokes are one step each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from app.core.errors import LeafscopeError
from app.model.operations import CloseScan, Select
from app.model.points import EMPTY, PointSet
from app.model.scan import Scan
from app.model.selection import Explicit, FieldRange, Intersection
from app.services.opening import add_scans
from widgets.controller import Controller
from widgets.leaf_work import LeafWork


@pytest.fixture
def work(qapp) -> Iterator[tuple[Controller, LeafWork, str]]:
    controller, said = Controller(), []
    controller.failed.connect(said.append)
    (key,) = add_scans(controller.project, [Scan("s", np.zeros((20, 3)))])
    yield controller, LeafWork(controller), key
    controller.close()
    controller.deleteLater()
    assert said == []


def basis(stop: int) -> Intersection:
    return Intersection((FieldRange("incidence", 0.0, float(stop)), Explicit(PointSet([1]))))


def test_the_steps_of_one_stroke_are_one_step(work) -> None:
    controller, leaf_work, key = work
    before = PointSet([19])
    controller.do(Select(key, before))
    for stop in (2, 5, 9):
        leaf_work.brush(key, PointSet(range(stop)), basis(stop), "brush-1")
    leaf_work.brush(key, PointSet(range(3)), basis(3), "brush-2")
    done = controller.project.history.done
    assert [len(step.points) for step in done[1:]] == [1, 9, 3]
    assert done[-1].basis == basis(3)
    controller.undo()
    controller.undo()
    assert controller.project.state.scan(key).selection == before


def test_a_brush_over_nothing_selects_nothing(work) -> None:
    controller, leaf_work, key = work
    leaf_work.brush(key, PointSet([4]), basis(4), "brush-1")
    leaf_work.brush(key, EMPTY, basis(0), "brush-1")
    assert controller.project.state.scan(key).selection == EMPTY
    assert len(controller.project.history.done) == 2


def test_what_is_selected_already_is_no_step(work) -> None:
    controller, leaf_work, key = work
    leaf_work.brush(key, EMPTY, basis(0))
    leaf_work.brush(key, PointSet([4]), basis(4))
    leaf_work.brush(key, PointSet([4]), basis(5))
    assert len(controller.project.history.done) == 2


def test_a_scan_that_is_gone_is_left_alone(work) -> None:
    controller, leaf_work, key = work
    controller.do(CloseScan(key))
    leaf_work.brush(key, PointSet([4]), basis(4))
    leaf_work.brush("scan-00009", PointSet([4]), basis(4))
    assert controller.project.state.scan(key).selection == EMPTY


def test_errors_are_sentences(work) -> None:
    controller, leaf_work, key = work
    said: list[LeafscopeError] = []
    controller.failed.disconnect()
    controller.failed.connect(said.append)
    leaf_work.brush(key, PointSet([99]), basis(4))
    assert "not all in s" in str(said[0])
