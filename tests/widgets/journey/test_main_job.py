"""The main job by mouse and keys in the real window, on the demo scan, then replayed headless."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QMessageBox,
)

from app.cli import run
from app.core.screen import project as project_points
from app.services.leaves import measure_leaves
from widgets.dialogs.export import ExportDialog

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
PICTURES = os.environ.get("LEAFSCOPE_PICTURES")
LEFT = Qt.MouseButton.LeftButton
PATIENCE = 60_000
LAST_OF_ROW = 5
ROW_LEAF = 2  # of the row of known tilts: flat, 30°, nothing before it


def outline(user: Any, leaf: int) -> list[QPointF]:
    """A contour just inside a leaf of the simulation, as fractions of the view."""
    view = user.window.picture.view.current_view()
    scan = user.window.controller.scan.scan
    truth = scan.attributes["truth_leaf"] == leaf
    px = project_points(scan.xyz[truth], view.origin, view.matrix, view.size).px
    low, high = np.nanmin(px, axis=0), np.nanmax(px, axis=0)
    centre, reach = (low + high) / 2, (high - low) / 2 * 0.85
    turns = np.linspace(0, 2 * np.pi, 40)
    return [
        QPointF(*(centre + reach * (np.cos(t), np.sin(t))) / np.array(view.size)) for t in turns
    ]


def show_other_looks(user: Any) -> None:
    """The window in the dark, and small."""
    user.window.table.actions["theme.dark"].trigger()
    user.look("dark")
    user.window.resize(1024, 700)
    user.look("small-dark")
    user.window.table.actions["theme.light"].trigger()
    user.panel("phase_lab")
    user.look("small")


def select_row_of_known_tilts(user: Any) -> None:
    """Click the leaves of the row in the table, holding Ctrl."""
    state, panel = user.window.controller.project.state, user.window.docks.panels["leaves"]
    truth = user.window.controller.scan.scan.attributes["truth_leaf"]
    table = panel.table
    modifier = Qt.KeyboardModifier.NoModifier
    for row in range(table.model().rowCount()):
        index = table.model().index(row, 0)
        leaf = next(leaf for leaf in state.leaves.values() if leaf.name == index.data())
        if 0 <= np.median(truth[leaf.members.indices]) <= LAST_OF_ROW and row:
            table.scrollTo(index)
            place = table.visualRect(index).center()
            QTest.mouseClick(table.viewport(), LEFT, modifier, place)
            modifier = Qt.KeyboardModifier.ControlModifier
    user.rest()


def test_main_job(user: Any, tmp_path: Path) -> None:
    window, controller = user.window, user.window.controller
    user.look("welcome")
    user.click(window.welcome.demo)
    user.wait_for(lambda: controller.current is not None)
    key = controller.current
    scan = controller.scan.scan
    user.look("window-intensity")
    view = window.picture.view
    QTest.mousePress(view, LEFT, pos=QPoint(300, 300))
    QTest.mouseMove(view, QPoint(330, 310))
    QTest.mouseRelease(view, LEFT, pos=QPoint(330, 310))
    user.rest()
    assert "incidence" not in controller.project.cache.computed(key)
    user.keys("Ctrl+Home")
    user.rest()

    user.colour_by("incidence")
    assert controller.project.cache.computed(key)["incidence"] == len(scan)
    user.look("window")

    user.tool("lasso.leaf")
    user.tool("tool.lasso")
    user.lasso(outline(user, ROW_LEAF))
    (leaf,) = controller.project.state.leaves.values()
    truth = scan.attributes["truth_leaf"][leaf.members.indices]
    assert np.mean(truth == ROW_LEAF) > 0.95
    assert len(leaf.members) > 0.5 * np.count_nonzero(scan.attributes["truth_leaf"] == ROW_LEAF)
    user.lasso(outline(user, ROW_LEAF + 2), Qt.KeyboardModifier.ShiftModifier)
    user.lasso(outline(user, ROW_LEAF + 2), Qt.KeyboardModifier.ControlModifier)
    assert set(controller.project.state.leaves) == {leaf.key}
    user.look("leaf")
    QTest.keyClick(window, Qt.Key.Key_Escape)

    user.press("Find leaves", user.panel("leaves"))
    user.wait_for(lambda: len(controller.project.state.leaves) > 15)
    user.look("leaves")

    select_row_of_known_tilts(user)
    lab = user.panel("phase_lab")
    points = lab.choice.points_box
    points.setCurrentIndex(points.findText("Selected leaves"))
    user.rest()
    user.press("Fit", lab)
    user.wait_for(lambda: bool(controller.project.state.fits))
    user.look("fit")
    user.press("Use this curve", lab)
    user.wait_for(lambda: controller.scan.parameters.curve is not None)
    curve = controller.scan.parameters.curve
    assert curve.model == "lambert-beckmann"

    wrinkles = user.panel("wrinkles")
    user.rest()
    user.press("Measure wrinkles", wrinkles)
    user.wait_for(lambda: wrinkles.measuring.find(key) is not None)
    user.look("wrinkles")
    assert "may be brighter or darker by 8 %" in wrinkles.claim.text()
    user.scroll_to(wrinkles, wrinkles.colour_button)
    user.press("Colour the cloud by Δω", wrinkles)
    user.wait_for(lambda: controller.view.colour == "wrinkle_delta")
    assert np.isfinite(controller.project.known_field(key, "wrinkle_delta").values).any()
    user.colour_by("delta_omega")  # this one a replay can compute
    user.look("delta_omega")

    ghosts = user.panel("ghosts")
    user.rest()
    if controller.project.known_field(key, "ghost_score") is None:
        user.press("Compute score", ghosts)
    user.rest()
    user.press("Mark", ghosts)
    user.wait_for(lambda: bool(controller.scan.marks.any()))
    user.look("ghosts")

    titles = [step.title for step in controller.project.history.done]
    before = measure_leaves(controller.project, key)
    user.panel("history")
    user.look("history")
    for _ in titles:
        user.keys("Ctrl+Z")
    user.rest()
    assert not controller.project.state.scans
    user.look("all-undone")
    for _ in titles:
        user.keys("Ctrl+Shift+Z")
    user.rest()
    assert [step.title for step in controller.project.history.done] == titles
    controller.look(current=key)
    assert measure_leaves(controller.project, key) == before

    session = tmp_path / "work.leafscope"
    window.desk.files.dialogs.folder = tmp_path
    user.keys("Ctrl+S")
    user.name_file(session)
    assert session.is_file()
    assert not window.isWindowModified()
    user.keys("Ctrl+N")
    user.rest()
    assert controller.current is None
    user.keys("Ctrl+O")
    user.name_file(session)
    user.wait_for(lambda: controller.current == key)
    assert measure_leaves(controller.project, key) == before
    user.look("reopened")

    exported = tmp_path / "window.npz"
    user.keys("Ctrl+E")
    user.wait_for(lambda: window.findChild(ExportDialog) is not None)
    dialog = window.findChild(ExportDialog)
    dialog.format.setCurrentIndex(dialog.format.findData(".npz"))
    for row in range(dialog.fields.count()):
        item = dialog.fields.item(row)
        wanted = item.data(Qt.ItemDataRole.UserRole) == "delta_omega"
        item.setCheckState(Qt.CheckState.Checked if wanted else Qt.CheckState.Unchecked)
    user.look("export")
    dialog.accept()
    user.name_file(exported)
    user.wait_for(exported.is_file)
    user.rest()
    assert not [box for box in window.findChildren(QMessageBox) if box.isVisible()]

    if PICTURES:
        show_other_looks(user)
    out = tmp_path / "replayed"
    assert run(["replay", str(session), "--out", str(out)]) == 0
    (headless,) = out.glob("*.npz")
    with np.load(exported) as mine, np.load(headless) as other:
        assert set(mine.files) == set(other.files)
        for name in set(mine.files) - {"provenance"}:
            assert mine[name].tobytes() == other[name].tobytes(), name
        assert np.isfinite(mine["delta_omega"]).any()
