"""A user of the real window: clicks, keys and eyes.

With LEAFSCOPE_PICTURES set to a folder, each look leaves its picture there: this is how the
pictures of README and guide are made (``packaging/pictures``).
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QGuiApplication, QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QComboBox,
    QDialogButtonBox,
    QFileDialog,
    QLineEdit,
    QPushButton,
    QTabBar,
    QToolButton,
    QWidget,
)
from pytestqt.qtbot import QtBot

import app.core.kernels  # noqa: F401 - chooses its cache before the fixture hides the user's
from widgets.common.panel import Column
from widgets.main_window import MainWindow
from widgets.theme import ThemeSwitch

PICTURES = os.environ.get("LEAFSCOPE_PICTURES")
LEFT = Qt.MouseButton.LeftButton
PATIENCE = 60_000


class User:
    """Hands and eyes: clicks on what is on the screen, waits until the window is at rest."""

    def __init__(self, window: MainWindow, qtbot: QtBot) -> None:
        self.window, self._qtbot = window, qtbot
        self._taken = 0

    def wait_for(self, condition) -> None:
        self._qtbot.waitUntil(condition, timeout=PATIENCE)

    def rest(self) -> None:
        controller = self.window.controller
        for _ in range(3):  # the end of a job may begin another
            self.wait_for(lambda: not controller.bridge.jobs and not controller._later.isActive())
            view = self.window.picture.view
            self.wait_for(lambda view=view: view is None or not view.isVisible() or view.at_rest)
            QTest.qWait(30)

    def look(self, name: str) -> None:
        """Keep a picture of the screen, where somebody wants pictures."""
        self.rest()
        if PICTURES:
            QTest.qWait(300)
            screen = QGuiApplication.primaryScreen()
            picture = screen.grabWindow(self.window.winId())
            assert picture.save(str(Path(PICTURES) / f"{name}.png"))

    def click(self, widget: QWidget, place: QPoint | None = None) -> None:
        assert widget.isVisible(), widget
        assert widget.isEnabled(), widget
        QTest.mouseClick(widget, LEFT, pos=place or widget.rect().center())

    def press(self, text: str, inside: QWidget | None = None) -> None:
        """Click the button that says so."""
        buttons = (inside or self.window).findChildren(QPushButton)
        self.click(next(b for b in buttons if b.isVisible() and b.text().replace("&", "") == text))

    def tool(self, action: str) -> None:
        """Click the tool button of an action."""
        wanted = self.window.table.actions[action]
        buttons = self.window.bar.findChildren(QToolButton)
        self.click(next(b for b in buttons if b.defaultAction() is wanted))

    def keys(self, keys: str) -> None:
        pressed = QKeySequence(keys)[0]
        QTest.keyClick(self.window, pressed.key(), pressed.keyboardModifiers())

    def panel(self, name: str) -> QWidget:
        """Click the tab of a panel."""
        title = self.window.docks.docks[name].windowTitle()
        for bar in self.window.findChildren(QTabBar):
            for tab in range(bar.count()):
                if bar.tabText(tab) == title and bar.isVisible():
                    self.click(bar, bar.tabRect(tab).center())
        panel = self.window.docks.panels[name]
        self.wait_for(panel.isVisible)
        return panel

    def scroll_to(self, panel: QWidget, widget: QWidget) -> None:
        """Bring something that has been scrolled away into sight."""
        panel.findChild(Column).ensureWidgetVisible(widget)
        QTest.qWait(50)

    def choose(self, combo: QComboBox, text: str) -> None:
        """Go down a list with the keys to the entry that begins so."""
        combo.setFocus()
        QTest.keyClick(combo, Qt.Key.Key_Home)
        for _ in range(combo.count()):
            if not combo.currentText().startswith(text):
                QTest.keyClick(combo, Qt.Key.Key_Down)
        assert combo.currentText().startswith(text), combo.currentText()
        self.rest()

    def colour_by(self, field: str) -> None:
        """Choose a field in the list, with the mouse."""
        combo = self.window.colour_by
        row = next(i for i in range(combo.count()) if combo.itemData(i, 0x100) == field)
        self.click(combo, QPoint(combo.width() - 6, combo.height() // 2))
        popup = combo.view()
        self.wait_for(popup.isVisible)
        popup.scrollTo(combo.model().index(row, 0))
        place = popup.visualRect(combo.model().index(row, 0)).center()
        QTest.qWait(QApplication.doubleClickInterval() + 50)  # Qt ignores a click at once
        QTest.mouseClick(popup.viewport(), LEFT, pos=place)
        self.wait_for(lambda: self.window.controller.view.colour == field)
        self.rest()

    def lasso(self, corners: list[QPointF], *modifiers: Qt.KeyboardModifier) -> None:
        """Draw a contour with the mouse."""
        view = self.window.picture.view
        modifier = modifiers[0] if modifiers else Qt.KeyboardModifier.NoModifier
        spots = [QPoint(round(c.x() * view.width()), round(c.y() * view.height())) for c in corners]
        QTest.mousePress(view, LEFT, modifier, spots[0])
        for spot in spots[1:]:
            QTest.mouseMove(view, spot)
            QTest.qWait(5)
        QTest.mouseRelease(view, LEFT, modifier, spots[-1])
        self.rest()

    def name_file(self, path: Path) -> None:
        """Type a name into the file dialog that is open, and agree."""
        dialogs = lambda: [d for d in self.window.findChildren(QFileDialog) if d.isVisible()]  # noqa: E731
        self.wait_for(lambda: bool(dialogs()))
        # Where no file of that name lies: Qt would ask in a loop that holds the interpreter.
        dialogs()[0].setDirectory(str(path.parent))
        line = dialogs()[0].findChild(QLineEdit)
        line.setFocus()
        line.selectAll()
        QTest.keyClicks(line, path.name)
        box = dialogs()[0].findChild(QDialogButtonBox)
        saving = dialogs()[0].acceptMode() == QFileDialog.AcceptMode.AcceptSave
        standard = QDialogButtonBox.StandardButton
        self.click(box.button(standard.Save if saving else standard.Open))
        self.wait_for(lambda: not dialogs())
        self.rest()


@pytest.fixture
def user(
    qtbot: QtBot, qapp: QApplication, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Iterator[User]:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    palette, sheet = qapp.palette(), qapp.styleSheet()
    theme = ThemeSwitch(qapp)
    theme.apply("light")
    window = MainWindow(theme)
    window.resize(1480, 940)
    window.show()
    qtbot.waitExposed(window)
    window.activateWindow()  # no window manager does it here, and shortcuts need it
    user = User(window, qtbot)
    user.wait_for(lambda: window.picture.view is not None)
    yield user
    window._agreed_to_close = True
    window.close()
    window.deleteLater()
    qapp.setStyleSheet(sheet)  # later tests find the application as it was
    qapp.setPalette(palette)
