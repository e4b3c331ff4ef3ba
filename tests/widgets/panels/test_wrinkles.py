"""The wrinkles panel shows by how much a bent leaf leaves its plane."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.core.wrinkles import SIGN_OF_DELTA
from widgets.common.wrinkle_map import directions, paint
from widgets.panels.wrinkles import WrinklesPanel


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(WrinklesPanel)
    qtbot.waitUntil(lambda: "No curve is in use" in panel.notice.text)
    return panel


def fit_and_use(panel, qtbot) -> None:
    qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: panel.seen is not None, timeout=60_000)


def test_one_click_fits_a_curve_and_shows_the_leaf(panel, opened, qtbot) -> None:
    fit_and_use(panel, qtbot)
    scan, leaf = opened.controller.scan.scan, panel.leaf
    truth = scan.attributes["true_deg"][leaf.members.indices] - panel.seen.plane
    spread = panel.seen.spread
    assert np.rad2deg(spread.mean) == pytest.approx(truth.mean(), abs=0.5)
    assert np.rad2deg(spread.sd) == pytest.approx(truth.std(), abs=0.5)
    assert spread.count + spread.undefined == len(leaf.members)
    facts = panel.facts.texts
    assert facts["ω of the leaf's plane"] == f"{panel.seen.plane:.1f}°"
    assert "shift" in facts["ω from the mean intensity"]
    assert f"{spread.undefined} more" in facts["Points"]


def test_the_map_shows_the_sign_that_the_legend_states(panel, qtbot) -> None:
    fit_and_use(panel, qtbot)
    assert panel.legend.text() == SIGN_OF_DELTA
    # Leaf 2 bulges: steep at one side, face-on at the other, where x is the same and y is 0.
    delta = panel.seen.delta
    left, right = np.nanmean(delta[:, :5]), np.nanmean(delta[:, -5:])
    assert {np.sign(left), np.sign(right)} == {-1.0, 1.0}
    colours = paint(panel.seen, panel.seen.limit).astype(int)
    steep, facing = (colours[:, :5], colours[:, -5:]) if left > right else (
        colours[:, -5:], colours[:, :5]
    )  # fmt: skip
    shown = steep[steep[..., 3] > 0]
    assert (shown[:, 2] > shown[:, 1]).all(), "towards edge-on is blue or purple"
    shown = facing[facing[..., 3] > 0]
    assert (shown[:, 0] > shown[:, 2]).all(), "towards the beam is red or yellow"


def test_the_cloud_can_be_coloured(panel, opened, qtbot) -> None:
    fit_and_use(panel, qtbot)
    qtbot.mouseClick(panel.colour_button, Qt.MouseButton.LeftButton)
    assert opened.controller.view.colour == "delta_omega"
    qtbot.mouseClick(panel.colour_button, Qt.MouseButton.LeftButton)
    assert opened.controller.view.colour == "near"


def test_undo_takes_the_map_away_and_another_leaf_changes_it(panel, opened, qtbot) -> None:
    fit_and_use(panel, qtbot)
    first = panel.seen
    opened.controller.look(leaf="leaf-00001")
    qtbot.waitUntil(lambda: panel.seen is not None and panel.seen is not first, timeout=30_000)
    assert "Leaf 1" in panel.title.text()
    opened.controller.undo()
    qtbot.waitUntil(lambda: "No curve is in use" in panel.notice.text)
    assert not panel.body.isVisible()


def test_what_is_missing_is_said(desk, qtbot, make_scan) -> None:
    panel = desk.show(WrinklesPanel)
    assert "Open a scan" in panel.notice.text
    key = desk.open(make_scan(pose=False))
    qtbot.waitUntil(lambda: "where the scanner stood" in panel.notice.text)
    with qtbot.waitSignal(panel.origin_asked) as asked:
        qtbot.mouseClick(panel.notice.button, Qt.MouseButton.LeftButton)
    assert asked.args == [key]
    desk.documents.set_origin(key, (0.0, 0.0, 0.0))
    qtbot.waitUntil(lambda: "Choose a leaf" in panel.notice.text)


def test_directions_are_right_and_up_wherever_the_scanner_looks() -> None:
    for ahead, right in (((1, 0, 0), (0, -1, 0)), ((0, 1, 0), (1, 0, 0)), ((-1, 0, 0), (0, 1, 0))):
        beams = np.array([np.add(ahead, np.multiply(0.1, right)), np.add(ahead, (0, 0, 0.1)),
                          np.subtract(ahead, np.multiply(0.1, right)),
                          np.subtract(ahead, (0, 0, 0.1))], float)  # fmt: skip
        azimuth, elevation = directions(beams)
        tilt = np.rad2deg(np.arctan(0.1))
        np.testing.assert_allclose(azimuth, [tilt, 0, -tilt, 0], atol=1e-9)
        np.testing.assert_allclose(elevation, [0, tilt, 0, -tilt], atol=1e-9)
    straight_up = np.array([[0.1, 0, 1], [-0.1, 0, 1], [0, 0.1, 1], [0, -0.1, 1]], float)
    azimuth, elevation = directions(straight_up)
    assert np.ptp(azimuth) == pytest.approx(np.ptp(elevation), rel=0.02)
