"""The process around the window: faults, signals, the command line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QCoreApplication, qInstallMessageHandler
from pytestqt.qtbot import QtBot

from app.core.errors import BadInput
from widgets.faults import Faults, Trouble

pytestmark = pytest.mark.window
ROOT = Path(__file__).parents[3]
START = """
import os, signal, sys
from PySide6.QtCore import QTimer
from widgets.__main__ import main
import widgets.main_window as module

class Window(module.MainWindow):
    def complete(self):
        {deed}

module.MainWindow = Window
sys.exit(main([]))
"""


def run_window(deed: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", START.format(deed=deed)], cwd=ROOT, timeout=60, check=False,
        capture_output=True, text=True, env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
    )  # fmt: skip


def test_ctrl_c_ends_the_window() -> None:
    run = run_window("os.kill(os.getpid(), signal.SIGINT)")
    assert run.returncode == 128 + signal.SIGINT, run.stderr


def test_an_error_in_a_slot_does_not_end_the_window() -> None:
    run = run_window(
        "QTimer.singleShot(300, self.close); "
        "QTimer.singleShot(200, lambda: print(self.notices.notices[0].text, flush=True)); "
        "QTimer.singleShot(0, lambda: 1 / 0)"
    )
    assert run.returncode == 0, run.stderr
    assert "division by zero" in run.stdout
    assert "ZeroDivisionError" in run.stderr


def test_help_opens_no_window() -> None:
    run = subprocess.run(
        [sys.executable, "-m", "widgets", "--help"], cwd=ROOT, timeout=60, check=False,
        capture_output=True, text=True, env={**os.environ, "QT_QPA_PLATFORM": "none"},
    )  # fmt: skip
    assert run.returncode == 0
    assert "--demo" in run.stdout


def test_faults_of_threads_arrive_on_the_gui_thread(
    qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    faults = Faults()
    heard: list[tuple[BaseException, threading.Thread]] = []

    def hear(error: BaseException) -> None:
        heard.append((error, threading.current_thread()))

    faults.raised.connect(hear)
    monkeypatch.setattr(threading, "excepthook", faults._take_from_thread)

    def fail() -> None:
        raise BadInput("The thread stumbled.")

    thread = threading.Thread(target=fail)
    thread.start()
    thread.join()
    qtbot.waitUntil(lambda: bool(heard))
    assert isinstance(heard[0][0], BadInput)


def test_watch_takes_all_three_roads(monkeypatch: pytest.MonkeyPatch) -> None:
    before = sys.excepthook, threading.excepthook
    faults = Faults()
    try:
        faults.watch()
        assert sys.excepthook == faults.take
        assert threading.excepthook == faults._take_from_thread
        assert qInstallMessageHandler(None) == faults._take_message
    finally:
        sys.excepthook, threading.excepthook = before
        qInstallMessageHandler(None)


def test_trouble_is_put_into_words() -> None:
    trouble = Trouble.of(BadInput("x.las is empty.", "Copy it again."))
    assert (trouble.what, trouble.hint) == ("x.las is empty.", "Copy it again.")
    other = Trouble.of(ValueError("bad shape."))
    assert other.what == "Something went wrong: bad shape."
    assert "ValueError" in other.report()
    assert QCoreApplication.instance() is not None
