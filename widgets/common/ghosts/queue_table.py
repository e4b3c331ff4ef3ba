"""The queue of ghosts as a table: text is made only for the rows that are drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QFont

from app.core.arrays import AnyArray, Ints
from app.core.ghosts import WORDS as REASONS
from app.core.ghosts import Reason
from app.services.cleanup.answers import Answer
from app.services.cleanup.plan import Plan
from widgets.common.numbers import UNKNOWN, show_number

Index = QModelIndex | QPersistentModelIndex
SCORE, LEAF, WHY, ANSWER = range(4)


class QueueTable(QAbstractTableModel):
    """One row per ghost: score, leaf, why, and the answer; open ones show the proposal."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._plan: Plan | None = None
        self._order: Ints = np.empty(0, np.int64)
        self._answers: AnyArray = np.empty(0, np.int8)
        self._given: AnyArray = np.empty(0, bool)

    def show_queue(self, plan: Plan | None, order: Ints) -> None:
        """Take another plan, or another part of it."""
        self.beginResetModel()
        self._plan, self._order = plan, order
        size = 0 if plan is None else len(plan)
        self._answers, self._given = np.zeros(size, np.int8), np.zeros(size, bool)
        self.endResetModel()

    def show_answers(self, answers: AnyArray, given: AnyArray) -> None:
        """Take the answers to all ghosts of the plan, and whether the user gave them."""
        self._answers, self._given = answers, given
        if len(self._order):
            last = self.index(len(self._order) - 1, ANSWER)
            self.dataChanged.emit(self.index(0, ANSWER), last)

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008
        """One row per ghost."""
        return 0 if parent.isValid() else len(self._order)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008
        """Score, leaf, why, answer."""
        return 0 if parent.isValid() else 4

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:  # noqa: N802
        """Titles."""
        if orientation != Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            titles = (self.tr("Score"), self.tr("Leaf"), self.tr("Why"), self.tr("Answer"))
            return titles[section]
        if role == Qt.ItemDataRole.ToolTipRole:
            tips = (
                self.tr("Ghost score, 0 to 1"),
                self.tr("Leaf of the point, or of the nearest surface in range"),
                self.tr("What kind of ghost it is"),
                self.tr("Your answer, bold; in brackets what is proposed"),
            )
            return tips[section]
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Text of one ghost."""
        if self._plan is None:
            return None
        place, column = int(self._order[index.row()]), index.column()
        if role == Qt.ItemDataRole.DisplayRole:
            return self._write(self._plan, place, column)
        if role == Qt.ItemDataRole.ToolTipRole:
            return self._plan.explain(place)
        if role == Qt.ItemDataRole.FontRole and column == ANSWER and self._given[place]:
            font = QFont()
            font.setBold(True)
            return font
        return None

    def _write(self, plan: Plan, place: int, column: int) -> str:
        if column == SCORE:
            return show_number(float(plan.score[place]))
        if column == LEAF:
            leaf = int(plan.leaf[place])
            return UNKNOWN if leaf < 0 else plan.names.names[leaf]
        if column == WHY:
            if plan.reasons is None:
                return UNKNOWN
            return self._shorten(Reason(int(plan.reasons.reason[place])))
        word = self.name(Answer(int(self._answers[place]))) if self._answers[place] else UNKNOWN
        return word if self._given[place] else f"({word})"

    def name(self, answer: Answer) -> str:
        """An answer in a word."""
        return {
            Answer.KEEP: self.tr("keep"),
            Answer.LEAVE: self.tr("mark"),
            Answer.DELETE: self.tr("delete"),
            Answer.CORRECT: self.tr("correct"),
        }[answer]

    def _shorten(self, reason: Reason) -> str:
        return {
            Reason.BETWEEN: self.tr("between"),
            Reason.BESIDE: self.tr("beside"),
            Reason.ALONE: self.tr("alone"),
            Reason.STEEP: self.tr("steep"),
            Reason.WEAK: self.tr("weak"),
        }.get(reason, REASONS[reason])
