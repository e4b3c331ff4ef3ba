"""From the scan image to the 3-D view and back, by mouse and keys in the real window."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from app.render.scan_image.frame import Frame

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
LEFT, PLAIN = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
FLAT_LEAF = 1  # of the row of known tilts


def pull(view: Any, upper_left: tuple[float, float], lower_right: tuple[float, float]) -> None:
    """A rectangle from row and column to row and column."""
    start, end = (view.place_of(*corner).toPoint() for corner in (upper_left, lower_right))
    QTest.mousePress(view, LEFT, PLAIN, start)
    for spot in ((start + end) / 2, end):
        QTest.mouseMove(view, spot)
        QTest.qWait(5)
    QTest.mouseRelease(view, LEFT, PLAIN, end)


def find_box(view: Any, members: np.ndarray) -> tuple[tuple[int, int], tuple[int, int]]:
    """Rows and columns around points, with one to spare."""
    row, column = np.divmod(view.image.layout.pixel[members], view.image.layout.columns)
    return (row.min() - 1, column.min() - 1), (row.max() + 1, column.max() + 1)


def test_scan_image(user: Any) -> None:
    window, controller = user.window, user.window.controller
    user.click(window.welcome.demo)
    user.wait_for(lambda: controller.current is not None)
    user.rest()
    dock = window.docks.docks["scan_image"]
    assert dock.isHidden()
    user.keys("I")
    user.wait_for(dock.isVisible)
    user.rest()
    assert window.table.actions["view.scan_image"].isChecked()
    assert dock.height() > 0.25 * window.height()
    panel = window.docks.panels["scan_image"]
    view = panel.view
    state = controller.scan
    assert view.image.shown <= state.shown
    user.look("scan-image")

    # A leaf is selected in the image and lights up in the 3-D view.
    truth = np.flatnonzero(state.scan.attributes["truth_leaf"] == FLAT_LEAF)
    user.tool("tool.rectangle")
    pull(view, *find_box(view, truth))
    user.rest()
    selected = controller.scan.selection
    assert set(truth.tolist()) <= set(selected.indices.tolist())
    assert controller.scene.clouds[0].overlay[0].thing is selected
    user.look("scan-image-selection")
    user.keys("Ctrl+Z")
    user.rest()
    assert len(controller.scan.selection) == 0
    assert view.paint.lit == []

    # The lasso of the 3-D view lights up in the image.
    user.tool("tool.lasso")
    user.lasso([QPointF(0.3, 0.3), QPointF(0.6, 0.3), QPointF(0.6, 0.6), QPointF(0.3, 0.6)])
    found = controller.scan.selection.indices
    assert len(found)
    assert np.array_equal(view.paint.lit[0], view.image.light(found))

    # A leaf is made here too, and the wheel and the double click serve the eye.
    user.tool("lasso.leaf")
    user.tool("tool.rectangle")
    pull(view, *find_box(view, truth))
    user.rest()
    (leaf,) = controller.project.state.leaves.values()
    assert set(truth.tolist()) <= set(leaf.members.indices.tolist())
    user.tool("tool.navigate")
    middle = view.rect().center()
    QTest.mouseDClick(view, LEFT, PLAIN, middle)
    assert view.frame == Frame.fit(view.image.layout, (view.width(), view.height()))

    # A click picks the point that is shown, for the panel of the point as well.
    row, column = view.image.pixel_of(int(truth[len(truth) // 2]))
    QTest.mouseClick(view, LEFT, PLAIN, view.place_of(row, column).toPoint())
    user.rest()
    picked = window.picture.picker.point
    assert picked is not None
    assert picked[0] == controller.current
    assert view.marked == view.image.pixel_of(picked[1])
    assert window.docks.panels["pick"].isVisible()

    user.keys("I")
    user.wait_for(dock.isHidden)
    assert not window.table.actions["view.scan_image"].isChecked()
