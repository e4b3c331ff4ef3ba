"""Few points while the camera moves, all when it rests, in steps that can be interrupted."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal

from app.render.lod import FrameBudget, count_blocks
from app.render.stage import Stage
from widgets.viewport.canvas import Canvas

REST_MS = 160
PATIENCE = 2.5  # a step at rest may take longer: each costs a copy to the screen


class Refinement(QObject):
    """Decides which blocks the next frame holds.

    A frame that begins anew holds a prefix that fits the budget. When the view rests, the
    blocks that are missing are drawn over it, a few at a time: the whole cloud is drawn once,
    and a hand on the mouse never waits for more than one step.

    Signals
    -------
    progressed()
        The number of drawn points changed.
    """

    progressed = Signal()

    def __init__(self, stage: Stage, canvas: Canvas, parent: QObject) -> None:
        super().__init__(parent)
        self.budget = FrameBudget()
        self.drawn = 0
        self.complete = True
        self._stage, self._canvas = stage, canvas
        self._next = 0
        self._pending = 0
        self._held = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self._add)
        canvas.rendered.connect(self._note_frame)
        canvas.resized.connect(self.begin)

    def begin(self, hold: bool = False) -> None:
        """Draw anew. `hold`: something is still moving, so wait before refining."""
        self._timer.stop()
        self._held = hold
        self._stage.draw_over(False)
        self._next = self.drawn = 0
        self._show_more()

    def stop(self) -> None:
        """Draw nothing more."""
        self._timer.stop()
        self.complete = True

    def _add(self) -> None:
        self._held = False
        self._stage.draw_over(True)
        self._show_more()

    def _show_more(self) -> None:
        blocks = self._stage.blocks
        largest, total = self._stage.points_of_largest()
        patience = 1.0 if self._held or self._next == 0 else PATIENCE
        allowed = patience * self.budget.points * largest / max(total, 1)
        more = count_blocks(blocks, allowed, self._next)
        self._pending = self._stage.show_blocks(self._next, self._next + more)
        self._next += more
        self.complete = self._next >= len(blocks)
        self._canvas.draw()

    def _note_frame(self, seconds: float) -> None:
        self.budget.record(self._pending, seconds)
        self.drawn += self._pending
        self._pending = 0
        self.progressed.emit()
        if not self.complete:
            self._timer.start(REST_MS if self._held else 0)
