"""PySide6 keeps its reference counts.

PySide6 6.12 on Python 3.11 lost a reference to None or True each time a slot or an overridden
method returned one, and the process aborted after some 11 000 of them.
"""

from __future__ import annotations

import subprocess
import sys

EMIT = """
import sys
from PySide6.QtCore import QCoreApplication, QEvent, QObject, Signal, Slot

class Sender(QObject):
    fired = Signal(int)

class Receiver(QObject):
    calls = 0

    @Slot(int, result=bool)
    def answer_true(self, value):
        Receiver.calls += 1
        return True

    def answer_nothing(self, value):
        Receiver.calls += 1

    def eventFilter(self, watched, event):
        Receiver.calls += 1
        return True

application = QCoreApplication(sys.argv)
sender, receiver = Sender(), Receiver()
sender.fired.connect(receiver.answer_true)
sender.fired.connect(receiver.answer_nothing)
sender.installEventFilter(receiver)
for value in range(50_000):
    sender.fired.emit(value)
    QCoreApplication.sendEvent(sender, QEvent(QEvent.Type.User))
print(Receiver.calls)
"""


def test_fifty_thousand_signals_leave_the_process_alive() -> None:
    run = subprocess.run(
        [sys.executable, "-c", EMIT], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, f"exit code {run.returncode}: {run.stderr[-2000:]}"
    assert run.stdout.split() == ["150000"]
