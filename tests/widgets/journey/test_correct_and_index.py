"""Correct channels, write an index, smooth the view: by mouse and keys on the demo scan."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QScrollArea, QWidget

from app.services.synthetic_footprints import spread_of_index
from widgets.common.aside import copy_aside
from widgets.dialogs.formulas import FormulasDialog

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
LEFT = Qt.MouseButton.LeftButton


def show(panel: QWidget, widget: QWidget) -> None:
    """Scroll to a part of a panel."""
    panel.findChild(QScrollArea).ensureWidgetVisible(widget)
    QTest.qWait(50)


def press(user: Any, panel: QWidget, widget: QWidget, place: QPoint | None = None) -> None:
    show(panel, widget)
    user.click(widget, place)
    user.rest()


def test_correct_then_index_then_footprint(user: Any) -> None:
    window, controller = user.window, user.window.controller
    user.click(window.welcome.demo)
    user.wait_for(lambda: controller.current is not None)
    user.rest()
    window.table.actions["scan.find_leaves"].trigger()
    user.rest()
    correct_all_channels(user)
    write_an_index(user)
    compare_angles(user)
    smooth_the_view(user)
    while controller.project.history.done and "Find" not in last_step(user):
        if controller.project.history.done[-1].title.startswith("Make"):
            break
        controller.undo()
    user.rest()
    assert not controller.scan.parameters.corrections
    assert controller.scan.parameters.synthetic_footprint is None


def last_step(user: Any) -> str:
    return user.window.controller.project.history.done[-1].title


def correct_all_channels(user: Any) -> None:
    controller = user.window.controller
    panel = user.panel("correct")
    user.wait_for(lambda: panel.preview is not None)
    press(user, panel, panel.form.every)
    user.wait_for(lambda: panel.preview is not None and len(panel.preview.made) == 4)
    user.look("correct-preview")
    press(user, panel, panel.correct_button)
    names = {c.name for c in controller.scan.parameters.corrections}
    assert names == {f"reflectance_{nm}_wf{n}" for nm in (1063, 1545) for n in (2, 3)}
    user.wait_for(lambda: panel.preview is not None and bool(panel.colours.buttons))
    user.rest()
    press(user, panel, panel.colours.buttons["reflectance_1063_wf2"])
    assert controller.view.colour == "reflectance_1063_wf2"
    user.look("correct-wf2")
    user.colour_by("ndi_wf2")  # the corrected channels are there for indices too
    press(user, panel, panel.colours.buttons["reflectance_1063_wf2_mark"])
    user.look("correct-marks")


def write_an_index(user: Any) -> None:
    window, controller = user.window, user.window.controller
    panel = user.panel("index")
    user.rest()
    user.click(panel.form.own_button)
    (dialog,) = window.findChildren(FormulasDialog)
    user.wait_for(dialog.isVisible)
    QTest.keyClicks(dialog.name, "mine")
    dialog.text.setFocus()
    QTest.keyClicks(dialog.text, "r1063 / r1545")
    dialog.text.completion.popup().hide()
    user.wait_for(lambda: "points" in dialog.values.text())
    user.look("own-index")
    user.click(dialog.save_button)
    dialog.reject()
    user.rest()
    assert [f.name for f in controller.scan.parameters.formulas] == ["mine"]
    names = [panel.form.index_box.itemData(i) for i in range(panel.form.index_box.count())]
    assert {"ndi", "ndi_wf2", "ndi_wf3", "mine", "mine_wf2"} <= set(names)
    assert "mine_wf3" in controller.project.catalogue(controller.current)


def compare_angles(user: Any) -> None:
    panel = user.window.docks.panels["index"]
    panel.form.leaves_box.setFocus()
    QTest.keyClick(panel.form.leaves_box, Qt.Key.Key_Down)  # all leaves together
    user.rest()
    user.wait_for(lambda: panel.angles.found is not None and len(panel.angles.found.rows) == 1)
    user.look("index-angle")
    row = panel.angles.found.rows[0]
    assert row["fitted_min"] < row["index_mean"] < row["fitted_max"]


def smooth_the_view(user: Any) -> None:
    controller = user.window.controller
    panel = user.window.docks.panels["index"]
    user.click(panel.tabs, panel.tabs.tabRect(1).center())
    user.rest()
    press(user, panel, panel.footprint.measure_button)
    user.wait_for(lambda: panel.footprint.found is not None)
    key, project = controller.current, copy_aside(controller.project, controller.current)
    leaves = [leaf.key for leaf in project.state.leaves_of(key)]
    wanted = spread_of_index(project, key, panel.form.index, leaves=leaves)
    assert panel.footprint.found.rows == wanted.rows
    user.look("footprint-spread")
    user.colour_by("ndi")
    slider = panel.footprint.smoothing.slider
    show(panel, slider)
    slider.setFocus()
    for _ in range(5):
        QTest.keyClick(slider, Qt.Key.Key_PageUp)
        QTest.qWait(120)
    user.rest()
    assert controller.view.colour == "ndi_smoothed"
    smooth = project_values(user, "ndi_smoothed")
    assert np.nanstd(smooth) < np.nanstd(project_values(user, "ndi"))
    user.look("footprint-smoothed")


def project_values(user: Any, field: str) -> np.ndarray:
    controller = user.window.controller
    return controller.project.field(controller.current, field)
