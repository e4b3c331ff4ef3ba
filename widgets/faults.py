"""One place for everything that went wrong without being caught: say it, log it, go on."""

from __future__ import annotations

import faulthandler
import logging
import sys
import threading
import traceback
from dataclasses import dataclass
from types import TracebackType

from PySide6.QtCore import (
    QCoreApplication,
    QMessageLogContext,
    QObject,
    QtMsgType,
    Signal,
    qInstallMessageHandler,
)

from app import __version__
from app.core.errors import LeafscopeError

LOG = logging.getLogger("leafscope")
LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtWarningMsg: logging.WARNING,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}


@dataclass(frozen=True, slots=True)
class Trouble:
    """An error in words: what happened, what to do, and the trace for a report."""

    what: str
    hint: str
    details: str

    @classmethod
    def of(cls, error: BaseException) -> Trouble:
        """Put an error into words."""
        trace = "".join(traceback.format_exception(error))
        if isinstance(error, LeafscopeError):
            return cls(error.what, error.hint, trace)
        translate = QCoreApplication.translate
        what = translate("Trouble", "Something went wrong: {0}.")
        hint = translate("Trouble", "What you just did may be incomplete; the rest goes on.")
        return cls(what.format(str(error).rstrip(".") or type(error).__name__), hint, trace)

    def report(self) -> str:
        """The text that "Copy report" copies."""
        system = f"Leafscope {__version__}, Python {sys.version.split()[0]}, {sys.platform}"
        return f"{self.what}\n{self.hint}\n\n{system}\n\n{self.details}"


class Faults(QObject):
    """Receives what Python, its threads and Qt could not handle.

    Signals
    -------
    raised(BaseException)
    """

    raised = Signal(object)

    def watch(self) -> None:
        """Become the receiver for the whole process."""
        logging.basicConfig(format="%(levelname)s %(name)s: %(message)s")
        if sys.stderr is not None:
            faulthandler.enable()
        sys.excepthook = self.take
        threading.excepthook = self._take_from_thread
        qInstallMessageHandler(self._take_message)

    def take(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        """Log an error and pass it on; Ctrl-C ends the program."""
        if issubclass(kind, KeyboardInterrupt):
            QCoreApplication.exit(130)
            return
        LOG.error("not caught", exc_info=(kind, error, trace))
        self.raised.emit(error)

    def _take_from_thread(self, fault: threading.ExceptHookArgs) -> None:
        error = fault.exc_value if fault.exc_value is not None else fault.exc_type()
        self.take(fault.exc_type, error, fault.exc_traceback)

    def _take_message(self, kind: QtMsgType, context: QMessageLogContext, text: str) -> None:
        LOG.getChild("qt").log(LEVELS.get(kind, logging.WARNING), text)
        if kind == QtMsgType.QtCriticalMsg:
            self.raised.emit(LeafscopeError(text))
