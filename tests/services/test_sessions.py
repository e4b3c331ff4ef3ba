"""Sessions: saved, reopened, replayed to the same numbers."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput
from app.formats.session import Session, write
from app.model.history import Entry
from app.model.operations import AddScan, CloseScan, Select, SetPose
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan, Source
from app.model.view_state import ViewState
from app.services.cleaning import correct_ghosts, mark_ghosts
from app.services.curves import fit_leaves, use_fit
from app.services.export import export, gather
from app.services.leaves import leaves_from_labels, measure_leaves
from app.services.opening import Opening, add_scans, open_file
from app.services.reading import read_file
from app.services.sessions import open_session, replay, save_session

KEY = "scan-00001"
VIEW = ViewState(current=KEY, colour="delta_omega")


@pytest.fixture
def worked(leaves_file: Path, tmp_path: Path) -> tuple[Project, Path]:
    """A project in which the main job was done, and the file that it came from."""
    source = tmp_path / "data" / "leaves.laz"
    source.parent.mkdir()
    for file in leaves_file.parent.iterdir():
        shutil.copy(file, source.parent / file.name)
    project, _ = open_file(Opening(source))
    keys = leaves_from_labels(project, KEY, "truth_leaf")
    use_fit(project, fit_leaves(project, KEY, keys[:2], "lambert-beckmann"))
    fit_leaves(project, KEY, (), "cosine")
    mark_ghosts(project, KEY)
    correct_ghosts(project, KEY)
    return project, source


def test_replay_gives_the_same_numbers_bit_for_bit(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    project, _ = worked
    session, out = tmp_path / "s.leafscope", tmp_path / "replayed"
    save_session(project, VIEW, session)
    report = replay(session, out)
    assert [fit["same"] for fit in report["fits"]] == [True, True]

    export(gather(project, KEY, ["delta_omega"]), tmp_path / "window.npz")
    with (
        np.load(tmp_path / "window.npz") as window,
        np.load(out / report["scans"][0]["file"]) as headless,
    ):
        assert set(window.files) == set(headless.files)
        for name in set(window.files) - {"provenance"}:
            assert window[name].tobytes() == headless[name].tobytes(), name
        assert np.isfinite(headless["delta_omega"]).any()

    with (out / report["scans"][0]["table"]).open(newline="") as file:
        rows = list(csv.DictReader(file))
    expected = measure_leaves(project, KEY)
    assert len(rows) == len(expected)
    for row, leaf in zip(rows, expected, strict=True):
        for name in ("incidence_plane_deg", "ndi_of_means"):
            # An empty cell is a leaf without a plane.
            assert leaf[name] == (float(row[name]) if row[name] else None)
    assert any(row["incidence_plane_deg"] for row in rows)
    assert json.loads((out / "report.json").read_text())["scans"] == report["scans"]


def test_undo_works_after_saving_and_reopening(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    project, _ = worked
    project.undo()
    save_session(project, VIEW, tmp_path / "s.leafscope")
    again, view = open_session(tmp_path / "s.leafscope")
    assert view == VIEW
    assert not again.modified
    assert [s.title for s in again.history.done] == [s.title for s in project.history.done]
    again.redo()
    project.redo()
    np.testing.assert_array_equal(again.state.scan(KEY).scan.xyz, project.state.scan(KEY).scan.xyz)
    while again.history.done:
        again.undo()
    assert not again.state.scans


def test_a_moved_source_is_found_beside_the_session(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    project, source = worked
    session = tmp_path / "elsewhere" / "s.leafscope"
    session.parent.mkdir()
    save_session(project, VIEW, session)
    source.rename(tmp_path / "lost.laz")
    with pytest.raises(BadInput, match="not there") as refused:
        open_session(session)
    assert "leaves.laz back" in str(refused.value)
    shutil.move(tmp_path / "lost.laz", session.parent / "leaves.laz")
    shutil.move(f"{source}.leafscope.json", session.parent)
    assert open_session(session)[0].state.scans.keys() == {KEY}


def test_a_changed_source_is_refused(worked: tuple[Project, Path], tmp_path: Path) -> None:
    project, source = worked
    save_session(project, VIEW, tmp_path / "s.leafscope")
    broken = bytearray(source.read_bytes())
    broken[90] ^= 1  # a letter of the name of the program that wrote it
    source.write_bytes(broken)
    with pytest.raises(BadInput, match="content has changed"):
        open_session(tmp_path / "s.leafscope")


def test_a_changed_sidecar_is_refused(worked: tuple[Project, Path], tmp_path: Path) -> None:
    project, source = worked
    save_session(project, VIEW, tmp_path / "s.leafscope")
    Path(f"{source}.leafscope.json").unlink()
    with pytest.raises(BadInput, match="has changed or is gone"):
        open_session(tmp_path / "s.leafscope")


def test_a_scan_from_no_file_cannot_be_saved(leaves: Scan, tmp_path: Path) -> None:
    project = Project()
    add_scans(project, [leaves])
    with pytest.raises(BadInput, match="came from no file"):
        save_session(project, VIEW, tmp_path / "s.leafscope")
    assert list(tmp_path.iterdir()) == []


def test_a_scan_that_was_taken_back_for_good_is_not_missed(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    project, source = worked
    other = tmp_path / "other.xyz"
    other.write_text("0 0 1\n0 1 1\n1 0 1\n1 1 1.1\n")
    add_scans(project, read_file(other))
    project.undo()
    project.do(Select(KEY, PointSet([1])))
    session = tmp_path / "s.leafscope"
    save_session(project, VIEW, session)
    other.unlink()
    again, _ = open_session(session)
    assert again.state.library.keys() == {KEY}
    # It can be saved and opened once more, and new scans may take the free key.
    add_scans(again, read_file(source))
    save_session(again, VIEW, session)
    assert len(open_session(session)[0].state.scans) == 2


def test_replay_says_which_scan_cannot_be_coloured(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    project, source = worked
    (other,) = add_scans(project, read_file(source))
    project.do(SetPose(other, None))
    save_session(project, ViewState(colour="incidence"), tmp_path / "s.leafscope")
    report = replay(tmp_path / "s.leafscope", tmp_path / "out")
    first, second = report["scans"]
    assert first["missing"] is None
    assert "position is unknown" in second["missing"]
    with np.load(tmp_path / "out" / first["file"]) as written:
        assert "incidence" in written.files


def test_replay_over_older_results_is_refused_before_anything_is_written(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    project, _ = worked
    save_session(project, VIEW, tmp_path / "s.leafscope")
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.json").write_text("precious")
    with pytest.raises(BadInput, match="exists already"):
        replay(tmp_path / "s.leafscope", out)
    assert [file.name for file in out.iterdir()] == ["report.json"]


def test_several_scans_of_one_file_and_a_closed_one_come_back(tmp_path: Path) -> None:
    rows = "\n".join(f"{i} {j} 1 0.5 10 10 10" for i in range(3) for j in range(2))
    head = "2\n3\n0 0 {z}\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 {z} 1\n"
    source = tmp_path / "two.ptx"
    source.write_text("".join(head.format(z=z) + rows + "\n" for z in (5, 7)))
    project, keys = open_file(Opening(source))
    assert len(keys) == 2
    project.do(CloseScan(keys[0]))
    save_session(project, VIEW, tmp_path / "s.leafscope")
    again, _ = open_session(tmp_path / "s.leafscope")
    assert [scan.closed for scan in again.state.scans.values()] == [True, False]
    for key in keys:
        assert again.state.scan(key).scan.pose == project.state.scan(key).scan.pose
    report = replay(tmp_path / "s.leafscope", tmp_path / "out")
    assert len(report["scans"]) == 1


def test_options_that_make_no_sense_are_a_damaged_session(
    worked: tuple[Project, Path], tmp_path: Path
) -> None:
    _, source = worked
    for options in ({"every_nth": '"two"'}, {"strange": "1"}, {"every_nth": "{"}):
        bad = Source(str(source), 1, "ab", 0, options)
        log = [Entry("do", AddScan(KEY, "leaves", bad))]
        write(tmp_path / "s.leafscope", Session({KEY: bad}, log, VIEW), overwrite=True)
        with pytest.raises(BadInput, match="damaged"):
            open_session(tmp_path / "s.leafscope")
