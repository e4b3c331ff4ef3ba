"""Guards around every window test: nothing may be left over, and Qt may not complain."""

from __future__ import annotations

import gc
import re
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
import shiboken6
from PySide6.QtCore import (
    QEvent,
    QObject,
    QThread,
    QThreadPool,
    QTimer,
    QtMsgType,
    qInstallMessageHandler,
)
from PySide6.QtWidgets import QApplication

FAILED = pytest.StashKey[bool]()
GRACE = 2.0  # seconds that a thread which was told to end may take

# What the platform says of itself, not of our code.
PLATFORM_MESSAGES = (
    r"XDG_RUNTIME_DIR not set",
    r"This plugin does not support (propagateSizeHints|raise|grabbing)",
    r"Could not connect .* to (the )?session (bus|manager)",
)
IGNORED = re.compile("|".join(PLATFORM_MESSAGES))
SEVERE = {QtMsgType.QtWarningMsg, QtMsgType.QtCriticalMsg, QtMsgType.QtFatalMsg}


class QtMessages(list[str]):
    """Warnings that Qt wrote; a test that provokes one on purpose takes it out of the list."""

    def listen(self) -> None:
        """Become the receiver; the one before goes on hearing everything."""
        self._previous = qInstallMessageHandler(self._receive)

    def _receive(self, kind: QtMsgType, context: Any, text: str) -> None:
        if kind in SEVERE and not IGNORED.search(text):
            self.append(text)
        if self._previous is not None:
            self._previous(kind, context, text)


def list_windows() -> list[QObject]:
    # Qt makes and keeps the label of the tool tips itself.
    windows = QApplication.topLevelWidgets()
    return [w for w in windows if w.metaObject().className() != "QTipLabel"]


def list_busy_objects() -> list[QObject]:
    """Timers that tick and threads that run, the thread of the window left out."""
    main = QApplication.instance().thread()
    wrappers = shiboken6.getAllValidWrappers()
    ticking = [w for w in wrappers if isinstance(w, QTimer) and w.isActive()]
    running = [w for w in wrappers if isinstance(w, QThread) and w.isRunning() and w != main]
    return [*ticking, *running]


def list_render_windows() -> list[object]:
    rendering = sys.modules.get("vtkmodules.vtkRenderingCore")
    if rendering is None:
        return []
    return [o for o in gc.get_objects() if isinstance(o, rendering.vtkRenderWindow)]


def list_threads() -> list[threading.Thread]:
    return [t for t in threading.enumerate() if t.name and not t.name.startswith("Dummy")]


def take_stock() -> dict[int, str]:
    """Everything that a test has to put away, by identity."""
    qt = {shiboken6.getCppPointer(o)[0]: o for o in [*list_windows(), *list_busy_objects()]}
    others = {id(o): o for o in [*list_render_windows(), *list_threads()]}
    return {key: repr(thing) for key, thing in {**qt, **others}.items()}


def drain_events() -> None:
    """Handle what is posted; processEvents alone leaves deleteLater() undone."""
    QApplication.processEvents()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    gc.collect()


def find_left_over(before: dict[int, str]) -> list[str]:
    """What is there now and was not before; threads get a moment to end."""
    end = time.monotonic() + GRACE
    while True:
        drain_events()
        pool = QThreadPool.globalInstance().activeThreadCount()
        left = [name for key, name in take_stock().items() if key not in before]
        left += [f"{pool} busy threads in the global QThreadPool"] * (pool > 0)
        if not left or time.monotonic() > end:
            return left
        time.sleep(0.02)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Any:
    report = yield
    if call.when == "call":
        item.stash[FAILED] = report.failed
    return report


@pytest.fixture(autouse=True)
def qt_messages(qapp: QApplication) -> Iterator[QtMessages]:
    """Fail a test in which Qt warned of something that is not on the list above."""
    messages = QtMessages()
    messages.listen()
    yield messages
    qInstallMessageHandler(None)
    assert not messages, "Qt warned:\n" + "\n".join(messages)


@pytest.fixture(autouse=True)
def leak_guard(request: pytest.FixtureRequest, qt_messages: QtMessages) -> Iterator[None]:
    """Fail a test that leaves a window, a ticking timer, a thread or a VTK render window."""
    gc.freeze()  # what is here already need not be searched after every test: a second each
    before = take_stock()
    yield
    qt_messages.listen()  # pytest-qt has put back its own receiver after the call
    for window in list_windows():
        window.close()
    if request.node.stash.get(FAILED, True):
        drain_events()  # the traceback still holds the objects of the test
        return
    left = find_left_over(before)
    assert not left, "left over after the test:\n" + "\n".join(left)
