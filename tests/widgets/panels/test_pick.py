"""The pick panel shows values and copies them."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from widgets.panels.pick import PickPanel

VALUES = [("Point", 4711, ""), ("x", 2.5, "m"), ("Incidence angle", 23.25, "°")]


def test_values_are_shown_and_copied(desk, qtbot) -> None:
    panel = desk.show(PickPanel)
    assert "Click a point" in panel.notice.text
    assert not panel.table.isVisible()
    panel.set_values(VALUES)
    assert panel.table.rowCount() == 3
    assert panel.table.item(2, 1).text() == "23.25"
    assert panel.table.item(2, 1).textAlignment() & Qt.AlignmentFlag.AlignRight
    wanted = "Point\t4711\t\nx\t2.5\tm\nIncidence angle\t23.25\t°"
    qtbot.mouseClick(panel.copy_button, Qt.MouseButton.LeftButton)
    assert QGuiApplication.clipboard().text() == wanted
    QGuiApplication.clipboard().clear()
    panel.activateWindow()
    qtbot.waitUntil(panel.isActiveWindow)
    panel.table.setFocus()
    qtbot.keyClick(panel.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert QGuiApplication.clipboard().text() == wanted


def test_no_values_clear_the_panel(desk, qtbot) -> None:
    panel = desk.show(PickPanel)
    panel.set_values(VALUES)
    panel.set_values([])
    assert "Click a point" in panel.notice.text
    assert not panel.copy_button.isVisible()


def test_why_a_point_is_a_ghost_stands_below_and_is_copied(desk, qtbot) -> None:
    panel = desk.show(PickPanel)
    panel.explain("Ghost (score 0.93): alone")
    assert not panel.ghost.isVisible(), "there is no point yet"
    panel.set_values(VALUES)
    panel.explain("Ghost (score 0.93): between leaf 12 (−14 mm) and wall (+2.1 m)")
    assert panel.ghost.isVisible()
    qtbot.mouseClick(panel.copy_button, Qt.MouseButton.LeftButton)
    last = QGuiApplication.clipboard().text().split("\n")[-1]
    assert last == "Ghost\tGhost (score 0.93): between leaf 12 (−14 mm) and wall (+2.1 m)\t"
    panel.set_values([])
    assert not panel.ghost.isVisible()
