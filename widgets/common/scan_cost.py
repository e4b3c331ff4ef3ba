"""What a simulated scan will cost, worked out in the background while it is being chosen."""

from __future__ import annotations

import shiboken6
from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.core.errors import Cancelled, LeafscopeError
from app.core.progress import Progress
from app.services.jobs import Job
from app.services.simulation_order import Estimate, Order, estimate, refuse_too_large, set_up
from widgets.common.notice import Notice
from widgets.common.numbers import show_count
from widgets.controller import Controller

CALM = 250  # ms without a change, after which it is worked out
DIGITS = 2  # of the number of points that an estimate is good for


class ScanCost(QWidget):
    """Beams and points of an order, or why it cannot be carried out.

    Signals
    -------
    settled(bool)
        The order was looked at: it can be carried out, or not.
    """

    settled = Signal(bool)

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._order: Order | None = None
        self._job: Job | None = None
        self._calm = QTimer(self, singleShot=True, interval=CALM)
        self._calm.timeout.connect(self._begin)
        self.text = QLabel(self)
        self.text.setWordWrap(True)
        self.text.setProperty("faint", "true")
        self.notice = Notice(self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.text)
        column.addWidget(self.notice)
        column.addStretch()

    def ask(self, order: Order) -> None:
        """Work out another order, once it has stood for a moment."""
        if order != self._order:
            self.stop()
            self._order = order
            self.notice.say("")
            self.text.show()
            self.text.setText(self.tr("Counting beams and points…"))
            self._calm.start()

    def stop(self) -> None:
        """What is being worked out is not needed any more."""
        self._calm.stop()
        self._order = None
        if self._job is not None:
            self._job.cancel()

    def refuse(self, error: LeafscopeError) -> None:
        """Say what is wrong."""
        self.text.hide()
        self.notice.say(str(error))
        self.settled.emit(False)

    def _begin(self) -> None:
        order = self._order
        if order is None:
            return

        def work(progress: Progress) -> Estimate | LeafscopeError:
            try:
                setup = set_up(order.document(), order.origin, order.noise)
                found = estimate(setup, progress)
                refuse_too_large(setup, found)
            except Cancelled:
                raise
            except LeafscopeError as error:
                return error
            return found

        def done(found: Estimate | LeafscopeError) -> None:
            if shiboken6.isValid(self) and order == self._order:
                self._show(found)

        self._job = self._controller.run(self.tr("Counting beams and points"), work, done)

    def _show(self, found: Estimate | LeafscopeError) -> None:
        if isinstance(found, LeafscopeError):
            self.refuse(found)
            return
        text = self.tr("{0} beams, about {1} points.")
        points = round_count(found.points)
        self.text.setText(text.format(show_count(found.beams), show_count(points)))
        self.settled.emit(True)


def round_count(count: int) -> int:
    """A count with no more digits than an estimate deserves."""
    return int(float(f"{count:.{DIGITS - 1}e}"))
