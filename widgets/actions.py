"""The one table of actions: menus, tool bar, shortcuts and the list of keys are built from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from widgets.desk import Desk
from widgets.icons import draw_icon

Menu = Literal["file", "edit", "scan", "tools", "view", "help"]
Bar = Literal["", "file", "history", "tool", "purpose", "reach", "look"]
Test = Callable[[Desk], bool]


def always(_: Desk) -> bool:
    """For actions that can be had at any time."""
    return True


@dataclass(frozen=True, slots=True)
class Row:
    """One action.

    Attributes
    ----------
    id : str
        Stable name, e.g. ``file.open``.
    text : str
        As in the menu, with its mnemonic.
    deed : callable
        Gets the desk, and whether the action is checked.
    short : str
        Text in the tool bar, where the menu's is too long.
    tip : str
        One line more than the text says.
    section : int
        Sections of a menu are parted by a line.
    group : str
        Of the actions of one group exactly one is checked.
    """

    id: str
    text: str
    deed: Callable[[Desk, bool], object]
    menu: Menu
    keys: tuple[str, ...] = ()
    icon: str = ""
    short: str = ""
    tip: str = ""
    section: int = 0
    bar: Bar = ""
    group: str = ""
    enabled: Test = always
    checked: Test | None = None


class RowAction(QAction):
    """A row come to life."""

    def __init__(self, row: Row, desk: Desk, parent: QObject) -> None:
        super().__init__(row.text, parent)
        self.row, self._desk = row, desk
        self.setObjectName(row.id)
        self.setShortcuts([QKeySequence(keys) for keys in row.keys])
        self.setCheckable(row.checked is not None)
        name = row.text.replace("&", "").rstrip("…")
        self.setIconText(row.short or name)
        keys = f" ({self.shortcut().toString(QKeySequence.SequenceFormat.NativeText)})"
        self.setToolTip((row.tip or name) + (keys if row.keys else ""))
        self.setStatusTip(row.tip)
        self.triggered.connect(self._run)
        self.recolour()

    def refresh(self) -> None:
        """Follow what the desk says of enabled and checked."""
        self.setEnabled(self.row.enabled(self._desk))
        if self.row.checked is not None:
            self.setChecked(self.row.checked(self._desk))

    def recolour(self) -> None:
        """Draw the icon in the colours of the theme."""
        if self.row.icon:
            self.setIcon(draw_icon(self.row.icon))

    def _run(self, checked: bool) -> None:
        self.row.deed(self._desk, checked)
        # A click has toggled it already; what was refused must not stay so.
        self.refresh()


class ActionTable(QObject):
    """All actions of the window, by id.

    Signals
    -------
    refreshed()
    """

    refreshed = Signal()

    def __init__(self, rows: tuple[Row, ...], desk: Desk, window: QWidget) -> None:
        super().__init__(window)
        self.rows = rows
        self.actions: dict[str, RowAction] = {}
        self._groups: dict[str, QActionGroup] = {}
        for row in rows:
            action = self.actions[row.id] = RowAction(row, desk, self)
            window.addAction(action)
            if row.group:
                self._groups.setdefault(row.group, QActionGroup(self)).addAction(action)
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Bring every action up to date."""
        for action in self.actions.values():
            action.refresh()
        self.refreshed.emit()

    def recolour(self, *_: object) -> None:
        """Draw every icon anew."""
        for action in self.actions.values():
            action.recolour()

    def in_menu(self, menu: Menu) -> list[RowAction]:
        """Actions of a menu, in order."""
        return [action for action in self.actions.values() if action.row.menu == menu]

    def in_bar(self, bar: Bar) -> list[RowAction]:
        """Actions of a group of the tool bar, in order."""
        return [action for action in self.actions.values() if action.row.bar == bar]

    def describe_keys(self) -> str:
        """Keys and mouse as Markdown."""
        native = QKeySequence.SequenceFormat.NativeText
        lines = [
            f"| {' or '.join(k.toString(native) for k in action.shortcuts())} "
            f"| {action.row.text.replace('&', '').rstrip('…')} |"
            for action in self.actions.values()
            if action.row.keys
        ]
        head = self.tr("| Keys | What they do |\n|---|---|\n")
        mouse = self.tr(
            "\n\n**Mouse**: left turns, middle or right moves, wheel zooms at the cursor, double "
            "click sets the centre. **Lasso**: Shift adds, Ctrl or Alt takes away, hold Space to "
            "turn, Esc puts it away.\n"
        )
        ghosts = self.tr(
            "\n\n**Clean-up of ghosts** (panel Ghosts, Go through; with the focus on the queue or "
            "the picture): N next, P previous, A accept, R keep, D delete, C correct.\n"
        )
        return head + "\n".join(lines) + mouse + ghosts
