"""From raw numbers to reflectance in the real window: draw panels, calibrate, use, save, reopen."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit, QMessageBox, QScrollArea, QWidget

from app.core.screen import project as project_points
from app.services.simulation import Targets, simulate_file
from app.services.simulation_order import Order
from widgets.common.calibration.panel_list import RHO
from widgets.panels.calibration import BUDGET, POWER

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
PICTURES = os.environ.get("LEAFSCOPE_PICTURES")
LEFT = Qt.MouseButton.LeftButton
RHOS = (0.99, 0.5, 0.25, 0.12)  # of the ready scene, from left to right
NAME = "reflectance_1550"
STEP = 0.03


def spots(user: Any, surface: int) -> np.ndarray:
    """Where the points of a panel are in the view, as fractions."""
    view = user.window.picture.view.current_view()
    scan = user.window.controller.scan.scan
    there = scan.attributes["truth_surface"] == surface
    px = project_points(scan.xyz[there], view.origin, view.matrix, view.size).px
    return px / np.array(view.size)


def outline(user: Any, surface: int) -> list[QPointF]:
    """A square just inside a panel."""
    places = spots(user, surface)
    low, high = np.nanquantile(places, (0.02, 0.98), axis=0)
    centre, reach = (low + high) / 2, (high - low) / 2 * 0.85
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
    return [QPointF(*(centre + reach * np.array(corner))) for corner in corners]


def give_reflectances(user: Any, table: QWidget) -> None:
    """Type into the cells of the list of panels."""
    for row, rho in enumerate(RHOS):
        place = table.visualItemRect(table.item(row, RHO)).center()
        user.click(table.viewport(), place)
        first, rest = str(rho)[0], str(rho)[1:]
        QTest.keyClicks(table, first)  # typing begins to edit
        user.wait_for(lambda: table.findChild(QLineEdit) is not None)
        QTest.keyClicks(table.findChild(QLineEdit), rest)
        QTest.keyClick(table.findChild(QLineEdit), Qt.Key.Key_Return)
        user.wait_for(lambda: table.findChild(QLineEdit) is None)


def open_tab(user: Any, panel: QWidget, tab: int) -> None:
    user.click(panel.tabs, panel.tabs.tabRect(tab).center())
    user.wait_for(panel._pages[tab].isVisible)
    user.rest()


def show_other_looks(user: Any, panel: QWidget) -> None:
    """The pages in the dark, and small."""
    bar = panel.findChild(QScrollArea).verticalScrollBar()
    for theme, width, height in (("dark", 1480, 940), ("dark", 1024, 700), ("light", 1024, 700)):
        user.window.table.actions[f"theme.{theme}"].trigger()
        user.window.resize(width, height)
        for tab, name in enumerate(("make", "power", "budget")):
            panel.tabs.setCurrentIndex(tab)
            user.rest()
            bar.setValue(bar.minimum())
            user.look(f"calibration-{name}-{theme}-{width}")
            bar.setValue(bar.maximum())
            user.look(f"calibration-{name}-end-{theme}-{width}")


def test_raw_numbers_become_reflectance(user: Any, tmp_path: Path) -> None:
    window, controller = user.window, user.window.controller
    path = tmp_path / "panels.ply"
    simulate_file(Order("panels", "x330", step_deg=STEP), Targets(path))
    window.documents.open([path])
    user.wait_for(lambda: controller.current is not None)
    key = controller.current
    window.activateWindow()
    panel = user.panel("calibration")
    user.look("calibration-empty")

    user.tool("lasso.leaf")
    user.tool("tool.lasso")
    for surface in range(4):
        user.lasso(outline(user, surface))
    QTest.keyClick(window, Qt.Key.Key_Escape)
    surfaces = controller.scan.scan.attributes["truth_surface"]
    leaves = list(controller.project.state.leaves.values())
    assert [round(np.mean(surfaces[leaf.members.indices])) for leaf in leaves] == [0, 1, 2, 3]

    give_reflectances(user, panel.making.panels)
    user.press("Calibrate", panel)
    user.wait_for(lambda: panel.making.fit.report is not None)
    user.look("calibration-fit")
    (found,) = panel.making.fit.report.channels
    assert found.calibration.fit.found.steps[-1].a0 == pytest.approx(1200.0, rel=0.03)
    assert controller.scan.parameters.profile is None
    user.press("Use this profile", panel)
    user.wait_for(lambda: controller.scan.parameters.profile is not None)

    user.colour_by(NAME)
    user.wait_for(lambda: panel.counts is not None)
    panel.findChild(QScrollArea).verticalScrollBar().setValue(0)
    user.look("calibration-reflectance")
    project = controller.project
    values = project.known_field(key, NAME).values
    truth = controller.scan.scan.attributes["truth_reflectance_1550"]
    for surface in (1, 2, 3):
        mine = (surfaces == surface) & np.isfinite(values)
        assert np.mean(values[mine]) == pytest.approx(np.mean(truth[mine]), rel=0.02)
    assert panel.counts["saturated"] > 1000
    user.colour_by(f"{NAME}_mark")
    user.look("calibration-marks")

    open_tab(user, panel, POWER)
    box = panel.power.leaf
    box.setCurrentIndex(1)
    box.activated.emit(1)
    field = panel.power.rho
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.5\r")
    user.press("Measure power", panel)
    user.wait_for(panel.power.use_button.isEnabled)
    user.look("calibration-power")
    user.press("Use this power", panel)
    (power,) = controller.scan.parameters.powers
    assert power.value == pytest.approx(1.0, abs=0.02)

    open_tab(user, panel, BUDGET)
    user.tool("tool.pick")
    view, middle = window.picture.view, np.nanmedian(spots(user, 2), axis=0)
    user.click(view, QPoint(*(int(c) for c in middle * (view.width(), view.height()))))
    user.wait_for(lambda: NAME in panel.budget.channels)
    user.wait_for(lambda: bool(panel.budget.channels[NAME].bars.shares))
    user.rest()
    shares = panel.budget.channels[NAME].bars.shares
    assert shares["all together"] > shares["noise"] > 0.0
    assert shares["power"] > 0.0
    point = {name: value for name, value, _ in window.docks.panels["pick"]._values}
    value, sigma = point["Reflectance, 1550 nm"].split(" ± ")
    assert 100.0 * float(sigma) == pytest.approx(shares["all together"], rel=0.05)
    assert float(value) == pytest.approx(0.25, abs=0.05)
    user.look("calibration-budget")

    parameters = controller.scan.parameters
    titles = [step.title for step in project.history.done]
    user.keys("Ctrl+Z")
    user.keys("Ctrl+Z")
    user.rest()
    assert controller.scan.parameters.profile is None
    user.look("calibration-undone")
    user.keys("Ctrl+Shift+Z")
    user.keys("Ctrl+Shift+Z")
    user.rest()
    assert controller.scan.parameters == parameters
    assert [step.title for step in project.history.done] == titles
    before = project.field(key, NAME)

    session = tmp_path / "work.leafscope"
    window.desk.files.dialogs.folder = tmp_path
    user.keys("Ctrl+S")
    user.name_file(session)
    user.keys("Ctrl+N")
    user.rest()
    assert controller.current is None
    user.keys("Ctrl+O")
    user.name_file(session)
    user.wait_for(lambda: controller.current == key)
    assert controller.scan.parameters == parameters
    np.testing.assert_array_equal(controller.project.field(key, NAME), before)
    user.rest()
    assert not [box for box in window.findChildren(QMessageBox) if box.isVisible()]
    if PICTURES:
        controller.look(leaf=leaves[2].key)
        panel.budget.of.setCurrentIndex(1)
        panel.refresh_soon()
        show_other_looks(user, panel)
