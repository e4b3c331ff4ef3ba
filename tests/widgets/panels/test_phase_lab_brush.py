"""What is brushed in the plot is selected everywhere; what is selected elsewhere lights up."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt

from app.model.points import EMPTY, PointSet
from app.model.selection import Explicit, evaluate
from widgets.panels.phase_lab import PhaseLabPanel

LEFT, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton


@pytest.fixture
def lab(opened, qtbot):
    panel = opened.show(PhaseLabPanel)
    qtbot.waitUntil(lambda: panel.editor.points.count > 0, timeout=60_000)
    return panel


def place(lab, angle: float, value: float) -> QPoint:
    plot = lab.plots.plot
    return plot.mapFromScene(plot.box.mapViewToScene(QPointF(angle, value)))


def drag(lab, qtbot, start, stop, button=LEFT, keys=Qt.KeyboardModifier.NoModifier) -> None:
    viewport = lab.plots.plot.viewport()
    begin, end = place(lab, *start), place(lab, *stop)
    qtbot.mousePress(viewport, button, keys, begin)
    for step in np.linspace(0.2, 1.0, 5):
        at = begin + (end - begin) * float(step)
        qtbot.mouseMove(viewport, at)
        qtbot.wait(40)  # longer than the plot waits between two moves
    qtbot.mouseRelease(viewport, button, keys, end)
    qtbot.wait(20)


def limits(lab) -> tuple[float, float]:
    return lab.plots.plot.box._bands["angles"].getRegion()


def expect(lab, inside: np.ndarray) -> PointSet:
    return PointSet(lab.editor.points.measured.point[inside])


def test_a_range_of_angles_is_one_step_and_can_be_found_again(lab, opened, qtbot) -> None:
    steps = len(opened.controller.project.history.done)
    qtbot.mouseClick(lab.plots.tools.angles, LEFT)
    drag(lab, qtbot, (20.0, 0.3), (40.0, 0.4))
    state = opened.controller.scan
    low, high = limits(lab)
    assert low == pytest.approx(20.0, abs=0.6)
    assert high == pytest.approx(40.0, abs=0.6)
    points = lab.editor.points
    assert state.selection == expect(lab, (points.angle >= low) & (points.angle <= high))
    assert len(state.selection) > 100
    history = opened.controller.project.history
    assert len(history.done) == steps + 1
    project, key = opened.controller.project, opened.controller.current
    found = evaluate(
        history.done[-1].basis,
        state.scan.xyz,
        state.alive,
        lambda name: project.field(key, name),
    )
    assert found == state.selection
    opened.controller.undo()
    assert opened.controller.scan.selection == EMPTY
    qtbot.waitUntil(lambda: lab.plots.plot._lit is None)


def test_intensities_and_rectangles_add_and_take_away(lab, opened, qtbot) -> None:
    qtbot.mouseClick(lab.plots.tools.values, LEFT)
    drag(lab, qtbot, (30.0, 0.30), (35.0, 0.40))
    first = opened.controller.scan.selection
    value = lab.editor.points.value
    low, high = lab.plots.plot.box._bands["values"].getRegion()
    assert first == expect(lab, (value >= low) & (value <= high))
    qtbot.mouseClick(lab.plots.tools.both, LEFT)
    drag(lab, qtbot, (2.0, 0.42), (20.0, 0.7), keys=Qt.KeyboardModifier.ShiftModifier)
    more = opened.controller.scan.selection
    assert len(more) > len(first)
    assert len(first - more) == 0
    drag(lab, qtbot, (2.0, 0.42), (20.0, 0.7), keys=Qt.KeyboardModifier.ControlModifier)
    assert len(opened.controller.scan.selection) < len(more)


def test_a_selection_made_elsewhere_lights_up(lab, opened, qtbot) -> None:
    members = opened.state.leaves[opened.controller.view.leaf].members
    some = PointSet(members.indices[:300])
    opened.work.apply(opened.controller.current, some, Explicit(some), "select")
    qtbot.waitUntil(lambda: lab.plots.plot._lit is not None)
    lit = lab.editor.points.measured.point[lab.plots.plot._lit]
    assert set(lit) == set(some.indices) & set(lab.editor.points.measured.point)
    drawn, _ = lab.plots.plot._lit_dots.getData()
    assert len(drawn) == len(lit) > 200


@pytest.mark.parametrize("way", ["escape", "double click", "button"])
def test_the_selection_can_be_cleared(lab, opened, qtbot, way) -> None:
    qtbot.mouseClick(lab.plots.tools.angles, LEFT)
    drag(lab, qtbot, (20.0, 0.3), (40.0, 0.4))
    assert len(opened.controller.scan.selection)
    viewport = lab.plots.plot.viewport()
    if way == "escape":
        qtbot.keyClick(lab.plots.plot, Qt.Key.Key_Escape)
    elif way == "button":
        qtbot.mouseClick(lab.plots.tools.clear, LEFT)
    else:
        spot = place(lab, 60.0, 0.3)
        qtbot.mouseClick(viewport, LEFT, pos=spot)
        qtbot.mouseDClick(viewport, LEFT, pos=spot)
    qtbot.waitUntil(lambda: opened.controller.scan.selection == EMPTY)
    steps = len(opened.controller.project.history.done)
    qtbot.keyClick(lab.plots.plot, Qt.Key.Key_Escape)
    assert len(opened.controller.project.history.done) == steps


def test_without_a_brush_the_plot_moves_and_with_one_the_right_button_moves_it(
    lab, opened, qtbot
) -> None:
    box = lab.plots.plot.box
    before = box.viewRange()
    drag(lab, qtbot, (30.0, 0.3), (40.0, 0.3))
    moved = box.viewRange()
    assert moved[0][0] < before[0][0] - 5
    assert opened.controller.scan.selection == EMPTY
    qtbot.mouseClick(lab.plots.tools.angles, LEFT)
    drag(lab, qtbot, (40.0, 0.3), (30.0, 0.3), button=RIGHT)
    assert box.viewRange()[0][0] > moved[0][0] + 5
    assert opened.controller.scan.selection == EMPTY
    qtbot.mouseClick(lab.plots.tools.all, LEFT)
    np.testing.assert_allclose(box.viewRange()[0], before[0], atol=0.5)
