"""The phase lab fits what a leaf was made of, and its sliders move the curve."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QStyle, QStyleOptionSlider

from app.core.fitting import FitResult
from app.core.phase import MODELS, get_model
from app.core.units import group_digits
from app.services.lab.gather import Measured
from widgets.common.angular_points import ANGLE_CELLS, VALUE_CELLS, Cells, reduce_points
from widgets.common.lab.series import DRAWN
from widgets.panels.phase_lab import PhaseLabPanel

TRUTH = {"f": 0.6, "k_d": 0.7, "m": 0.35}


@pytest.fixture
def lab(opened, qtbot):
    panel = opened.show(PhaseLabPanel)
    qtbot.waitUntil(lambda: panel.editor.points.count > 0, timeout=60_000)
    return panel


def fit(lab, qtbot) -> FitResult:
    qtbot.mouseClick(lab.fit_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: lab.editor.result is not None, timeout=30_000)
    return lab.editor.result


def handle_of(slider) -> QPoint:
    option = QStyleOptionSlider()
    slider.initStyleOption(option)
    return (
        slider.style()
        .subControlRect(
            QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, slider
        )
        .center()
    )


def drawn(lab) -> np.ndarray:
    x, y = lab.editor.plot.curve.getData()
    np.testing.assert_array_equal(x, DRAWN)
    return y


def test_a_fit_finds_what_the_leaf_was_made_of(lab, opened, qtbot) -> None:
    # The leaf has no noise and a radius of 50 mm: where windows may grow, its bend is smoothed.
    opened.work.set_parameters(estimator="ball")
    result = fit(lab, qtbot)
    for name, value in TRUTH.items():
        assert result.values[name] == pytest.approx(value, abs=0.01)
        assert f"± {result.parameters[name].sd:.2g}"[:5] in lab.editor.rows.rows[name].error.text()
    assert group_digits(result.n) in lab.editor.facts.text()
    assert "RMSE" in lab.editor.facts.text()


def test_only_the_points_of_the_leaf_are_computed(lab, opened) -> None:
    key = opened.controller.current
    leaf = opened.state.leaves[opened.controller.view.leaf]
    assert lab.editor.points.count <= len(leaf.members)
    assert opened.controller.project.cache.computed(key)["incidence"] == len(leaf.members)


def test_the_curve_of_a_fit_can_be_used_and_taken_back(lab, opened, qtbot) -> None:
    result = fit(lab, qtbot)
    assert lab.use_button.isEnabled()
    qtbot.mouseClick(lab.use_button, Qt.MouseButton.LeftButton)
    curve = opened.controller.scan.parameters.curve
    assert curve.values == result.values
    assert curve.origin == "fit of Leaf 2"
    qtbot.waitUntil(lambda: "fit of Leaf 2" in lab.in_use.text())
    assert not lab.use_button.isEnabled()
    opened.controller.undo()
    qtbot.waitUntil(lambda: "No curve" in lab.in_use.text())
    assert lab.use_button.isEnabled()


def test_a_slider_moves_the_curve_and_changes_the_document_on_release(lab, opened, qtbot) -> None:
    fit(lab, qtbot)
    before, steps = drawn(lab), len(opened.controller.project.history.done)
    slider = lab.editor.rows.rows["f"].slider
    start = handle_of(slider)
    qtbot.mousePress(slider, Qt.MouseButton.LeftButton, pos=start)
    for step in (6, 12, 18):
        qtbot.mouseMove(slider, start + QPoint(step, 0))
    qtbot.waitUntil(lambda: slider.value() > 0 and lab.editor.result is None)
    assert len(opened.controller.project.history.done) == steps
    values = lab.editor.values
    assert values["f"] > TRUTH["f"] + 0.01
    inside = np.isfinite(drawn(lab))
    expected = get_model("lambert-beckmann").evaluate(np.deg2rad(DRAWN[inside]), values)
    np.testing.assert_allclose(drawn(lab)[inside], expected)
    assert (drawn(lab)[inside] > before[inside]).all()
    qtbot.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=start + QPoint(18, 0))
    assert opened.controller.scan.parameters.curve.values == values
    assert len(opened.controller.project.history.done) == steps + 1


def test_steps_of_one_drag_merge_and_undo_moves_the_sliders_back(lab, opened, qtbot) -> None:
    fit(lab, qtbot)
    qtbot.mouseClick(lab.use_button, Qt.MouseButton.LeftButton)
    used = opened.controller.scan.parameters.curve
    steps = len(opened.controller.project.history.done)
    slider = lab.editor.rows.rows["k_d"].slider
    for _ in range(3):
        qtbot.keyClick(slider, Qt.Key.Key_PageDown)
    assert opened.controller.scan.parameters.curve.origin == "set by hand"
    assert len(opened.controller.project.history.done) == steps + 1
    opened.controller.undo()
    qtbot.waitUntil(lambda: lab.editor.values == used.values)
    assert opened.controller.scan.parameters.curve == used
    assert "±" in lab.editor.rows.rows["k_d"].error.text()


def test_every_model_can_be_shown_and_fitted(lab, qtbot) -> None:
    box = lab.choice.model_box
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    for name, model in MODELS.items():
        qtbot.waitUntil(lambda: lab.editor.formula.text() == model.formula)  # noqa: B023
        assert set(lab.editor.values) == {p.name for p in model.parameters}
        assert fit(lab, qtbot).model == name
        assert np.isfinite(drawn(lab)).any()
        qtbot.keyClick(box, Qt.Key.Key_Down)


def test_the_whole_scan_is_fitted_on_means(lab, opened, qtbot) -> None:
    box = lab.choice.points_box
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_End)
    alive = opened.controller.scan.shown
    qtbot.waitUntil(lambda: lab.editor.points.count > 0.9 * alive, timeout=30_000)
    result = fit(lab, qtbot)
    assert result.n <= 16
    assert np.count_nonzero(lab.editor.points.means.angle < 80) == result.n


def test_chosen_leaves_are_pooled(lab, opened, qtbot) -> None:
    box = lab.choice.points_box
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Down)
    qtbot.waitUntil(lambda: "Leaves panel" in lab.notice.text)
    lab.choose_leaves(tuple(opened.state.leaves))
    qtbot.waitUntil(lambda: lab.editor.points.count > 4500, timeout=30_000)
    assert fit(lab, qtbot).n == lab.editor.points.count
    assert list(opened.state.fits.values())[-1].leaves == tuple(opened.state.leaves)


def test_a_missing_position_is_said_and_can_be_mended(desk, qtbot, make_scan) -> None:
    lab = desk.show(PhaseLabPanel)
    assert "Open a scan" in lab.notice.text
    key = desk.open(make_scan(pose=False))
    qtbot.waitUntil(lambda: "where the scanner stood" in lab.notice.text)
    assert not lab.fit_button.isEnabled()
    with qtbot.waitSignal(lab.origin_asked) as asked:
        qtbot.mouseClick(lab.notice.button, Qt.MouseButton.LeftButton)
    assert asked.args == [key]
    desk.documents.set_origin(key, (0.0, 0.0, 0.0))
    qtbot.waitUntil(lambda: "Choose a leaf" in lab.notice.text)


def test_a_missing_intensity_is_said(desk, qtbot, make_scan) -> None:
    lab = desk.show(PhaseLabPanel)
    desk.open(make_scan().with_channels(()))
    qtbot.waitUntil(lambda: "has no intensity" in lab.notice.text)
    assert not lab.fit_button.isEnabled()
    assert not lab.use_button.isEnabled()


def measured(angle: np.ndarray, value: np.ndarray) -> Measured:
    rows = np.arange(len(angle))
    return Measured(angle, value, rows, np.full(len(angle), -1))


def test_many_points_become_a_density_and_steps_are_described() -> None:
    chance = np.random.default_rng(3)
    angle, value = chance.uniform(0, 85, 5000), chance.normal(1.0, 0.1, 5000)
    many = reduce_points(measured(angle, value), most_dots=4000)
    assert many.dots is None
    inside = (value >= many.cells.low) & (value <= many.cells.high)
    assert many.density.sum() == inside.sum() > 4900
    means = many.means
    assert len(means.angle) == 17
    for step in range(17):
        own = (angle >= 5 * step) & (angle < 5 * step + 5)
        assert means.angle[step] == pytest.approx(angle[own].mean())
        assert means.value[step] == pytest.approx(value[own].mean())
        assert means.sd[step] == pytest.approx(value[own].std(ddof=1), rel=0.05)
    assert reduce_points(measured(angle[:0], value[:0]), 10).count == 0


def test_cells_count_as_the_histogram_of_numpy_does() -> None:
    chance = np.random.default_rng(4)
    angle = np.concatenate((chance.uniform(-1, 91, 3000), [0.0, 90.0, np.nan]))
    value = np.concatenate((chance.normal(1.0, 0.3, 3000), [0.5, 1.5, 1.0]))
    cells = Cells(0.5, 1.5)
    known = np.isfinite(angle)
    expected, _, _ = np.histogram2d(
        value[known], angle[known], (VALUE_CELLS, ANGLE_CELLS), ((0.5, 1.5), (0.0, 90.0))
    )
    found = cells.count(angle, value)
    assert found.sum() == expected.sum()
    # A point on an edge may go to the other side of it by rounding.
    assert np.abs(found - expected).sum() <= 2


def test_the_plot_shows_zero_but_for_decibels() -> None:
    angle = np.linspace(0, 80, 200)
    positive = reduce_points(measured(angle, np.linspace(0.4, 0.6, 200)), 1000)
    assert positive.bottom == 0.0
    assert positive.top == pytest.approx(0.6, abs=0.001)
    decibels = reduce_points(measured(angle, np.linspace(-20, -5, 200)), 1000)
    assert decibels.bottom == pytest.approx(-20, abs=0.1)
    assert decibels.top == pytest.approx(-5, abs=0.1)
