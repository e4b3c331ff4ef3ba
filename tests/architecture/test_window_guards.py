"""The guards of tests/widgets/conftest.py find what they are there for."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

TESTS = """
import threading
import pytest
from PySide6.QtCore import QThread, QTimer, qWarning
from PySide6.QtWidgets import QMainWindow, QWidget

kept = []
stop = threading.Event()

@pytest.fixture(scope="module", autouse=True)
def put_away():
    yield
    stop.set()
    for thing in kept:
        if isinstance(thing, QThread):
            thing.quit()
            thing.wait()

def test_good_window(qtbot):
    window = QMainWindow()
    window.menuBar().addMenu("File").addAction("Open")
    window.timer = QTimer(window)
    window.timer.start(5)
    window.show()
    qtbot.wait(20)

def test_good_thread(qtbot):
    thread = QThread()
    thread.start()
    thread.quit()
    thread.wait()

def test_good_later(qtbot):
    QWidget().deleteLater()

def test_good_message(qt_messages):
    qWarning("on purpose")
    qt_messages.remove("on purpose")

def test_bad_window(qtbot):
    kept.append(QWidget())
    kept[-1].show()

def test_bad_hidden_cycle_is_kept(qtbot):
    window = QWidget()
    kept.append(lambda: window)

def test_bad_timer(qapp):
    kept.append(QTimer())
    kept[-1].start(1000)

def test_bad_qthread(qapp):
    kept.append(QThread())
    kept[-1].start()

def test_bad_thread(qapp):
    threading.Thread(target=stop.wait, name="sleeper").start()

def test_bad_message(qapp):
    qWarning("something is wrong")

def test_good_after_all(qtbot):
    QWidget().show()
"""


def test_good_tests_pass_and_leaks_are_named(root: Path, tmp_path: Path) -> None:
    guards = (root / "tests/widgets/conftest.py").read_text(encoding="utf-8")
    (tmp_path / "conftest.py").write_text(guards + "\nGRACE = 0.2\n", encoding="utf-8")
    (tmp_path / "test_guarded.py").write_text(TESTS, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nqt_api = pyside6\n", encoding="utf-8")
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-v", "--no-xvfb", "-p", "no:pytest_pyvista"],
        cwd=tmp_path, env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    stained = set(re.findall(r"^ERROR \S+::(\w+)", run.stdout, re.MULTILINE))
    bad = set(re.findall(r"def (test_bad_\w+)", TESTS))
    assert stained == bad, run.stdout + run.stderr
    for name in ("QWidget", "QTimer", "QThread", "sleeper", "something is wrong"):
        assert name in run.stdout
