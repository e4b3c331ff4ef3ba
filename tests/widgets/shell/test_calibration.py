"""Calibration in the whole window: how to get there, and what a click on a point tells."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from widgets.main_window import MainWindow

pytestmark = pytest.mark.window
Put = Callable[..., str]


def test_the_key_and_the_menu_bring_the_panel_to_the_front(
    window: MainWindow, put_scan: Put, qtbot: QtBot
) -> None:
    action = window.table.actions["scan.calibrate"]
    assert not action.isEnabled()
    put_scan(window)
    assert action.isEnabled()
    seen: list[bool] = []
    window.docks.docks["calibration"].visibilityChanged.connect(seen.append)
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    qtbot.keyClick(window, Qt.Key.Key_K)
    qtbot.waitUntil(lambda: seen[-1:] == [True])
    window.docks.raise_panel("phase_lab")
    qtbot.waitUntil(lambda: seen[-1:] == [False])
    action.trigger()
    qtbot.waitUntil(lambda: seen[-1:] == [True])


def test_the_panel_shares_folders_and_hears_of_picked_points(
    window: MainWindow, put_scan: Put
) -> None:
    key = put_scan(window)
    panel = window.docks.panels["calibration"]
    assert panel.dialogs is window.desk.files.dialogs
    window.picture.picker.found.emit(key, 17)
    assert panel.budget._point == (key, 17)
