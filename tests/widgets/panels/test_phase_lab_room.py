"""The lab in a low window, and the curve that it starts from."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.core.phase import MODELS
from app.core.units import to_radians
from app.services.lab.gather import Measured
from widgets.common.angular_points import NO_POINTS, reduce_points
from widgets.common.lab.start import start_curve
from widgets.panels.phase_lab import PhaseLabPanel

LEFT = Qt.MouseButton.LeftButton
ANGLE = np.linspace(1.0, 79.0, 400)


@pytest.fixture
def lab(opened, qtbot):
    panel = opened.show(PhaseLabPanel)
    qtbot.waitUntil(lambda: panel.editor.points.count > 0, timeout=60_000)
    return panel


def points_of(value):
    rows = np.arange(len(ANGLE))
    return reduce_points(Measured(ANGLE, value, rows, np.zeros_like(rows)), 10_000)


@pytest.mark.parametrize("name", MODELS)
def test_the_start_lies_in_the_cloud_whatever_its_unit(name: str) -> None:
    model = MODELS[name]
    for size in (0.02, 3000.0):
        value = size * (0.4 + 0.6 * np.cos(to_radians(ANGLE)))
        found = start_curve(model, points_of(value))
        curve = model.evaluate(to_radians(ANGLE), found)
        assert np.mean(curve) == pytest.approx(np.mean(value), rel=0.25)
        for p in model.parameters:
            assert p.lower <= found[p.name] <= p.upper
            if not p.scales:
                assert found[p.name] == p.start


def test_the_start_of_points_that_follow_the_model_is_their_curve() -> None:
    model = MODELS["lambert-beckmann"]
    truth = {**model.start_values(), "f": 870.0}
    found = start_curve(model, points_of(model.evaluate(to_radians(ANGLE), truth)))
    assert found["f"] == pytest.approx(870.0, rel=2e-3)  # means of a curved line


def test_without_points_the_start_is_the_usual_one() -> None:
    model = MODELS["lambert-beckmann"]
    assert start_curve(model, NO_POINTS) == model.start_values(1.0)


def test_the_legend_says_whether_the_curve_was_fitted(lab, qtbot) -> None:
    lab.plots.plot.resize(400, 500)
    words = [label.text for _, label in lab.plots.plot._legend.items]
    assert words[0] == "curve, not fitted"
    qtbot.mouseClick(lab.fit_button, LEFT)
    qtbot.waitUntil(lambda: lab.editor.result is not None, timeout=30_000)
    words = [label.text for _, label in lab.plots.plot._legend.items]
    assert words[0] == "curve ± RMSE"


def test_the_plot_gives_way_when_the_window_shrinks(lab, qtbot) -> None:
    plot, rows = lab.plots.plot, lab.editor.rows
    em = lab.fontMetrics().height()
    tall = plot.height()
    assert plot.strip.isVisible()
    needed = rows.mapTo(lab, rows.rect().bottomLeft()).y() - tall + 10 * em
    lab.resize(lab.width(), needed)
    qtbot.waitUntil(lambda: plot.height() < 12 * em, timeout=2000)
    assert plot.height() >= 9 * em
    assert not plot._legend.isVisible()
    assert not plot.strip.isVisible()
    assert lab.plots.tools.strip.isChecked()
    assert rows.mapTo(lab, rows.rect().bottomLeft()).y() <= lab.height()
    lab.resize(lab.width(), needed + 20 * em)
    qtbot.waitUntil(plot.strip.isVisible, timeout=2000)
    assert plot._legend.isVisible()


def test_a_low_plot_keeps_the_zoom_of_the_user(lab, qtbot) -> None:
    plot = lab.plots.plot
    plot.setYRange(0.1, 0.2, padding=0.0)
    lab.resize(lab.width(), lab.height() - 100)
    qtbot.wait(50)
    assert plot.viewRange()[1] == pytest.approx([0.1, 0.2])
    plot.show_all()
    assert plot.viewRange()[1][1] > 0.25


def test_buttons_of_certainty_are_above_its_table(lab, qtbot) -> None:
    bar = lab.pages.tabs
    qtbot.mouseClick(lab.fit_button, LEFT)
    qtbot.waitUntil(lambda: lab.editor.result is not None, timeout=30_000)
    qtbot.mouseClick(bar, LEFT, pos=bar.tabRect(2).center())
    page = lab.pages.certainty
    qtbot.wait(50)
    assert page.bootstrap_button.geometry().bottom() < page.table.geometry().top()


def test_models_show_what_matters_first_and_whole_names(lab, qtbot) -> None:
    bar, table = lab.pages.tabs, lab.pages.models.table
    qtbot.mouseClick(bar, LEFT, pos=bar.tabRect(1).center())
    qtbot.waitUntil(lambda: table.rowCount() >= len(MODELS), timeout=60_000)
    titles = [table.horizontalHeaderItem(k).text() for k in range(5)]
    assert titles == ["Model", "ΔAICc", "Weight", "ΔBIC", "RMSE"]
    for row in range(table.rowCount()):
        needed = table.sizeHintForRow(row)
        assert table.rowHeight(row) >= needed
    longest = max(range(table.rowCount()), key=table.sizeHintForRow)
    assert table.rowHeight(longest) > 1.7 * table.fontMetrics().height()


def test_choices_stay_together_where_there_is_nothing_to_draw(lab, opened, qtbot) -> None:
    opened.controller.look(leaf=None)
    qtbot.waitUntil(lambda: not lab.plots.isVisible(), timeout=10_000)
    lab.resize(400, 900)
    qtbot.wait(50)
    assert lab.choice.height() <= lab.choice.sizeHint().height()
