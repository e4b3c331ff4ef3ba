"""Several channels and leaves: laid over one another, fitted in one step, said when stale."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.core.fitting import FitResult
from app.model.fit_method import Method
from app.model.points import PointSet
from app.model.selection import Explicit
from widgets.common.lab.stale import is_stale
from widgets.panels.phase_lab import PhaseLabPanel

LEFT = Qt.MouseButton.LeftButton
TRUTH = {"near": 0.6, "far": 0.3}


@pytest.fixture
def lab(opened, qtbot):
    panel = opened.show(PhaseLabPanel)
    qtbot.waitUntil(lambda: panel.editor.points.count > 0, timeout=60_000)
    return panel


def tick(lab, qtbot, row: int) -> None:
    """Tick a channel with the keyboard, and go back to the one at work."""
    item = lab.choice.channel_list.item(row)
    rect = lab.choice.channel_list.visualItemRect(item)
    box = rect.topLeft() + rect.bottomLeft()
    at = type(box)(rect.left() + rect.height() // 2, rect.center().y())
    qtbot.mouseClick(lab.choice.channel_list.viewport(), LEFT, pos=at)


def choose(lab, qtbot, what: str) -> None:
    box = lab.choice.points_box
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    for _ in range(box.findData(what)):
        qtbot.keyClick(box, Qt.Key.Key_Down)
    assert box.currentData() == what


def fit(lab, opened, qtbot, count: int) -> None:
    before = len(opened.state.fits)
    qtbot.mouseClick(lab.fit_button, LEFT)
    qtbot.waitUntil(lambda: len(opened.state.fits) == before + count, timeout=30_000)
    qtbot.waitUntil(lambda: lab.editor.result is not None)


def test_ticked_channels_are_drawn_and_fitted_in_one_step(lab, opened, qtbot) -> None:
    tick(lab, qtbot, 1)
    assert set(lab.choice.channels) == {"near", "far"}
    lab.choice.channel_list.setCurrentRow(0)
    qtbot.waitUntil(lambda: len(lab.plots.series) == 2)
    assert lab.choice.channels == ("near", "far")
    assert [s.title for s in lab.plots.series] == ["near (1063 nm)", "far (1545 nm)"]
    assert len({s.colour for s in lab.plots.series}) == 2
    assert len({s.symbol for s in lab.plots.series}) == 2
    steps = len(opened.controller.project.history.done)
    fit(lab, opened, qtbot, 2)
    assert len(opened.controller.project.history.done) == steps + 1
    for record in opened.state.fits.values():
        values = FitResult.from_dict(record.result).values
        assert values["f"] == pytest.approx(TRUTH[record.channel], rel=0.1)
    qtbot.waitUntil(lambda: all(s.shape is not None for s in lab.plots.series))
    over = lab.plots.plot.items_of_series[1].curve.getData()[1]
    assert np.isfinite(over).any()
    opened.controller.undo()
    assert not opened.state.fits


def test_the_channel_at_work_cannot_be_taken_off(lab, qtbot) -> None:
    tick(lab, qtbot, 0)
    item = lab.choice.channel_list.item(0)
    assert item.checkState() == Qt.CheckState.Checked
    assert lab.choice.channels == ("near",)


def test_each_leaf_has_a_curve_of_its_own(lab, opened, qtbot) -> None:
    keys = tuple(opened.state.leaves)
    lab.choose_leaves(keys)
    choose(lab, qtbot, "each")
    qtbot.waitUntil(lambda: len(lab.plots.series) == 2, timeout=30_000)
    # The leaf that all panels work on comes first.
    assert [s.title for s in lab.plots.series] == ["Leaf 2", "Leaf 1"]
    fit(lab, opened, qtbot, 2)
    assert {record.leaves for record in opened.state.fits.values()} == {(k,) for k in keys}
    assert opened.controller.project.history.done[-1].title == "Fit 2 curves"


@pytest.mark.parametrize(
    ("way", "method"),
    [
        ("huber", Method(loss="huber")),
        ("tukey", Method(loss="tukey")),
        ("bins", Method("bins")),
        ("edge", Method("edge")),
    ],
)
def test_every_way_of_fitting(lab, opened, qtbot, way, method) -> None:
    box = lab.choice.how.box
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    for _ in range(box.findData(way)):
        qtbot.keyClick(box, Qt.Key.Key_Down)
    assert lab.choice.method == method
    fit(lab, opened, qtbot, 1)
    (record,) = opened.state.fits.values()
    assert record.method == method
    kind = {"points": method.loss, "bins": "bins", "edge": "edge"}[method.to]
    assert FitResult.from_dict(record.result).kind == kind
    assert not lab.editor.stale.isVisible()


def test_a_fit_on_other_points_is_said_to_be_stale(lab, opened, qtbot) -> None:
    fit(lab, opened, qtbot, 1)
    assert not lab.editor.stale.isVisible()
    leaf = opened.state.leaves[opened.controller.view.leaf]
    less = PointSet(leaf.members.indices[: len(leaf.members) // 2])
    opened.work.apply(leaf.scan, less, Explicit(less), "leaf", "subtract")
    qtbot.waitUntil(lambda: "other points" in lab.editor.stale.text(), timeout=30_000)
    assert lab.editor.stale.isVisible()
    fit(lab, opened, qtbot, 1)
    qtbot.waitUntil(lambda: not lab.editor.stale.isVisible())


def test_a_fit_in_another_way_is_said(lab, opened, qtbot) -> None:
    fit(lab, opened, qtbot, 1)
    box = lab.choice.how.box
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_End)
    qtbot.waitUntil(lambda: "fit again for upper edge" in lab.editor.stale.text())


def test_staleness_is_about_number_angles_and_values(lab, opened, qtbot) -> None:
    fit(lab, opened, qtbot, 1)
    (record,) = opened.state.fits.values()
    result, measured = FitResult.from_dict(record.result), lab.editor.points.measured
    assert not is_stale(result, Method(), measured)
    brighter = type(measured)(measured.angle, measured.value * 1.01, measured.point, measured.leaf)
    assert is_stale(result, Method(), brighter)
    assert is_stale(result, Method(), measured.take(measured.angle < 30))


def test_an_undetermined_parameter_is_said_beside_its_slider(lab, opened, qtbot) -> None:
    box = lab.choice.model_box
    box.setFocus()
    name = "lambert-beckmann"
    assert box.currentData() == name
    fit(lab, opened, qtbot, 1)
    rows = lab.editor.rows.rows
    for key, estimate in lab.editor.result.parameters.items():
        text = rows[key].error.text()
        if estimate.value is None:
            assert text == "not determined"
        elif estimate.at_bound:
            assert text == "at its bound"
        else:
            assert text.startswith("±")


def test_residuals_go_to_the_strip_and_to_the_view(lab, opened, qtbot) -> None:
    fit(lab, opened, qtbot, 1)
    means, shape = lab.editor.points.means, lab.editor.shape
    np.testing.assert_allclose(
        lab.plots.plot.strip.residuals, means.value - shape.draw(means.angle)
    )
    high = lab.plots.plot.plotItem.height()
    qtbot.mouseClick(lab.plots.tools.strip, LEFT)
    assert not lab.plots.plot.strip.isVisible()
    qtbot.waitUntil(lambda: lab.plots.plot.plotItem.height() > 1.2 * high)
    qtbot.mouseClick(lab.plots.tools.map, LEFT)
    assert opened.controller.view.colour == "residual"
    points, limits = lab.editor.points, opened.controller.view.ranges["residual"]
    miss = np.abs(points.value - shape.draw(points.angle))
    assert (miss <= limits.high).mean() == pytest.approx(0.98, abs=0.005)
    assert limits.low == -limits.high
    assert opened.controller.scan.parameters.curve.values == lab.editor.result.values
    qtbot.waitUntil(lambda: lab.plots.tools.map.isChecked())
    qtbot.mouseClick(lab.plots.tools.map, LEFT)
    assert opened.controller.view.colour == "near"
    qtbot.waitUntil(lambda: not opened.controller.bridge.jobs, timeout=30_000)


def test_a_slider_moves_curve_and_residuals_but_reads_no_point(
    lab, opened, qtbot, monkeypatch
) -> None:
    fit(lab, opened, qtbot, 1)
    plot = lab.plots.plot
    for name in ("show_series", "light_up", "_draw_points", "_fit_height", "_name_items"):
        if name != "_name_items":
            monkeypatch.setattr(plot, name, lambda *_: pytest.fail("drawn anew"))
    slider = lab.editor.rows.rows["f"].slider
    slider.setSliderDown(True)
    before = plot.strip.residuals.copy()
    slider.setSliderPosition(slider.value() + 40)
    assert (plot.strip.residuals < before).all()
    monkeypatch.undo()
    slider.setSliderDown(False)
