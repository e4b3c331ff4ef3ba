"""The table of leaves shows what the service measures, and changes leaves."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QLineEdit

from app.model.operations import Select
from app.model.points import PointSet
from app.services.leaves import measure_leaves
from widgets.common.leaf_table import SORT
from widgets.panels.leaves import LeavesPanel


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(LeavesPanel)
    qtbot.waitUntil(panel.export_button.isEnabled, timeout=60_000)
    return panel


def cell(panel, row: int, title: str) -> str:
    model = panel.table.model()
    titles = [
        model.headerData(c, Qt.Orientation.Horizontal, Qt.ItemDataRole.DisplayRole)
        for c in range(model.columnCount())
    ]
    return model.index(row, titles.index(title)).data()


def click(panel, qtbot, row: int, keys=Qt.KeyboardModifier.NoModifier) -> None:
    place = panel.table.visualRect(panel.table.model().index(row, 0)).center()
    qtbot.mouseClick(panel.table.viewport(), Qt.MouseButton.LeftButton, keys, place)


def names(panel) -> list[str]:
    return [panel.table.model().index(r, 0).data() for r in range(panel.table.model().rowCount())]


def test_numbers_are_those_of_the_service(panel, opened) -> None:
    rows = measure_leaves(opened.controller.project, opened.controller.current)
    for place, row in enumerate(rows):
        assert cell(panel, place, "Leaf") == row["name"]
        assert cell(panel, place, "Points").replace("\u202f", "") == str(row["points"])
        assert cell(panel, place, "ω plane (°)") == f"{row['incidence_plane_deg']:.1f}"
        assert cell(panel, place, "sd of ω (°)") == f"{row['incidence_sd_deg']:.1f}"
        mean, sd = cell(panel, place, "1063 nm").split(" ± ")
        assert float(mean) == pytest.approx(row["near_mean"], abs=0.01)
        assert float(sd) == pytest.approx(row["near_sd"], abs=0.01)
        ndi = cell(panel, place, "NDI, mean of points").split(" ± ")[0]
        assert float(ndi) == pytest.approx(row["ndi_mean_of_points"], abs=0.001)
        assert float(cell(panel, place, "NDI of means")) == pytest.approx(
            row["ndi_of_means"], abs=0.001
        )
    last = panel.model.columnCount() - 1
    assert panel.model.index(0, last).data(SORT) == rows[0]["ndi_of_means"]


def test_only_points_of_leaves_are_computed(panel, opened) -> None:
    members = sum(len(leaf.members) for leaf in opened.state.leaves.values())
    assert (
        opened.controller.project.cache.computed(opened.controller.current)["incidence"] == members
    )


def test_a_row_is_the_leaf_that_panels_work_on(panel, opened, qtbot) -> None:
    click(panel, qtbot, 0)
    assert opened.controller.view.leaf == "leaf-00001"
    opened.controller.look(leaf="leaf-00002")
    qtbot.waitUntil(lambda: panel.selected == ("leaf-00002",))


def test_rename_in_the_table(panel, opened, qtbot) -> None:
    panel.table.edit(panel.table.model().index(0, 0))
    editor = panel.table.findChild(QLineEdit)
    editor.selectAll()
    qtbot.keyClicks(editor, "Flag leaf")
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: opened.state.leaves["leaf-00001"].name == "Flag leaf")
    qtbot.waitUntil(lambda: names(panel)[0] == "Flag leaf")
    opened.controller.undo()
    qtbot.waitUntil(lambda: names(panel)[0] == "Leaf 1")


def test_merge_remove_and_undo(panel, opened, qtbot) -> None:
    chosen = []
    panel.chosen.connect(chosen.append)
    click(panel, qtbot, 0)
    assert not panel.merge_button.isEnabled()
    click(panel, qtbot, 1, Qt.KeyboardModifier.ControlModifier)
    assert chosen[-1] == ("leaf-00001", "leaf-00002")
    qtbot.mouseClick(panel.merge_button, Qt.MouseButton.LeftButton)
    assert len(opened.state.leaves["leaf-00001"].members) == 5002
    qtbot.waitUntil(lambda: names(panel) == ["Leaf 1"])
    qtbot.waitUntil(lambda: cell(panel, 0, "Points").replace("\u202f", "") == "5002")
    qtbot.waitUntil(lambda: panel.selected == ("leaf-00001",))
    qtbot.mouseClick(panel.remove_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "No leaf yet" in panel.notice.text)
    opened.controller.undo()
    opened.controller.undo()
    qtbot.waitUntil(lambda: names(panel) == ["Leaf 1", "Leaf 2"])


def test_a_leaf_is_split_by_clicked_points_and_by_a_selection(panel, opened, qtbot) -> None:
    key = opened.controller.current
    click(panel, qtbot, 0)
    leaf = opened.state.leaves["leaf-00001"]
    assert not panel.split.isVisibleTo(panel)
    with qtbot.waitSignal(panel.split.pick_asked):
        qtbot.mouseClick(panel.split_button, Qt.MouseButton.LeftButton)
    assert panel.split.isVisibleTo(panel)
    rows = leaf.members.indices
    panel.split.take_point(key, int(rows[0]))
    assert not panel.split.split_button.isEnabled()
    with qtbot.waitSignal(opened.controller.said) as said:
        panel.split.take_point(key, int(rows[0]))
    assert "already" in said.args[0]
    other = opened.state.leaves["leaf-00002"].members.indices
    with qtbot.waitSignal(opened.controller.said) as said:
        panel.split.take_point(key, int(np.setdiff1d(other, rows)[0]))
    assert "no point of Leaf 1" in said.args[0]
    patch = PointSet(rows[-40:])
    opened.controller.do(Select(key, patch))
    qtbot.waitUntil(panel.split.add_button.isEnabled)
    qtbot.mouseClick(panel.split.add_button, Qt.MouseButton.LeftButton)
    assert panel.split.seeds == [PointSet(rows[:1]), patch]
    qtbot.mouseClick(panel.split.split_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "leaf-00003" in opened.state.leaves, timeout=30_000)
    one, two = opened.state.leaves["leaf-00001"].members, opened.state.leaves["leaf-00003"].members
    assert (one | two) == leaf.members
    assert (two & patch) == patch
    assert not panel.split.isVisibleTo(panel)
    opened.controller.undo()
    assert opened.state.leaves["leaf-00001"].members == leaf.members
    assert "leaf-00003" not in opened.state.leaves


def test_a_split_ends_when_its_leaf_goes_or_it_is_cancelled(panel, opened, qtbot) -> None:
    click(panel, qtbot, 0)
    panel.split_leaf()
    qtbot.mouseClick(panel.split.cancel_button, Qt.MouseButton.LeftButton)
    assert panel.split.leaf is None
    panel.split_leaf()
    panel.remove()
    qtbot.waitUntil(lambda: panel.split.leaf is None)
    panel.split.split()
    assert "leaf-00003" not in opened.state.leaves


def test_merging_and_splitting_say_what_to_choose(panel, opened, qtbot) -> None:
    panel.table.clearSelection()
    for deed in (panel.merge, panel.split_leaf):
        with qtbot.waitSignal(opened.controller.said) as said:
            deed()
        assert "in the table" in said.args[0]


def test_steep_parts_by_intensity_need_a_curve(panel, opened, qtbot) -> None:
    with qtbot.waitSignal(opened.controller.said) as said:
        panel.steep_box.setChecked(True)
    assert "curve" in said.args[0]
    assert not panel.steep_box.isChecked()
    assert not panel.areas.by_intensity


def test_select_points_and_make_a_leaf_of_them(panel, opened, qtbot) -> None:
    click(panel, qtbot, 0)
    qtbot.mouseClick(panel.select_button, Qt.MouseButton.LeftButton)
    assert opened.controller.scan.selection == opened.state.leaves["leaf-00001"].members
    key = opened.controller.current
    opened.controller.do(Select(key, PointSet([1, 2, 3, 4, 5])))
    qtbot.mouseClick(panel.new_button, Qt.MouseButton.LeftButton)
    assert opened.state.leaves["leaf-00003"].members == PointSet([1, 2, 3, 4, 5])
    qtbot.waitUntil(lambda: panel.selected == ("leaf-00003",))


def test_new_leaf_without_selection_waits_for_the_lasso(panel, opened, qtbot) -> None:
    with qtbot.waitSignal(opened.controller.said):
        qtbot.mouseClick(panel.new_button, Qt.MouseButton.LeftButton)
    assert opened.controller.view.leaf is None
    qtbot.waitUntil(lambda: panel.selected == ())


def test_leaves_can_be_found_without_a_scanner(desk, qtbot, make_scan) -> None:
    panel = desk.show(LeavesPanel)
    desk.open(make_scan(pose=False))
    qtbot.waitUntil(panel.find_button.isEnabled)
    with qtbot.waitSignal(desk.controller.said, timeout=60_000) as said:
        qtbot.mouseClick(panel.find_button, Qt.MouseButton.LeftButton)
    assert said.args == [f"{len(desk.state.leaves)} leaves found."]


def test_find_leaves(desk, qtbot, make_scan) -> None:
    panel = desk.show(LeavesPanel)
    assert not panel.find_button.isEnabled()
    desk.open(make_scan())
    qtbot.waitUntil(panel.find_button.isEnabled)
    qtbot.mouseClick(panel.find_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: len(desk.state.leaves) > 0, timeout=60_000)
    qtbot.waitUntil(panel.export_button.isEnabled, timeout=30_000)
    assert len(names(panel)) == len(desk.state.leaves)


def test_export_writes_all_numbers(panel, opened, qtbot, tmp_path) -> None:
    path = tmp_path / "leaves.csv"
    qtbot.mouseClick(panel.export_button, Qt.MouseButton.LeftButton)
    dialog = panel.findChild(QFileDialog)
    dialog.fileSelected.emit(str(path))
    dialog.close()
    with path.open(newline="") as file:
        written = list(csv.DictReader(file))
    rows = measure_leaves(opened.controller.project, opened.controller.current)
    assert [row["name"] for row in written] == ["Leaf 1", "Leaf 2"]
    for stored, row in zip(written, rows, strict=True):
        assert float(stored["ndi_of_means"]) == row["ndi_of_means"]
        assert float(stored["incidence_plane_deg"]) == row["incidence_plane_deg"]


def test_without_a_position_channels_are_measured_and_angles_are_missing(
    desk, qtbot, make_scan
) -> None:
    panel = desk.show(LeavesPanel)
    desk.make_halves(desk.open(make_scan(pose=False)))
    qtbot.waitUntil(panel.export_button.isEnabled, timeout=30_000)
    assert cell(panel, 0, "ω plane (°)") == "–"
    assert "±" in cell(panel, 0, "1063 nm")
    assert "where the scanner stood" in panel.notice.text
