"""News and errors inside the window: they wait to be read and stop nobody."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from widgets.icons import draw_icon

Kind = Literal["info", "warning", "error"]
Answer = tuple[str, Callable[[], object]]
ICONS: dict[Kind, str] = {"info": "ph.info", "warning": "ph.warning", "error": "ph.warning-circle"}
MOST = 3


class Notice(QFrame):
    """One notice: a sentence, what to do about it, and buttons for doing it.

    Signals
    -------
    closed(Notice)
    """

    closed = Signal(object)

    def __init__(
        self,
        kind: Kind,
        text: str,
        hint: str = "",
        answers: Sequence[Answer] = (),
        topic: str = "",
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.kind, self.text, self.topic = kind, text, topic
        self.buttons: list[QPushButton] = []
        self._deeds = [deed for _, deed in answers]
        self.setProperty("notice", kind)
        self.setAccessibleName(f"{text} {hint}".strip())
        self._symbol = QLabel(self)
        self._cross = QToolButton(self)
        self._cross.setToolTip(self.tr("Close this notice"))
        self._cross.setAccessibleName(self.tr("Close this notice"))
        self._cross.clicked.connect(self.close_notice)
        self._lay_out(text, hint, [title for title, _ in answers])
        self.recolour()

    def recolour(self) -> None:
        """Draw the symbols in the colours of the theme."""
        size = self.fontMetrics().height()
        self._symbol.setPixmap(draw_icon(ICONS[self.kind]).pixmap(round(1.3 * size)))
        self._cross.setIcon(draw_icon("ph.x"))

    def close_notice(self) -> None:
        """Go away."""
        self.closed.emit(self)

    def _lay_out(self, text: str, hint: str, titles: Sequence[str]) -> None:
        em = self.fontMetrics().height()
        message = QLabel(f"{text} {hint}".strip(), self)
        message.setTextFormat(Qt.TextFormat.PlainText)
        message.setWordWrap(True)
        message.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        message.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        row = QHBoxLayout(self)
        row.setContentsMargins(em, em // 3, em // 2, em // 3)
        row.setSpacing(em // 2)
        row.addWidget(self._symbol)
        row.addWidget(message, 1)
        for title in titles:
            button = QPushButton(title, self)
            button.clicked.connect(self._answer)
            self.buttons.append(button)
            row.addWidget(button)
        row.addWidget(self._cross)

    def _answer(self) -> None:
        deed = self._deeds[self.buttons.index(self.sender())]  # type: ignore[arg-type]
        self.close_notice()
        deed()


class NoticeArea(QWidget):
    """A short stack of notices; the same one twice is shown once."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(self.tr("Notices"))
        self.notices: list[Notice] = []
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)

    def show_notice(
        self,
        kind: Kind,
        text: str,
        hint: str = "",
        answers: Sequence[Answer] = (),
        topic: str = "",
    ) -> Notice:
        """Show a notice below the others; the oldest goes when there are too many."""
        for old in list(self.notices):
            if (old.kind, old.text) == (kind, text):
                return old
            if topic and old.topic == topic:
                self.remove(old)
        while len(self.notices) >= MOST:
            self.remove(self.notices[0])
        notice = Notice(kind, text, hint, answers, topic, self)
        notice.closed.connect(self.remove)
        self.notices.append(notice)
        self._column.addWidget(notice)
        return notice

    def remove(self, notice: Notice) -> None:
        """Take a notice away."""
        if notice in self.notices:
            self.notices.remove(notice)
            self._column.removeWidget(notice)
            notice.hide()
            notice.deleteLater()

    def dismiss(self, topic: str) -> None:
        """Take away what has been settled meanwhile."""
        for notice in [notice for notice in self.notices if notice.topic == topic]:
            self.remove(notice)

    def recolour(self, dark: bool = False) -> None:
        """Follow the theme."""
        for notice in self.notices:
            notice.recolour()
