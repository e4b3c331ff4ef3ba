"""How long a slider and a fit take in the real window, with 100 000 points shown as a density.

``python -m pytest -m bench -s tests/bench/test_lab_window.py`` under a display. A display without
a graphics card puts the window together in software, which costs as much as all our painting: the
times are therefore told with it and without.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import QEvent, QEventLoop, QObject, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

import app.core.kernels  # noqa: F401 - chooses the cache of compiled code
from app.model.points import PointSet
from app.model.scan import Channel, Grid, Pose, Scan
from app.model.selection import Explicit
from app.services.opening import add_scans
from widgets.main_window import MainWindow
from widgets.theme import ThemeSwitch

pytestmark = [pytest.mark.bench, pytest.mark.window, pytest.mark.timeout(600)]
Times = tuple[float, float, float]
DISTANCE, RADIUS, HALF_WIDTH = 3.0, 0.05, 0.046
ROWS, COLUMNS = 260, 410
STEPS, FITS = 60, 15


def build_scan() -> Scan:
    """A leaf of more than 100 000 points on an upright cylinder: angles up to 67°."""
    row, column = (a.ravel() for a in np.indices((ROWS, COLUMNS)))
    side = np.linspace(-HALF_WIDTH, HALF_WIDTH, COLUMNS)[column]
    height = np.linspace(-0.03, 0.03, ROWS)[row]
    xyz = np.column_stack((DISTANCE + RADIUS - np.sqrt(RADIUS**2 - side**2), side, height))
    normal = np.column_stack((xyz[:, 0] - DISTANCE - RADIUS, side, 0.0 * side)) / RADIUS
    beam = xyz / np.linalg.norm(xyz, axis=1)[:, None]
    angle = np.arccos(np.clip(-(normal * beam).sum(axis=1), -1, 1))
    c, t = np.cos(angle), np.tan(angle)
    light = 0.6 * (0.7 * c + 0.3 * np.exp(-(t**2) / 0.35**2) / c**5)
    noise = np.random.default_rng(1).normal(1.0, 0.05, len(light))
    grid = Grid(ROWS, COLUMNS, row.astype(np.int32), column.astype(np.int32))
    channel = Channel("near", "near", 1063.0, "reflectance")
    pose = Pose((0.0, 0.0, 0.0), known_by="given")
    return Scan("bent leaf", xyz, {"near": light * noise}, (channel,), pose, grid)


class Painted(QObject):
    """When a widget began to be painted last; other events tell that it is on the screen."""

    def __init__(self, widget: QObject) -> None:
        super().__init__()
        self.at = 0.0
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Paint:
            self.at = time.perf_counter()
        return False


class Bench:
    """The window with the leaf in the lab."""

    def __init__(self, window: MainWindow) -> None:
        self.window, self.controller = window, window.controller
        self.wait(lambda: window.picture.view is not None)
        (key,) = add_scans(self.controller.project, [build_scan()])
        self.controller.look(current=key)
        self.rest()
        leaf = PointSet(np.arange(ROWS * COLUMNS))
        window.work.make_leaf(key, leaf, Explicit(leaf))
        self.lab: Any = window.docks.panels["phase_lab"]
        window.docks.raise_panel("phase_lab")
        self.wait(lambda: self.lab.editor.points.count > 0)
        self.rest()
        self.painted = Painted(self.lab.plots.plot.viewport())

    def wait(self, condition: Callable[[], bool]) -> None:
        # As the window's own loop does: a busy one would keep the worker from running.
        while not condition():
            QApplication.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents)

    def rest(self) -> None:
        for _ in range(3):
            self.wait(lambda: not self.controller.bridge.jobs)
            QTest.qWait(120)

    def time(self, deed: Callable[[], object], done: Callable[[], bool] = lambda: True) -> Times:
        """Seconds until the plot is being painted, is on the screen, and of this thread's work."""
        begin, work = time.perf_counter(), time.thread_time()
        deed()
        self.wait(done)
        since = time.perf_counter()
        self.wait(lambda: self.painted.at > since)
        QApplication.processEvents()
        painted = self.painted.at - begin
        return painted, time.perf_counter() - begin, time.thread_time() - work


@pytest.fixture
def bench(qapp: QApplication, tmp_path, monkeypatch) -> Iterator[Bench]:
    monkeypatch.setenv("LEAFSCOPE_MODELS", str(tmp_path))
    palette, sheet = qapp.palette(), qapp.styleSheet()
    theme = ThemeSwitch(qapp)
    theme.apply("light")
    window = MainWindow(theme)
    window.resize(1480, 940)
    window.show()
    yield Bench(window)
    window._agreed_to_close = True
    window.close()
    window.deleteLater()
    qapp.setStyleSheet(sheet)
    qapp.setPalette(palette)


def tell(name: str, times: list[Times]) -> Times:
    """Print and give the medians."""
    begun, shown, work = (float(value) for value in np.median(times, axis=0))
    print(
        f"\n{name}: painting begins after {1e3 * begun:.1f} ms, on the screen after "
        f"{1e3 * shown:.1f} ms, of which the window itself worked {1e3 * work:.1f} ms"
    )
    return begun, shown, work


def test_a_slider_moves_the_curve_within_a_frame(bench: Bench) -> None:
    lab = bench.lab
    assert lab.editor.points.count >= 100_000
    assert lab.editor.points.density is not None
    slider, plot = lab.editor.rows.rows["f"].slider, lab.plots.plot
    slider.setSliderDown(True)
    bench.time(lambda: slider.setSliderPosition(250))

    ours = [bench.time(lambda i=i: slider.setSliderPosition(300 + 4 * i)) for i in range(STEPS)]
    x, y = lab.editor.points.angle, lab.editor.points.value
    dots = pg.ScatterPlotItem(pen=None)
    plot.addItem(dots)

    def draw_all(i: int) -> None:
        slider.setSliderPosition(300 + 4 * i)
        dots.setData(x, y, size=plot.dot_size(), pen=None, brush="#808080")

    naive = [bench.time(lambda i=i: draw_all(i)) for i in range(5)]
    plot.removeItem(dots)
    slider.setSliderDown(False)
    bench.rest()
    _, shown, _ = tell("slider, density", ours)
    _, slow, _ = tell("slider, all points drawn anew", naive)
    print(f"{slow / shown:.0f} times quicker")
    assert shown <= slow / 10


def test_a_fit_is_shown(bench: Bench) -> None:
    lab = bench.lab
    times = []
    for _ in range(FITS):
        fits = len(bench.controller.project.state.fits)
        times.append(
            bench.time(
                lambda: QTest.mouseClick(lab.fit_button, Qt.MouseButton.LeftButton),
                lambda fits=fits: len(bench.controller.project.state.fits) > fits,
            )
        )
        bench.rest()
        assert lab.editor.result is not None
    tell("fit of 100 000 points", times[2:])
    assert lab.editor.result.values["f"] == pytest.approx(0.6, abs=0.05)
