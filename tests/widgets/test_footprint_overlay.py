"""Footprints follow selection, leaf and beam; nothing is drawn that nobody asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace as replace_fields

import numpy as np
import pytest
from msgspec.structs import replace
from PySide6.QtCore import QObject

from app.model.operations import Select, SetParameters
from app.model.points import PointSet
from app.services.beams import typed_beam
from app.services.opening import add_scans
from app.simulate.scenes import leaves_scan
from widgets.controller import Controller
from widgets.footprint_overlay import FootprintOverlay

POINTS = PointSet(np.arange(2000, 2040))


class View:
    """Remembers what it is to draw."""

    def __init__(self) -> None:
        self.shown: list[object] = []
        self.drawings = self

    def show_rings(self, rings: object) -> None:
        self.shown.append(rings)


class Picture:
    def __init__(self) -> None:
        self.view = View()


@pytest.fixture
def overlay(qtbot) -> Iterator[FootprintOverlay]:
    parent, controller = QObject(), Controller()
    overlay = FootprintOverlay(controller, Picture(), parent)
    # Without its metadata it does not say whose beam it was.
    scan = replace_fields(leaves_scan(seed=4, leaves=2, step_deg=0.1), metadata={})
    (key,) = add_scans(controller.project, [scan])
    controller.look(current=key)
    overlay.said, overlay.failures = [], []
    controller.said.connect(overlay.said.append)
    controller.failed.connect(overlay.failures.append)
    yield overlay
    overlay.stop()
    controller.close()
    controller.deleteLater()
    parent.deleteLater()


def settle(overlay: FootprintOverlay, qtbot) -> None:
    bridge = overlay._controller.bridge
    qtbot.waitUntil(lambda: not overlay._later.isActive() and not bridge.jobs, timeout=60_000)


def give_beam(controller: Controller, diameter: float = 3.0) -> None:
    state, key = controller.scan, controller.current
    beam = typed_beam(diameter, 0.014)
    controller.do(SetParameters(key, replace(state.parameters, beam=beam)))


def test_it_follows_the_selection(overlay, qtbot) -> None:
    controller = overlay._controller
    give_beam(controller)
    controller.do(Select(controller.current, POINTS))
    settle(overlay, qtbot)
    assert overlay.rings is None
    controller.look(show_footprints=True)
    settle(overlay, qtbot)
    first = overlay.rings
    assert first is not None
    assert 0 < len(first) <= len(POINTS)
    assert "every selected point" in overlay.said[-1]
    calls = len(overlay._picture.view.shown)
    controller.look(point_size=4.0)
    settle(overlay, qtbot)
    assert len(overlay._picture.view.shown) == calls
    give_beam(controller, 6.0)
    settle(overlay, qtbot)
    assert np.ptp(overlay.rings[0], axis=0).max() > 1.5 * np.ptp(first[0], axis=0).max()
    controller.look(show_footprints=False)
    settle(overlay, qtbot)
    assert overlay.rings is None
    assert not overlay.failures


def test_without_a_beam_it_says_where_to_choose_one(overlay, qtbot) -> None:
    controller = overlay._controller
    controller.do(Select(controller.current, POINTS))
    controller.look(show_footprints=True)
    settle(overlay, qtbot)
    (failure,) = overlay.failures
    assert "beam of the scanner is unknown" in failure.what
    assert "Planner" in failure.hint
    assert overlay.rings is None


def test_without_points_it_says_what_to_do(overlay, qtbot) -> None:
    overlay._controller.look(show_footprints=True)
    settle(overlay, qtbot)
    assert "Select points" in overlay.said[-1]
    assert overlay.rings is None
