"""The scans panel lists scans, hides, groups and closes them, and tells their facts."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QStyle, QStyleOptionViewItem

from app.model.operations import SetDeleted
from app.model.points import PointSet
from widgets.common.scan_tree import KEY
from widgets.panels.scans import ScansPanel


@pytest.fixture
def two(desk, qtbot, make_scan):
    """A panel with two scans; the second is current and has no position."""
    desk.first = desk.open(make_scan("SALCA"))
    desk.second = desk.open(make_scan("Leica", pose=False))
    desk.panel = desk.show(ScansPanel)
    return desk


def item_of(panel, key: str):
    return next((item for item in panel.tree.items() if item.data(0, KEY) == key), None)


def count_children(panel, key: str) -> int:
    item = item_of(panel, key)
    return 0 if item is None else item.childCount()


def click(panel, qtbot, key: str, keys=Qt.KeyboardModifier.NoModifier) -> None:
    place = panel.tree.visualItemRect(item_of(panel, key)).center()
    qtbot.mouseClick(panel.tree.viewport(), Qt.MouseButton.LeftButton, keys, place)


def tick(panel, qtbot, key: str) -> None:
    index = panel.tree.indexFromItem(item_of(panel, key))
    option = QStyleOptionViewItem()
    option.initFrom(panel.tree)
    option.rect = panel.tree.visualRect(index)
    option.features |= QStyleOptionViewItem.ViewItemFeature.HasCheckIndicator
    box = panel.tree.style().subElementRect(
        QStyle.SubElement.SE_ItemViewItemCheckIndicator, option, panel.tree
    )
    qtbot.mouseClick(panel.tree.viewport(), Qt.MouseButton.LeftButton, pos=box.center())


def test_facts_of_the_current_scan(two, qtbot) -> None:
    panel = two.panel
    assert panel.facts.texts["Scanner"].startswith("unknown")
    assert panel.facts.texts["Grid"] == "61 rows × 121 columns"
    click(panel, qtbot, two.first)
    assert two.controller.current == two.first
    qtbot.waitUntil(lambda: "given by you" in panel.facts.texts["Scanner"])
    assert panel.channels.item(0, 0).text() == "near"
    assert panel.channels.item(0, 1).text() == "1063"
    assert item_of(panel, two.first).font(0).bold()


def test_shown_and_total_follow_deletion_and_undo(two, qtbot) -> None:
    two.controller.do(SetDeleted(two.first, PointSet(range(81))))
    qtbot.waitUntil(lambda: item_of(two.panel, two.first).text(1) == "7\u202f300 / 7\u202f381")
    two.controller.undo()
    qtbot.waitUntil(lambda: item_of(two.panel, two.first).text(1) == "7\u202f381 / 7\u202f381")


def test_a_tick_hides_and_shows(two, qtbot) -> None:
    tick(two.panel, qtbot, two.first)
    assert two.controller.view.hidden == (two.first,)
    tick(two.panel, qtbot, two.first)
    assert two.controller.view.hidden == ()


def test_group_rename_ungroup_undo(two, qtbot) -> None:
    panel = two.panel
    click(panel, qtbot, two.first)
    assert not panel.group_button.isEnabled()
    click(panel, qtbot, two.second, Qt.KeyboardModifier.ControlModifier)
    qtbot.mouseClick(panel.group_button, Qt.MouseButton.LeftButton)
    (sample,) = two.state.samples.values()
    assert set(sample.scans) == {two.first, two.second}
    qtbot.waitUntil(lambda: count_children(panel, sample.key) == 2)
    item_of(panel, sample.key).setText(0, "Birch 3")
    assert two.state.samples[sample.key].name == "Birch 3"
    click(panel, qtbot, two.first)
    qtbot.mouseClick(panel.ungroup_button, Qt.MouseButton.LeftButton)
    assert not two.state.samples
    two.controller.undo()
    qtbot.waitUntil(lambda: count_children(panel, sample.key) == 2)


def test_close_and_undo(two, qtbot) -> None:
    panel = two.panel
    click(panel, qtbot, two.second)
    qtbot.mouseClick(panel.close_button, Qt.MouseButton.LeftButton)
    assert two.state.scans[two.second].closed
    assert two.controller.current == two.first
    qtbot.waitUntil(lambda: len(list(panel.tree.items())) == 1)
    two.controller.undo()
    qtbot.waitUntil(lambda: len(list(panel.tree.items())) == 2)


def test_closing_the_last_scan_says_how_to_open_one(desk, qtbot, make_scan) -> None:
    desk.open(make_scan())
    panel = desk.show(ScansPanel)
    qtbot.mouseClick(panel.close_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "No scan is open" in panel.notice.text)
    assert desk.controller.current is None
    assert not panel.body.isVisible()


def test_position_and_channel_are_asked_for(two, qtbot) -> None:
    panel = two.panel
    with qtbot.waitSignal(panel.origin_asked) as asked:
        qtbot.mouseClick(panel.origin_button, Qt.MouseButton.LeftButton)
    assert asked.args == [two.second]
    row = panel.channels.visualItemRect(panel.channels.item(1, 0)).center()
    qtbot.mouseClick(panel.channels.viewport(), Qt.MouseButton.LeftButton, pos=row)
    with qtbot.waitSignal(panel.channel_asked) as asked:
        qtbot.mouseClick(panel.channel_button, Qt.MouseButton.LeftButton)
    assert asked.args == [two.second, "far"]
    with qtbot.waitSignal(panel.channel_asked) as asked:
        place = panel.channels.viewport(), Qt.MouseButton.LeftButton
        qtbot.mouseClick(*place, pos=QPoint(5, 5))
        qtbot.mouseDClick(*place, pos=QPoint(5, 5))
    assert asked.args == [two.second, "near"]


def test_a_position_that_is_given_is_told(two, qtbot) -> None:
    two.documents.set_origin(two.second, (1.0, 2.0, 3.0))
    qtbot.waitUntil(lambda: two.panel.facts.texts["Scanner"].startswith("1.000; 2.000; 3.000 m"))
    assert "given by you" in two.panel.facts.texts["Scanner"]
    two.controller.undo()
    qtbot.waitUntil(lambda: two.panel.facts.texts["Scanner"].startswith("unknown"))
