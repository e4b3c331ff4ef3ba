"""The answers that many ghosts can be given at once."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QMenu, QWidget

from app.services.cleanup.answers import Answer


class AnswerMenu(QMenu):
    """Accept, keep, delete, correct, or take answers back.

    Signals
    -------
    chosen(Answer or None, bool)
        The answer, and whether the proposals are accepted instead.
    """

    chosen = Signal(object, bool)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        for text, answer, accept in (
            (self.tr("&Accept the proposals"), None, True),
            (self.tr("&Keep all"), Answer.KEEP, False),
            (self.tr("&Delete all"), Answer.DELETE, False),
            (self.tr("&Correct all"), Answer.CORRECT, False),
            (self.tr("&Take answers back"), None, False),
        ):
            self.addAction(text).triggered.connect(partial(self._choose, answer, accept))

    def _choose(self, answer: Answer | None, accept: bool, _: bool = False) -> None:
        self.chosen.emit(answer, accept)
