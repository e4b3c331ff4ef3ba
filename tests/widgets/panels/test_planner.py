"""The planner: what it answers, what it takes from the scan, what it refuses in words."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.core.mixing import PulseMixing
from app.model.operations import SetParameters
from app.services.plan_texts import tell_range
from app.services.planning import make_plan
from widgets.common.plan_form import FULL, PULSED
from widgets.panels.planner import PlannerPanel


def settle(panel, qtbot) -> None:
    """Wait for the pause after a change, and for the plan."""
    bridge = panel.controller.bridge
    qtbot.waitUntil(
        lambda: not panel._pause.isActive() and not panel._later.isActive() and not bridge.jobs,
        timeout=30_000,
    )


@pytest.fixture
def planner(desk, qtbot) -> PlannerPanel:
    panel = desk.show(PlannerPanel)
    settle(panel, qtbot)
    return panel


def type_into(field, text: str, qtbot) -> None:
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, text)
    qtbot.keyClick(field, Qt.Key.Key_Return)


def test_it_answers_without_a_scan(planner, qtbot) -> None:
    plan = planner.plan
    assert plan.order.tool.title == "FARO LS880"
    here = next(row for row in plan.rows if row.range_m == 4.0)
    assert planner.sentence.text() == tell_range(here)
    assert planner.table.rowCount() == len(plan.rows)
    texts = [planner.table.item(2, column).text() for column in range(6)]
    assert texts[0] == "4.00"
    assert texts[1] == str(int(here.largest_deg))
    assert [text.endswith("*") for text in texts] == [False] * 5 + [here.bound == "ghosts"]
    assert not planner.switch.shown.isEnabled()
    assert not planner.take_button.isEnabled()
    assert not planner.switch.beam_button.isEnabled()


def test_a_changed_leaf_changes_the_answer(planner, qtbot) -> None:
    before = planner.sentence.text()
    type_into(planner.form.width_field, "20", qtbot)
    settle(planner, qtbot)
    assert planner.plan.order.width == pytest.approx(0.02)
    assert planner.sentence.text() != before
    assert make_plan(planner.form.order()).rows == planner.plan.rows


def test_an_own_beam_says_half_or_full(planner, qtbot) -> None:
    form = planner.form
    assert not form.exit.isVisible()
    assert "HALF divergence 0.014°" in form.told.text()
    form.instrument.setCurrentIndex(form.instrument.count() - 1)
    form.instrument.activated.emit(form.instrument.count() - 1)
    assert form.exit.isVisible()
    type_into(form.exit, "4", qtbot)
    type_into(form.divergence, "0.02", qtbot)
    assert form.half_divergence == pytest.approx(0.02)
    form.angle_kind.setCurrentIndex(FULL)
    form.angle_kind.activated.emit(FULL)
    assert form.half_divergence == pytest.approx(0.01)
    assert "HALF divergence 0.01° (the beam opens by 0.02° in all)" in form.told.text()
    form.ranging.setCurrentIndex(PULSED)
    form.ranging.activated.emit(PULSED)
    assert form.pulse.isVisible()
    settle(planner, qtbot)
    tool = planner.plan.order.tool
    assert tool.beam.radius == pytest.approx(0.002)
    assert tool.mixing == PulseMixing(0.15, 0.02)


def test_what_has_no_answer_is_said_and_not_shown(planner, qtbot) -> None:
    type_into(planner.form.width_field, "2", qtbot)
    settle(planner, qtbot)
    assert "no beam falls wholly on it" in planner.notice.text
    assert not planner.body.isVisible()
    assert planner.plan is None
    type_into(planner.form.width_field, "45", qtbot)
    settle(planner, qtbot)
    assert planner.notice.text == ""
    assert planner.body.isVisible()
    type_into(planner.form.nearest, "0.2", qtbot)
    settle(planner, qtbot)
    assert "measures from 0.6" in planner.notice.text


def test_nothing_behind_makes_no_ghosts(planner, qtbot) -> None:
    type_into(planner.form.behind, "0", qtbot)
    settle(planner, qtbot)
    assert planner.plan.order.behind is None
    assert all(row.ghosts == 0.0 for row in planner.plan.rows)


def test_it_takes_point_and_leaf_from_the_scan(opened, qtbot) -> None:
    panel = opened.show(PlannerPanel)
    scan, state = opened.controller.current, opened.controller.scan
    row = int(np.flatnonzero(state.scan.attributes["on_leaf"] == 1.0)[0])
    panel.take_point(scan, row)
    away = float(np.linalg.norm(state.scan.xyz[row]))
    assert panel.form.position.value() == pytest.approx(away, abs=0.006)
    leaf = next(iter(opened.state.leaves.values()))
    opened.controller.look(leaf=leaf.key)
    settle(panel, qtbot)
    qtbot.mouseClick(panel.take_button, Qt.MouseButton.LeftButton)
    settle(panel, qtbot)
    assert panel.plan.order.width < panel.plan.order.length < 0.1
    assert panel.form.position.value() == pytest.approx(3.0, abs=0.05)
    # Half of a leaf 88 mm wide, and as tall as 61 beams a millimetre apart.
    assert panel.form.length.value() == pytest.approx(61.0, rel=0.25)


def test_the_beam_goes_to_the_scan_and_undo_takes_it_back(opened, qtbot) -> None:
    panel = opened.show(PlannerPanel)
    settle(panel, qtbot)
    assert opened.controller.scan.parameters.beam is None
    qtbot.mouseClick(panel.switch.beam_button, Qt.MouseButton.LeftButton)
    assert opened.controller.scan.parameters.beam == panel.form.tool.beam
    assert isinstance(opened.controller.project.history.log[-1].operation, SetParameters)
    settle(panel, qtbot)
    assert not panel.switch.beam_button.isEnabled()
    opened.controller.undo()
    assert opened.controller.scan.parameters.beam is None


def test_the_switch_and_the_view_are_one(opened, qtbot) -> None:
    panel = opened.show(PlannerPanel)
    settle(panel, qtbot)
    panel.switch.shown.setFocus()
    qtbot.keyClick(panel.switch.shown, Qt.Key.Key_Space)
    assert opened.controller.view.show_footprints
    settle(panel, qtbot)
    panel.switch.every.setValue(3)
    assert opened.controller.view.footprint_step == 3
    opened.controller.look(show_footprints=False)
    settle(panel, qtbot)
    assert not panel.switch.shown.isChecked()
    assert not panel.switch.every.isEnabled()
