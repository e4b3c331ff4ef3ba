"""A simulated scan from the menu to its truth in colours, by mouse and keys."""

from __future__ import annotations

import os
from typing import Any

import pytest
from PySide6.QtWidgets import QPushButton

from app.simulate.scene_file import list_scenes
from widgets.dialogs.simulate import SimulateDialog

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
SCENES = list_scenes() if os.environ.get("LEAFSCOPE_PICTURES") else ("leaf_row",)
STEPS = {"crown": 0.05, "pear_row": 0.05, "scattered": 0.03, "drying": 0.03, "leaf_frame": 0.05}


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_is_simulated_opened_and_coloured_by_its_truth(
    user: Any, tmp_path: Any, scene: str
) -> None:
    window = user.window
    window.table.actions["file.simulate"].trigger()
    (dialog,) = window.findChildren(SimulateDialog)
    rows = [dialog.scenes.topLevelItem(k) for k in range(dialog.scenes.topLevelItemCount())]
    dialog.scenes.setCurrentItem(next(row for row in rows if row.text(0) == scene))
    dialog.step.setValue(STEPS.get(scene, 0.018))
    user.wait_for(lambda: not window.controller.bridge.jobs)
    button = next(b for b in dialog.findChildren(QPushButton) if "Simulate" in b.text())
    user.wait_for(button.isEnabled)
    user.click(button)
    user.name_file(tmp_path / f"{scene}.laz")
    user.wait_for(lambda: window.controller.view.current is not None)
    user.look(f"scene_{scene}_intensity")
    for field in ("truth_incidence", "truth_ghost"):
        user.colour_by(field)
        user.look(f"scene_{scene}_{field}")
    project = window.controller.project
    (found,) = project.state.scans
    values = project.field(found, "truth_ghost", None)
    assert len(values) > 100
    assert scene != "leaf_row" or values.max() >= 1  # a coarse scan of needles has none
