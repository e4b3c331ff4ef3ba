"""The history lists every step, and a click goes there."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QPalette

from app.model.parameters import Curve
from app.model.project import Project
from app.model.view_state import ViewState
from widgets.panels.history import HistoryPanel


def texts(panel) -> list[str]:
    return [panel.list.item(i).text() for i in range(panel.list.count())]


def click(panel, qtbot, row: int) -> None:
    place = panel.list.visualItemRect(panel.list.item(row)).center()
    qtbot.mouseClick(panel.list.viewport(), Qt.MouseButton.LeftButton, pos=place)


def test_a_click_jumps_back_and_forth(opened, qtbot) -> None:
    panel = opened.show(HistoryPanel)
    assert texts(panel) == ["Start", "Open bent leaf", "Make Leaf 1 (2\u202f501 points)",
                            "Make Leaf 2 (2\u202f501 points)"]  # fmt: skip
    assert panel.list.currentRow() == 3
    click(panel, qtbot, 2)
    assert list(opened.state.leaves) == ["leaf-00001"]
    qtbot.waitUntil(lambda: panel.list.item(3).font().italic())
    grey = panel.palette().brush(QPalette.ColorRole.PlaceholderText)
    assert panel.list.item(3).foreground() == grey
    assert not panel.list.item(2).font().italic()
    click(panel, qtbot, 0)
    assert not opened.state.scans
    click(panel, qtbot, 3)
    assert len(opened.state.leaves) == 2


def test_undo_elsewhere_and_new_steps_are_followed(opened, qtbot) -> None:
    panel = opened.show(HistoryPanel)
    opened.controller.undo()
    qtbot.waitUntil(lambda: panel.list.currentRow() == 2)
    opened.work.rename("leaf-00001", "Flag leaf")
    qtbot.waitUntil(lambda: texts(panel)[-1].startswith("Rename Flag leaf"))
    assert len(texts(panel)) == 4


def test_parameters_are_named(opened, qtbot) -> None:
    panel = opened.show(HistoryPanel)
    opened.work.set_parameters(ghost_threshold=0.3)
    opened.work.set_parameters(radius=0.006)
    opened.work.use_curve(Curve("lambert", {"f": 1.0}, "near", "set by hand"))
    qtbot.waitUntil(lambda: len(texts(panel)) == 7)
    assert texts(panel)[4:] == [
        "Set ghost threshold to 0.30",
        "Set neighbour radius to 6 mm",
        "Use curve Lambert (set by hand)",
    ]


def test_inverses_on_disk_are_told(desk, qtbot, make_scan) -> None:
    panel = desk.show(HistoryPanel)
    assert not panel.note.isVisible()
    desk.controller.adopt(Project(undo_cap=0), ViewState())
    desk.make_halves(desk.open(make_scan()))
    qtbot.waitUntil(panel.note.isVisible)
    assert "2" in panel.note.text()
    assert "disk" in panel.note.text()
