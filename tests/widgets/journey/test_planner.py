"""A scan is planned, then a leaf of a real one is taken for the plan and its footprints seen."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
FLAT_LEAF = 1  # of the row of known tilts


def type_into(field: Any, text: str) -> None:
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)


def scroll_to(panel: Any, widget: Any) -> None:
    from widgets.common.panel import Column

    panel.findChild(Column).ensureWidgetVisible(widget)
    QTest.qWait(50)


def test_planner(user: Any, tmp_path: Path) -> None:
    window, controller = user.window, user.window.controller

    # Without any scan: an instrument, a leaf, an answer.
    panel = user.panel("planner")
    user.wait_for(lambda: panel.plan is not None)
    type_into(panel.form.length, "60")
    type_into(panel.form.width_field, "21.9")
    type_into(panel.form.position, "2.16")
    user.wait_for(lambda: panel.plan is not None and panel.plan.order.width < 0.022)
    user.rest()
    assert "usable at 2.2 m" in panel.sentence.text()
    user.look("planner")

    # The table is written where the user says.
    scroll_to(panel, panel.table_button)
    user.press("Save table…", panel)
    user.name_file(tmp_path / "plan.csv")
    user.wait_for((tmp_path / "plan.csv").exists)
    with (tmp_path / "plan.csv").open(newline="") as file:
        row = next(
            row for row in csv.DictReader(file)
            if row["range_m"] == "2.16" and row["omega_deg"] == "65"
        )  # fmt: skip
    assert float(row["footprint_mm"]) == pytest.approx(9.596, abs=0.001)

    # A scan: a click on a point is the position.
    user.click(window.welcome.demo)
    user.wait_for(lambda: controller.current is not None)
    user.rest()
    user.tool("tool.pick")
    state, view = controller.scan, window.picture.view
    members = np.flatnonzero(state.scan.attributes["truth_leaf"] == FLAT_LEAF)
    front = state.scan.xyz[members, 0]
    members = members[np.abs(front - np.median(front)) < 0.03]  # ghosts lie far behind
    spot = place_of(view, np.median(state.scan.xyz[members], axis=0))
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=spot)
    user.rest()
    scan, picked = window.picture.picker.point
    away = np.linalg.norm(state.scan.xyz[picked] - state.scan.pose.position)
    assert scan == controller.current
    assert panel.form.position.value() == pytest.approx(away, abs=0.006)

    # A leaf by lasso: its size goes into the plan, its footprints into the picture.
    user.tool("lasso.leaf")
    user.tool("tool.lasso")
    low, high = state.scan.xyz[members].min(axis=0), state.scan.xyz[members].max(axis=0)
    corners = [
        (low[1], low[2]), (high[1], low[2]), (high[1], high[2]), (low[1], high[2])
    ]  # fmt: skip
    middle = float(np.median(state.scan.xyz[members, 0]))
    spots = [place_of(view, np.array([middle, y, z])) for y, z in corners]
    user.lasso([QPointF(s.x() / view.width(), s.y() / view.height()) for s in spots])
    assert len(controller.project.state.leaves) == 1
    panel = user.panel("planner")
    user.rest()
    scroll_to(panel, panel.take_button)
    user.click(panel.take_button)
    user.rest()
    assert 50.0 < panel.form.length.value() < 110.0
    scroll_to(panel, panel.switch.beam_button)
    user.click(panel.switch.beam_button)
    user.rest()
    assert controller.scan.parameters.beam == panel.form.tool.beam
    action = window.table.actions["view.footprints"]
    assert not action.isChecked()
    action.trigger()
    user.wait_for(lambda: window.footprints.rings is not None)
    user.rest()
    assert action.isChecked()
    assert panel.switch.shown.isChecked()
    rings = window.footprints.rings
    widest = np.linalg.norm(rings[:, :18] - rings[:, 18:], axis=2).max(axis=1)
    assert 0.003 < np.median(widest) < 0.02
    window.picture.fit_selection()
    user.look("planner-footprints")

    # Fewer of them, then none; undo takes the beam back and with it the drawing.
    panel.switch.every.setFocus()
    type_into(panel.switch.every, "16")
    user.wait_for(lambda: window.footprints.rings is not None
                  and len(window.footprints.rings) < len(rings))  # fmt: skip
    action.trigger()
    user.wait_for(lambda: window.footprints.rings is None)
    user.keys("Ctrl+Z")
    user.rest()
    assert controller.scan.parameters.beam is None


def place_of(view: Any, xyz: np.ndarray) -> Any:
    """Pixels of the view at which a point is drawn."""
    from PySide6.QtCore import QPoint

    from app.core.screen import project

    seen = view.current_view()
    x, y = project(xyz[None], seen.origin, seen.matrix, seen.size).px[0]
    return QPoint(round(x / seen.size[0] * view.width()), round(y / seen.size[1] * view.height()))
