"""The application object: names, mark, style, and a Ctrl-C that works."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Sequence
from types import FrameType

from PySide6.QtCore import QCoreApplication, QObject, QSocketNotifier, Slot
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication

from app import __version__
from widgets.icons import load_mark


def make_application(arguments: Sequence[str]) -> QApplication:
    """Make the application; its style sheet and palette are the theme's."""
    os.environ.setdefault("QT_API", "pyside6")  # for libraries that support several bindings
    QCoreApplication.setApplicationName("leafscope")
    QCoreApplication.setOrganizationName("leafscope")
    QCoreApplication.setApplicationVersion(__version__)
    QGuiApplication.setDesktopFileName("leafscope")
    application = QApplication([*arguments])
    application.setApplicationDisplayName("Leafscope")
    application.setWindowIcon(load_mark())
    application.setStyle("Fusion")
    return application


class Interrupts(QObject):
    """Ends the application on Ctrl-C or a polite kill.

    Python runs signal handlers between two of its own steps, and Qt's loop may not take any
    for hours: the signal writes a byte to a socket that Qt watches.
    """

    def __init__(self, application: QApplication) -> None:
        super().__init__(application)
        self._read, self._write = socket.socketpair()
        for end in (self._read, self._write):
            end.setblocking(False)
        self._notifier = QSocketNotifier(self._read.fileno(), QSocketNotifier.Type.Read, self)
        self._notifier.activated.connect(self._wake)
        signal.set_wakeup_fd(self._write.fileno())
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._stop)

    @Slot()
    def _wake(self) -> None:
        self._read.recv(64)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        QCoreApplication.exit(128 + number)
