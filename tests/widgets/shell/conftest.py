"""A window around a small scan; the 3-D view and the panels only where a test needs them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.model.scan import Channel, Grid, Pose, Scan
from app.services.opening import add_scans
from widgets.main_window import MainWindow
from widgets.theme import ThemeSwitch

SIDE = 24
AT_ORIGIN = Pose((0.0, 0.0, 0.0))


def make_scan(pose: Pose | None = AT_ORIGIN) -> Scan:
    """A plane at 2 m, seen through a grid, with two channels."""
    row, column = np.divmod(np.arange(SIDE * SIDE), SIDE)
    y, z = (column - SIDE / 2) * 0.002, (SIDE / 2 - row) * 0.002
    xyz = np.stack((np.full(len(y), 2.0), y, z), axis=1)
    values = np.random.default_rng(1).uniform(0.3, 0.6, (2, len(y))).astype(np.float32)
    channels = (
        Channel("reflectance_1063", "reflectance_1063", 1063.0, "reflectance"),
        Channel("reflectance_1545", "reflectance_1545", 1545.0, "reflectance"),
    )
    return Scan(
        "patch.csv",
        xyz,
        {channel.attribute: values[k] for k, channel in enumerate(channels)},
        channels,
        pose,
        Grid(SIDE, SIDE, row.astype(np.int32), column.astype(np.int32)),
    )


@contextmanager
def open_shell(theme: ThemeSwitch) -> Iterator[MainWindow]:
    """A window that loads nothing slow, put away at the end."""
    window = MainWindow(theme)
    window._later.stop()
    yield window
    window._agreed_to_close = True
    window.close()
    window.deleteLater()


@pytest.fixture(scope="session")
def open_window() -> Callable[..., AbstractContextManager[MainWindow]]:
    """For fixtures that outlive a test: `open_shell`."""
    return open_shell


@pytest.fixture(scope="session")
def theme(qapp: QApplication) -> ThemeSwitch:
    return ThemeSwitch(qapp)


@pytest.fixture
def shell(qtbot: QtBot, theme: ThemeSwitch, tmp_path: Path) -> Iterator[MainWindow]:
    """The window as it is before what is slow was loaded."""
    with open_shell(theme) as window:
        window.desk.files.dialogs.folder = tmp_path
        yield window
    theme.apply("light")


@pytest.fixture
def window(shell: MainWindow, qtbot: QtBot) -> MainWindow:
    """The whole window, on the screen."""
    shell.resize(1200, 800)
    shell.show()
    qtbot.waitExposed(shell)
    shell.complete()
    return shell


@pytest.fixture(scope="session")
def put_scan() -> Callable[..., str]:
    """Put the small scan on a window's table; gives its key."""

    def put(window: MainWindow, pose: Pose | None = AT_ORIGIN) -> str:
        (key,) = add_scans(window.controller.project, [make_scan(pose)])
        window.controller.look(current=key, colour="reflectance_1063")
        return key

    return put


@pytest.fixture
def scan_file(tmp_path: Path) -> Path:
    """The small scan as a file, without a pose."""
    from app.formats.cloud import Cloud
    from app.services.export import export

    path = tmp_path / "patch.csv"
    export(Cloud(replace(make_scan(None), grid=None)), path)
    (tmp_path / "patch.csv.leafscope.json").unlink(missing_ok=True)
    return path
