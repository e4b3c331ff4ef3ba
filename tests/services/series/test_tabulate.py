"""Series from files to tables: angles against truth, corrections, scans that cannot be read."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled, MissingScanner, WrongUse
from app.core.progress import LiveProgress
from app.model.operations import PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.series import SeriesEntry
from app.model.view_state import Preview, ViewState
from app.services.fit import fit_table
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, open_into
from app.services.series.axis import as_record
from app.services.series.document import (
    change_series,
    correct_leaves,
    find_in_scan,
    fit_series_axis,
    make_series,
    measure_series,
    read_leaves,
    set_axis,
    turn_axis,
)
from app.services.series.order import SeriesOrder
from app.services.series.tabulate import tabulate_series
from app.services.sessions import open_session, save_session

Rows = list[dict[str, str]]


def read(path: Path) -> Rows:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def order_of(folder: Path, at: str = "_0.laz", **others: object) -> SeriesOrder:
    (first,) = folder.glob(f"*_deg{at}")
    return SeriesOrder((folder,), str(first), label_field="truth_leaf", **others)


@pytest.fixture(scope="module")
def stage_table(stage: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("table") / "stage.csv"
    table = tabulate_series(order_of(stage), out)
    assert table.axis is not None
    direction, point = np.array(table.axis.axis.direction), np.array(table.axis.axis.point)
    assert np.rad2deg(np.arccos(direction[2])) < 1.5  # vertical, through the leaf's middle
    assert np.hypot(*(point - [2.16, 0.0, 1.6])[:2]) < 1e-3
    return out


def test_a_row_for_each_leaf_and_scan(stage_table: Path) -> None:
    rows = read(stage_table)
    angles = [float(row["angle_deg"]) for row in rows]
    assert angles == [0, 15, 30, 45, 60, 75]
    assert {row["leaf"] for row in rows} == {"leaf-00001"}
    assert {row["verdict"] for row in rows} == {"sure"}
    for row, angle in zip(rows, angles, strict=True):
        assert float(row["incidence_carried_deg"]) == pytest.approx(angle, abs=1.5)
        assert float(row["incidence_plane_deg"]) == pytest.approx(angle, abs=5.0)
        assert 0 < float(row["incidence_plane_sigma_deg"]) < 2
        assert int(row["points"]) == int(row["intensity_785_n"]) > 500
    shares = [float(row["footprint_share"]) for row in rows]
    assert shares == sorted(shares)
    means = [float(row["intensity_785_mean"]) for row in rows]
    assert means == sorted(means, reverse=True)  # ever less comes back


def test_the_table_feeds_the_fit(frame: Path, tmp_path: Path) -> None:
    out = tmp_path / "frame.csv"
    table = tabulate_series(order_of(frame), out)
    assert table.axis is not None
    assert np.rad2deg(np.arccos(table.axis.axis.direction[2])) < 0.5
    rows = read(out)
    assert len(rows) == 12 * 5
    for column in ("intensity_1063_sd", "ndi_of_means", "ndi_mean_of_points", "matched_share"):
        assert all(np.isfinite(float(row[column])) for row in rows)
    report = fit_table(
        out, "incidence_plane_deg", "intensity_1545_mean", ("leaf",), "lambert-beckmann"
    )
    assert len(report.fits) == 12
    assert all(fit.n == 5 and fit.result is not None for fit in report.fits)


def test_a_profile_gives_reflectance(frame: Path, tmp_path: Path) -> None:
    from app.services.profiles import find_profile

    files = tuple(sorted(frame.glob("*_deg_?0.laz")) + list(frame.glob("*_deg_0.laz")))
    opening = Opening(Path(), profile=find_profile("salca"))
    order = SeriesOrder(
        files, str(files[-1]), label_field="truth_leaf", opening=opening, full_hits=True,
        axis="4,0,1.2,0,0,-1", angle_from="leaf_frame_angle_deg_{angle}",
    )  # fmt: skip
    table = tabulate_series(order, tmp_path / "t.csv")
    assert table.axis is not None
    assert table.axis.axis.origin == "as given, turned the other way round"
    assert table.axis.axis.direction == (0.0, 0.0, 1.0)
    for row in table.rows:
        assert 0.05 < float(row["reflectance_1545_mean"]) < 0.6
        assert float(row["reflectance_1545_sd"]) > 0
        assert int(row["reflectance_1545_n"]) <= int(row["points"])


def test_the_same_pose_needs_no_angles(stage: Path, tmp_path: Path) -> None:
    files = []
    for name in ("wet", "dry"):
        for file in stage.glob("*_0.laz*"):
            shutil.copy(file, tmp_path / file.name.replace("goniometer_angle_deg_0", name))
        files.append(tmp_path / f"{name}.laz")
    order = SeriesOrder(tuple(files), str(files[0]), label_field="truth_leaf", same_pose=True)
    table = tabulate_series(order, tmp_path / "t.csv")
    first, second = table.rows
    assert (first["label"], second["label"]) == ("wet", "dry")
    assert first["intensity_785_mean"] == pytest.approx(second["intensity_785_mean"], rel=1e-3)
    assert table.axis is None


def test_a_scan_that_cannot_be_read_does_not_stop_the_others(stage: Path, tmp_path: Path) -> None:
    folder = tmp_path / "broken"
    shutil.copytree(stage, folder)
    bad = folder / "goniometer_angle_deg_30.laz"
    bad.write_bytes(bad.read_bytes()[:300])
    table = tabulate_series(order_of(folder), tmp_path / "t.csv")
    assert table.unread == (bad.name,)
    assert table.verdicts == {"sure": 5, "unread": 1}
    (row,) = [row for row in read(tmp_path / "t.csv") if row["verdict"] == "unread"]
    assert row["angle_deg"] == "30.0"
    assert row["incidence_plane_deg"] == row["intensity_785_mean"] == ""
    assert row["reason"]


def test_cancel_leaves_what_is_done(stage: Path, tmp_path: Path) -> None:
    out, said = tmp_path / "t.csv", []
    progress = LiveProgress(
        lambda _, text: said.append(text), lambda: "Measuring goniometer_angle_deg_30.laz" in said
    )
    with pytest.raises(Cancelled):
        tabulate_series(order_of(stage, same_pose=True), out, progress=progress)
    assert len(read(out)) == 2


def say(project: Project, key: str, scan: str, leaf: str, members: PointSet | None) -> None:
    project.do(correct_leaves(project.state.series[key], scan, {leaf: members}))


def open_series(folder: Path) -> tuple[Project, str, list[str]]:
    """A session with the scans of a stage, leaves in the first, and a series of them."""
    project, scans, entries = Project(), [], []
    for angle in (0, 15, 30):
        scans += open_into(project, Opening(folder / f"goniometer_angle_deg_{angle}.laz"))
        entries.append(SeriesEntry(scans[-1], angle_deg=float(angle)))
    leaves_from_labels(project, scans[0], "truth_leaf")
    return project, make_series(project, "stage", entries, scans[0]), scans


def test_a_series_in_a_session(stage: Path, tmp_path: Path) -> None:
    project, key, scans = open_series(stage)
    reference = read_leaves(project, key)
    fit_series_axis(project, key, reference)
    assert project.state.series[key].axis.origin.startswith("fit of 3 planes, which")
    (found,) = find_in_scan(project, key, scans[2], reference)
    assert found.verdict == "sure"
    half = PointSet(found.rows[: len(found.rows) // 2])
    say(project, key, scans[2], found.leaf.key, half)
    say(project, key, scans[1], found.leaf.key, PointSet())
    rows = measure_series(project, key)
    assert [row["verdict"] for row in rows] == ["sure", "corrected", "corrected"]
    assert [row["points"] for row in rows][1:] == [0, len(half)]
    assert "intensity_785_mean" not in rows[1]

    session = tmp_path / "s.leafscope"
    save_session(project, ViewState(), session)
    headless = tabulate_series(SeriesOrder((), str(session)), tmp_path / "t.csv")
    assert headless.understood.how == "the series stage of the session"
    assert [row["points"] for row in headless.rows] == [row["points"] for row in rows]
    assert headless.rows[2]["intensity_785_mean"] == rows[2]["intensity_785_mean"]

    view = ViewState(previewed=(Preview(scans[1], found.leaf.key, half),))
    save_session(project, view, session)
    opened, shown = open_session(session)
    assert shown.previewed == ()  # what follows from others is kept in no file
    assert opened.state.series == project.state.series

    project.undo()
    project.undo()
    (again,) = find_in_scan(project, key, scans[2], reference)
    np.testing.assert_array_equal(again.rows, found.rows)
    set_axis(project, key, None)
    assert find_in_scan(project, key, scans[2], reference)[0].verdict == "check"
    with pytest.raises(WrongUse, match="reference"):
        say(project, key, scans[0], found.leaf.key, None)


def test_sessions_without_what_is_needed(stage: Path, tmp_path: Path) -> None:
    project, _, _ = open_series(stage)
    project.undo()  # no series
    session = tmp_path / "s.leafscope"
    save_session(project, ViewState(), session)
    with pytest.raises(WrongUse, match="no series of scans"):
        tabulate_series(SeriesOrder((), str(session)), tmp_path / "t.csv")
    table = tabulate_series(SeriesOrder((stage,), str(session), same_pose=True), tmp_path / "t.csv")
    assert len(table.rows) == 6
    leaf = project.state.leaves["leaf-00001"]
    project.do(PutLeaf(leaf.key, None))
    save_session(project, ViewState(), session)
    with pytest.raises(BadInput, match="no leaves"):
        tabulate_series(SeriesOrder((stage,), str(session)), tmp_path / "u.csv")


def test_bad_orders(stage: Path, tmp_path: Path) -> None:
    out = tmp_path / "t.csv"
    with pytest.raises(WrongUse, match="Name the scans"):
        SeriesOrder((), "find")
    with pytest.raises(WrongUse, match="no axis"):
        SeriesOrder((stage,), "find", axis="fit", same_pose=True)
    first = stage / "goniometer_angle_deg_0.laz"
    with pytest.raises(WrongUse, match="label-field"):
        tabulate_series(SeriesOrder((stage,), str(first)), out)
    with pytest.raises(WrongUse, match="six numbers"):
        tabulate_series(order_of(stage, axis="1,2"), out)
    with pytest.raises(BadInput):
        tabulate_series(SeriesOrder((stage,), str(tmp_path / "x.leafscope")), out)
    assert not out.exists()


def test_without_a_scanner_nothing_is_carried(stage: Path, tmp_path: Path) -> None:
    for angle in (0, 15):  # without the sidecar nobody knows where the scanner stood
        shutil.copy(stage / f"goniometer_angle_deg_{angle}.laz", tmp_path / f"a_{angle}.laz")
    order = SeriesOrder((tmp_path,), str(tmp_path / "a_0.laz"), label_field="truth_leaf")
    with pytest.raises(MissingScanner, match="carrying leaves"):
        tabulate_series(order, tmp_path / "t.csv")


def test_a_series_in_the_same_pose_is_not_turned_by_the_command(
    stage: Path, tmp_path: Path
) -> None:
    project, key, _ = open_series(stage)
    session = tmp_path / "s.leafscope"
    save_session(project, ViewState(), session)
    table = tabulate_series(SeriesOrder((), str(session)), tmp_path / "t.csv")
    assert table.axis is None
    here = measure_series(project, key)
    assert [row["points"] for row in table.rows] == [row["points"] for row in here]


def test_an_axis_is_turned_the_way_the_leaves_go(stage: Path) -> None:
    project, key, _ = open_series(stage)
    reference = read_leaves(project, key)
    fitted = fit_series_axis(project, key, reference)
    wrong = as_record(fitted.axis.reversed(), "typed")
    used = turn_axis(project, key, wrong, reference)
    assert used.origin == "typed, turned the other way round"
    assert used.direction == pytest.approx(tuple(fitted.axis.direction))
    assert project.state.series[key].axis == used


def test_another_reference_forgets_what_was_said_of_the_old_leaves(stage: Path) -> None:
    project, key, scans = open_series(stage)
    say(project, key, scans[1], "leaf-00001", PointSet())
    old = project.state.series[key]
    change_series(project, key, "other", old.entries[:2], scans[0])
    kept = project.state.series[key]
    assert (kept.name, len(kept.entries)) == ("other", 2)
    assert kept.entry(scans[1]).corrected("leaf-00001") == PointSet()
    change_series(project, key, "other", old.entries, scans[1])
    assert project.state.series[key].entry(scans[1]).corrections == ()
