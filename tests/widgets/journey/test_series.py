"""A goniometer in the real window: a folder becomes a series, a table, and its fits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton, QTableWidget, QWidget

from app.core.screen import project as project_points
from app.services.leaves import leaves_from_labels
from app.services.series.order import SeriesOrder
from app.services.series.tabulate import tabulate_series
from app.services.simulation import Targets
from app.services.simulation_order import Order
from app.services.simulation_series import simulate_series
from widgets.dialogs.series import SeriesDialog
from widgets.panels.series import CARRY, SCANS, TABLE

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
ANGLES = (0, 15, 30, 45, 60)


def open_tab(user: Any, panel: QWidget, tab: int) -> None:
    bar = panel.tabs
    user.click(bar, bar.tabRect(tab).center())
    user.rest()


def choose_row(user: Any, table: QTableWidget, row: int) -> None:
    item = table.item(row, 0)
    table.scrollToItem(item)
    user.click(table.viewport(), table.visualItemRect(item).center())
    user.rest()


def around_half(user: Any, leaf: np.ndarray) -> list[QPointF]:
    """A contour around the upper half of points, as shares of the view."""
    view = user.window.picture.view.current_view()
    px = project_points(leaf, view.origin, view.matrix, view.size).px / np.array(view.size)
    (left, top), (right, bottom) = px.min(axis=0) - 0.01, px.max(axis=0) + 0.01
    middle = (top + bottom) / 2
    corners = ((left, top), (right, top), (right, middle), (left, middle), (left, top))
    return [QPointF(x, y) for x, y in corners]


def see(panel: QWidget, button: QPushButton) -> QPushButton:
    """Scroll to a button of the panel."""
    from widgets.common.panel import Column

    panel.findChild(Column).ensureWidgetVisible(button)
    QTest.qWait(30)
    return button


def test_a_goniometer_from_its_folder_to_its_table(user: Any, tmp_path: Path) -> None:
    folder, window = tmp_path / "stage", user.window
    simulate_series(Order("goniometer"), "stage.angle_deg=0:60:15", Targets(folder))
    window.desk.series.offer_folder(folder)
    (dialog,) = window.findChildren(SeriesDialog)
    user.wait_for(dialog.start.isEnabled)
    assert dialog.pattern.text() == "goniometer_angle_deg_{angle}"
    assert "5 scans with" in dialog.facts.text()
    user.click(dialog.start)
    user.wait_for(lambda: bool(window.controller.project.state.series))
    window.activateWindow()  # no window manager does it after a dialog
    user.rest()
    panel, project = window.docks.panels["series"], window.controller.project
    series = panel.series
    assert [entry.angle_deg for entry in series.entries] == list(ANGLES)
    scans = [entry.scan for entry in series.entries]
    assert window.controller.current == series.reference == scans[0]
    leaves_from_labels(project, scans[0], "truth_leaf")
    user.rest()

    assert panel.tabs.currentIndex() == SCANS
    user.click(see(panel, panel.about.axis.fit_button))
    user.rest()
    assert panel.series.axis.origin.startswith("fit of 5 planes")

    open_tab(user, panel, CARRY)
    page = panel.carrying
    user.click(see(panel, page.steps.next))
    user.click(page.steps.next)
    user.rest()
    assert window.controller.current == scans[2]
    assert set(window.controller.view.hidden) == set(scans) - {scans[2]}
    (found,) = page.list.found
    assert found.verdict == "sure"
    (preview,) = window.controller.view.previewed
    assert preview.scan == scans[2]
    np.testing.assert_array_equal(preview.members.indices, found.rows)
    user.look("series_carried")

    choose_row(user, page.list.table, 0)
    user.click(see(panel, page.list.confirm_button))
    user.rest()
    assert page.list.found[0].verdict == "corrected"
    np.testing.assert_array_equal(page.list.found[0].rows, found.rows)

    user.click(see(panel, page.steps.next))
    user.rest()
    (whole,) = page.list.found
    user.tool("tool.lasso")
    xyz = window.controller.scan.scan.xyz
    user.lasso(around_half(user, xyz[whole.rows]))
    taken = window.controller.scan.selection
    assert 0 < len(np.intersect1d(taken.indices, whole.rows)) < len(whole.rows)
    choose_row(user, page.list.table, 0)
    user.click(see(panel, page.list.take_button))
    user.rest()
    assert panel.series.entry(scans[3]).corrected("leaf-00001") == taken
    assert len(window.controller.scan.selection) == 0
    user.keys("Ctrl+Z")
    user.rest()
    assert panel.series.entry(scans[3]).corrections == ()
    assert window.controller.scan.selection == taken
    assert page.list.found[0].verdict == "sure"
    user.keys("Ctrl+Shift+Z")
    user.rest()

    open_tab(user, panel, TABLE)
    user.click(panel.table.measure_button)
    user.rest()
    assert [row["angle_deg"] for row in panel.table.rows] == list(ANGLES)
    user.click(see(panel, panel.table.fit_button))
    user.rest()
    assert panel.table.fits.rowCount() == 1
    user.look("series_table")
    user.click(see(panel, panel.table.export_button))
    user.name_file(tmp_path / "window.csv")

    session = tmp_path / "s.leafscope"
    assert window.documents.save(session)
    tabulate_series(SeriesOrder((), str(session)), tmp_path / "command.csv")
    assert (tmp_path / "window.csv").read_bytes() == (tmp_path / "command.csv").read_bytes()
