"""The controller between worker and window: nothing gets lost, nothing stale is shown."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from app.core.progress import Progress
from app.formats.options import ReadOptions
from app.model.leaf import Leaf
from app.model.operations import PutLeaf, Select, SetParameters, SetPose
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.model.selection import Explicit, FieldRange, evaluate
from app.model.view_state import ViewState
from app.services.opening import add_scans
from widgets.controller import Controller
from widgets.documents import Documents
from widgets.leaf_work import LeafWork

KEY = "scan-00001"


@pytest.fixture
def controller(qtbot: QtBot, leaves: Scan) -> Iterator[Controller]:
    controller = Controller()
    add_scans(controller.project, [leaves])
    controller.look(current=KEY)
    yield controller
    controller.close()


@pytest.fixture
def gate(controller: Controller) -> Iterator[threading.Event]:
    """Holds the worker back until it is set."""
    event = threading.Event()
    controller.run("Waiting", lambda _: event.wait(20), lambda _: None)
    yield event
    event.set()


def set_radius(controller: Controller, radius: float) -> None:
    old = controller.project.state.scan(KEY).parameters
    controller.do(SetParameters(KEY, msgspec.structs.replace(old, radius=radius)))


def finish(controller: Controller, qtbot: QtBot) -> None:
    qtbot.waitUntil(lambda: not controller.bridge.jobs, timeout=30_000)


def is_complete(controller: Controller, field: str) -> bool:
    known = controller.project.known_field(KEY, field)
    return known is not None and known.covers(None)


def test_a_parameter_that_changes_during_the_work_is_not_forgotten(
    controller: Controller, gate: threading.Event, qtbot: QtBot
) -> None:
    controller.look(colour="incidence")
    set_radius(controller, 0.02)
    gate.set()
    finish(controller, qtbot)
    assert is_complete(controller, "incidence")
    # What was asked for with the old radius was cancelled before it began.
    assert controller.project.cache.computed(KEY)["incidence"] == len(controller.scan.scan)


def test_a_colour_is_computed_whole_though_a_panel_asked_for_a_part(
    controller: Controller, gate: threading.Event, qtbot: QtBot
) -> None:
    controller.want(KEY, "incidence", np.arange(50))
    controller.look(colour="incidence")
    controller.want(KEY, "incidence", np.arange(20, 70))
    gate.set()
    finish(controller, qtbot)
    assert is_complete(controller, "incidence")


def test_what_waits_for_a_field_finds_it_valid(
    controller: Controller, gate: threading.Event, qtbot: QtBot
) -> None:
    seen = []
    controller.want(KEY, "incidence", None, lambda: seen.append(is_complete(controller, "range")))
    controller.want(KEY, "incidence", np.arange(9), lambda: seen.append("part"))
    controller.want(KEY, "ghost", None, lambda: seen.append(is_complete(controller, "ghost")))
    set_radius(controller, 0.02)
    controller.want(KEY, "ghost")
    gate.set()
    qtbot.waitUntil(lambda: len(seen) == 3, timeout=30_000)
    assert sorted(map(str, seen)) == ["False", "True", "part"]
    assert is_complete(controller, "incidence")


def test_what_fails_is_told_once_and_not_at_every_step(
    controller: Controller, qtbot: QtBot
) -> None:
    told = []
    controller.failed.connect(told.append)
    controller.do(SetPose(KEY, None))
    controller.look(colour="incidence")
    finish(controller, qtbot)
    controller.look(point_size=3.0)
    controller.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "one", PointSet([1, 2]))))
    finish(controller, qtbot)
    assert len(told) == 1


def test_a_scan_that_went_is_not_asked_for(controller: Controller, qtbot: QtBot) -> None:
    controller.want(KEY, "range")
    controller.undo()
    controller.want(KEY, "range", None, lambda: pytest.fail("there is nothing to wait for"))
    finish(controller, qtbot)
    assert controller.project.cache.known(KEY) == {}


def test_another_document_hears_nothing_of_the_old_ones_jobs(
    controller: Controller, qtbot: QtBot
) -> None:
    job = controller.run("Quick", lambda _: 7, lambda _: pytest.fail("too late"))
    deadline = threading.Event()
    while not job.over:
        deadline.wait(0.01)
    controller.adopt(Project(), ViewState())  # its result has not arrived yet
    finish(controller, qtbot)


def test_services_of_the_window_run_in_the_worker(
    controller: Controller, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    import app.core.segments as segments

    threads = []
    original = segments.segment_leaves

    def watch(*arguments: object, **named: object) -> object:
        threads.append(threading.current_thread())
        return original(*arguments, **named)

    monkeypatch.setattr(segments, "segment_leaves", watch)
    work = LeafWork(controller)
    work.find_all()
    qtbot.waitUntil(lambda: bool(controller.project.state.leaves), timeout=30_000)
    assert [thread.name for thread in threads] == ["leafscope-worker"]
    assert [step.title for step in controller.project.history.done][1].startswith("Find ")
    controller.undo()
    assert not controller.project.state.leaves


def test_leaves_are_found_without_a_position_of_the_scanner(
    controller: Controller, qtbot: QtBot
) -> None:
    controller.do(SetPose(KEY, None))
    told = []
    controller.failed.connect(told.append)
    LeafWork(controller).find_all()
    qtbot.waitUntil(lambda: bool(controller.project.state.leaves), timeout=30_000)
    assert not told


def test_a_service_works_again_when_the_document_went_on(
    controller: Controller, gate: threading.Event, qtbot: QtBot
) -> None:
    runs = []

    def service(aside: Project, progress: Progress) -> int:
        runs.append(len(aside.state.leaves))
        key = f"leaf-{len(aside.state.leaves) + 1:05d}"
        aside.do(PutLeaf(key, Leaf(key, KEY, "made", PointSet([5]))))
        return len(runs)

    done = []
    controller.carry_out(KEY, "Making", service, done.append)
    controller.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "mine", PointSet([1]))))
    gate.set()
    qtbot.waitUntil(lambda: bool(done), timeout=10_000)
    assert runs == [0, 1]
    names = [leaf.name for leaf in controller.project.state.leaves.values()]
    assert names == ["mine", "made"]


def test_fitting_a_leaf_that_is_undone_meanwhile_is_a_sentence(
    controller: Controller, gate: threading.Event, qtbot: QtBot
) -> None:
    members = PointSet.from_mask(controller.scan.scan.attributes["truth_leaf"] == 1)
    controller.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "one", members)))
    told = []
    controller.failed.connect(told.append)
    LeafWork(controller).fit(["leaf-00001"], "lambert", "reflectance_1063")
    controller.undo()
    gate.set()
    qtbot.waitUntil(lambda: bool(told), timeout=30_000)
    assert "no leaf-00001" in str(told[0])
    assert not controller.project.state.fits


def test_a_stored_selection_gives_the_same_points_again(controller: Controller) -> None:
    work, scan = LeafWork(controller), controller.scan.scan
    distance = controller.project.field(KEY, "range")
    near = FieldRange("range", 0.0, float(np.quantile(distance, 0.2)))
    points = PointSet.from_mask(distance <= near.high)
    work.apply(KEY, PointSet(range(1000)), Explicit(PointSet(range(1000))), "select")
    for combine in ("add", "subtract"):
        work.apply(KEY, points, near, "select", combine)
        step = controller.project.history.done[-1]
        assert isinstance(step, Select)
        again = evaluate(step.basis, scan.xyz, controller.scan.alive, lambda _: distance)
        assert again == controller.scan.selection


def test_reading_again_keeps_the_scan_when_it_fails(
    controller: Controller, leaves_file: Path, tmp_path: Path, qtbot: QtBot
) -> None:
    documents = Documents(controller)
    documents.open([leaves_file])
    finish(controller, qtbot)
    key, path = controller.current, Path(controller.scan.scan.source.path)
    moved = path.rename(tmp_path / "away.laz")
    told = []
    controller.failed.connect(told.append)
    documents.reopen(key, ReadOptions(every_nth=2))
    finish(controller, qtbot)
    moved.rename(path)
    assert told
    assert not controller.project.state.scan(key).closed
    documents.reopen(key, ReadOptions(every_nth=2))
    finish(controller, qtbot)
    assert controller.project.state.scan(key).closed
    assert controller.current != key


def test_an_export_is_of_the_moment_it_was_asked_for(
    controller: Controller, gate: threading.Event, tmp_path: Path, qtbot: QtBot
) -> None:
    controller.do(Select(KEY, PointSet(range(10))))
    out = tmp_path / "o.npz"
    Documents(controller).export(out, "selection", ["range"])
    controller.do(Select(KEY, PointSet(range(500))))
    gate.set()
    finish(controller, qtbot)
    with np.load(out) as written:
        assert len(written["xyz"]) == len(written["range"]) == 10
        assert "Select 10 points" in str(written["provenance"])
