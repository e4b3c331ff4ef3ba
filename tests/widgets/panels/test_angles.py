"""The angles panel sets radius, estimator and beam, and tells what came of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.core.incidence import ESTIMATORS
from app.model.parameters import Beam
from widgets.common.step_titles import title_steps
from widgets.panels.angles import TITLES, AnglesPanel


@pytest.fixture
def panel(opened) -> AnglesPanel:
    return opened.show(AnglesPanel)


def parameters(opened):
    return opened.controller.scan.parameters


def count_steps(opened) -> int:
    return len(opened.controller.project.history.done)


def last_title(opened) -> str:
    return title_steps(opened.controller.project.history.done)[-1]


def type_into(field, text: str, qtbot) -> None:
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, text)
    qtbot.keyClick(field, Qt.Key.Key_Return)


def choose(combo, text: str, qtbot) -> None:
    """Pick a row of a combo box with the keyboard, as a user does."""
    row = next(i for i in range(combo.count()) if combo.itemText(i).startswith(text))
    combo.setFocus()
    combo.showPopup()
    qtbot.waitUntil(combo.view().isVisible)
    combo.view().setCurrentIndex(combo.model().index(row, 0))
    qtbot.keyClick(combo.view(), Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: not combo.view().isVisible())


def compute(panel, qtbot) -> None:
    qtbot.waitUntil(lambda: "Compute" in panel.notice.button.text())
    qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: panel.facts is not None, timeout=60_000)


def test_nothing_is_computed_before_it_is_asked_for(panel, opened, qtbot) -> None:
    qtbot.wait(20)
    assert opened.controller.project.cache.computed(opened.controller.current) == {}
    assert panel.facts is None
    assert not panel.found.isVisible()


def test_it_tells_how_neighbours_were_found_and_how_good_angles_are(panel, opened, qtbot) -> None:
    compute(panel, qtbot)
    texts, key = panel.found.texts, opened.controller.current
    angle, sigma, width = (
        opened.controller.project.field(key, name)
        for name in ("incidence", "incidence_sigma", "incidence_width")
    )
    assert texts["Neighbours"] == "scan grid"
    assert "rows and columns" in texts["Why"]
    assert texts["Estimator"] == "Adaptive"
    assert texts["Half-width"] == f"{np.nanmedian(width[np.isfinite(angle)]):.2f} mm (median)"
    assert texts["σ of the angle"] == f"{np.nanmedian(sigma[np.isfinite(angle)]):.2f}° (median)"
    assert texts["Without value"] == f"{100 * np.isnan(angle).mean():.2f} %"
    assert panel.found.isVisible()
    assert not panel.notice.isVisible()


def test_a_typed_radius_is_one_step_that_can_be_undone(panel, opened, qtbot) -> None:
    compute(panel, qtbot)
    steps = count_steps(opened)
    type_into(panel.radius, "6.5", qtbot)
    assert parameters(opened).radius == pytest.approx(0.0065)
    assert count_steps(opened) == steps + 1
    assert last_title(opened) == "Set neighbour radius to 6.5 mm"
    qtbot.waitUntil(lambda: not panel.found.isVisible())
    opened.controller.undo()
    qtbot.waitUntil(lambda: panel.radius.value() == 4.0)
    qtbot.waitUntil(panel.found.isVisible)


def test_arrows_pressed_in_a_row_are_one_step(panel, opened, qtbot) -> None:
    steps = count_steps(opened)
    panel.radius.setFocus()
    for _ in range(3):
        qtbot.keyClick(panel.radius, Qt.Key.Key_Up)
    assert parameters(opened).radius == pytest.approx(0.0043)
    assert count_steps(opened) == steps + 1


def test_what_is_half_typed_survives_news(panel, opened, qtbot) -> None:
    type_into(panel.beam.exit, "5", qtbot)
    panel.radius.setFocus()
    panel.radius.selectAll()
    qtbot.keyClicks(panel.radius, "7.")
    opened.controller.want(opened.controller.current, "range")
    qtbot.waitUntil(lambda: not opened.controller.bridge.jobs)
    qtbot.wait(20)
    assert panel.beam.exit.value() == 5.0
    qtbot.keyClicks(panel.radius, "5\r")
    assert parameters(opened).radius == pytest.approx(0.0075)


def test_a_radius_that_the_field_cannot_show_stays_as_it_is(panel, opened, qtbot) -> None:
    opened.work.set_parameters(radius=0.00412345)
    qtbot.waitUntil(lambda: panel.radius.value() == 4.12)
    panel.radius.setFocus()
    panel.estimator.setFocus()
    assert parameters(opened).radius == 0.00412345


@pytest.mark.parametrize("estimator", ESTIMATORS[1:])
def test_an_estimator_is_chosen_and_explained(panel, opened, qtbot, estimator) -> None:
    title, sentence = TITLES[estimator]
    choose(panel.estimator, title, qtbot)
    assert parameters(opened).estimator == estimator
    qtbot.waitUntil(lambda: panel.sentence.text() == sentence)
    assert last_title(opened) == f"Find angles by estimator {estimator}"
    compute(panel, qtbot)
    assert panel.found.texts["Estimator"] == title
    opened.controller.undo()
    qtbot.waitUntil(lambda: panel.estimator.currentText() == "Adaptive")


def test_an_instrument_gives_its_beam(panel, opened, qtbot) -> None:
    assert panel.beam.source.currentText() == "Unknown"
    assert panel.beam.exit.text() == panel.beam.half.text() == "unknown"
    choose(panel.beam.source, "FARO LS880", qtbot)
    beam = parameters(opened).beam
    assert (beam.radius, beam.origin) == (pytest.approx(0.0015), "instrument ls880")
    qtbot.waitUntil(lambda: panel.beam.exit.value() == 3.0)
    assert panel.beam.half.value() == pytest.approx(0.014)
    assert "HALF of the full divergence: the beam opens by 0.028°" in panel.beam.full.text()
    assert last_title(opened).startswith("Set beam: 3 mm at exit")
    opened.controller.undo()
    qtbot.waitUntil(lambda: panel.beam.source.currentText() == "Unknown")


def test_a_beam_is_typed_when_both_numbers_are_there(panel, opened, qtbot) -> None:
    type_into(panel.beam.exit, "5", qtbot)
    assert parameters(opened).beam is None
    type_into(panel.beam.half, "0.01", qtbot)
    assert parameters(opened).beam == Beam(0.0025, np.deg2rad(0.01), "typed in")
    qtbot.waitUntil(lambda: panel.beam.source.currentText() == "Typed in")
    choose(panel.beam.source, "Unknown", qtbot)
    assert parameters(opened).beam is None


def test_the_instrument_that_a_scan_names_is_offered(desk, make_scan, qtbot) -> None:
    desk.open(replace(make_scan(), metadata={"instrument": "simulated: FARO X330"}))
    panel = desk.show(AnglesPanel)
    choose(panel.beam.source, "As the scan says: FARO X330", qtbot)
    assert desk.controller.scan.parameters.beam.origin == "instrument x330, as the scan says"
    assert desk.controller.scan.parameters.beam.radius > 0


def test_without_a_position_it_asks_for_one(desk, make_scan, qtbot) -> None:
    key = desk.open(make_scan(pose=False))
    panel = desk.show(AnglesPanel)
    with qtbot.waitSignal(panel.origin_asked) as asked:
        qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    assert asked.args == [key]


def test_a_few_points_are_said_to_be_few(panel, opened, qtbot) -> None:
    key = opened.controller.current
    opened.controller.want(key, "incidence", np.arange(200))
    qtbot.waitUntil(lambda: panel.facts is not None, timeout=60_000)
    assert panel.found.texts["Points"].startswith("200 of ")
    assert "Compute" in panel.notice.button.text()


def test_recovered_rows_and_columns_are_told(desk, make_scan, qtbot) -> None:
    desk.open(replace(make_scan(), grid=None))
    panel = desk.show(AnglesPanel)
    compute(panel, qtbot)
    assert panel.found.texts["Neighbours"] == "recovered grid"
    assert "121 cells" in panel.found.texts["Why"]
