"""Angles in the whole window: how to get there, what can be coloured, what a click tells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from app.core.screen import project as project_points
from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
Put = Callable[..., str]


def test_the_key_brings_the_panel_to_the_front(
    window: MainWindow, put_scan: Put, qtbot: QtBot
) -> None:
    put_scan(window)
    seen: list[bool] = []
    window.docks.docks["angles"].visibilityChanged.connect(seen.append)
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    qtbot.keyClick(window, Qt.Key.Key_A)
    qtbot.waitUntil(lambda: seen[-1:] == [True])


def test_colour_by_offers_what_can_be_had(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell)
    titles = {
        "incidence_sigma": "σ of the incidence angle",
        "incidence_width": "Window half-width",
        "footprint": "Footprint, major axis",
        "footprint_share": "Footprint over leaf size",
    }
    box = shell.colour_by
    for name, title in titles.items():
        assert box.itemText(box.findData(name)) == title
    item = box.model().item(box.findData("footprint"))
    assert not item.isEnabled()
    assert "Scan ▸ Incidence angles" in item.toolTip()
    from app.services.beams import beam_of_instrument

    shell.work.set_parameters(beam=beam_of_instrument("ls880"))
    assert box.model().item(box.findData("footprint")).isEnabled()
    assert "no leaf" in box.model().item(box.findData("footprint_share")).toolTip()


def test_a_click_tells_the_angle_with_its_error(
    window: MainWindow, put_scan: Put, qtbot: QtBot
) -> None:
    key = put_scan(window)
    view = window.picture.view
    qtbot.waitUntil(lambda: window.stack.currentWidget() is view)
    told: list[list[tuple[str, object, str]]] = []
    window.picture.picker.described.connect(told.append)
    xyz, now = window.controller.project.state.scan(key).scan.xyz, view.current_view()
    place = project_points(xyz[300:301], now.origin, now.matrix, now.size).px[0] / now.size
    view.picked.emit(float(place[0]), float(place[1]))
    qtbot.waitUntil(lambda: "Incidence angle" in dict_of(told[-1] if told else []), timeout=60_000)
    qtbot.waitUntil(lambda: not window.controller.bridge.jobs)
    project = window.controller.project
    value, error = str(dict_of(told[-1])["Incidence angle"]).split(" ± ")
    assert float(value) == pytest.approx(
        float(project.field(key, "incidence", np.array([300]))[0]), abs=0.01
    )
    assert float(error) == pytest.approx(
        float(project.field(key, "incidence_sigma", np.array([300]))[0]), abs=0.01
    )
    assert project.cache.computed(key)["incidence"] == 1


def dict_of(values: list[tuple[str, object, str]]) -> dict[str, object]:
    return {name: value for name, value, _ in values}
