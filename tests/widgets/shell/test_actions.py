"""The table of actions, row by row."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import pytest
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QToolButton

from app.model.operations import Select
from app.model.points import PointSet
from widgets.action_rows import list_rows
from widgets.actions import Row, RowAction
from widgets.main_window import MainWindow
from widgets.menus import TITLES
from widgets.theme import ThemeSwitch

pytestmark = pytest.mark.window

ROWS = list_rows()
# What an action needs before it can be used; everything else but the always possible: a scan.
ALWAYS = {
    "file.new", "file.open", "file.series", "file.demo", "file.simulate", "file.quit",
    "tool.navigate", "view.leaves", "view.ghosts", "view.scan_image", "view.full_screen",
    "view.reset_layout", "theme.system", "theme.light", "theme.dark", "help.guide", "help.keys",
    "help.about", "scan.plan",
}  # fmt: skip
SELECTION = {"edit.clear", "edit.delete", "scan.make_leaf"}
LATER = {
    "edit.redo", "edit.bring_back", "scan.columns", "file.export_mesh", "scan.split_leaf",
    "scan.merge_leaves",
}  # fmt: skip
Put = Callable[..., str]
Open = Callable[[ThemeSwitch], AbstractContextManager[MainWindow]]


@dataclass(frozen=True)
class Seen:
    """What one window made of the table, kept after it was closed."""

    menus: dict[str, set[str]]
    actions: dict[str, dict[str, object]]
    enabled: list[set[str]]


@pytest.fixture(scope="module")
def seen(theme: ThemeSwitch, put_scan: Put, open_window: Open) -> Seen:
    with open_window(theme) as window:
        titles = {title: menu for menu, title in TITLES}
        menus = {
            titles[a.text()]: {inner.objectName() for inner in a.menu().actions()}
            for a in window.menuBar().actions()
        }
        actions = {name: describe(action) for name, action in window.table.actions.items()}
        enabled = [list_enabled(window)]
        key = put_scan(window)
        enabled.append(list_enabled(window))
        window.controller.do(Select(key, PointSet([1, 2])))
        enabled.append(list_enabled(window))
    return Seen(menus, actions, enabled)


def describe(action: RowAction) -> dict[str, object]:
    return {
        "keys": tuple(keys.toString() for keys in action.shortcuts()),
        "text": action.text(),
        "tip": action.toolTip(),
        "icon": not action.icon().isNull(),
        "checkable": action.isCheckable(),
    }


def list_enabled(window: MainWindow) -> set[str]:
    return {name for name, action in window.table.actions.items() if action.isEnabled()}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.id)
def test_row_comes_to_life(seen: Seen, row: Row) -> None:
    action = seen.actions[row.id]
    assert row.id in seen.menus[row.menu]
    assert action["keys"] == tuple(QKeySequence(keys).toString() for keys in row.keys)
    assert action["text"] == row.text
    assert action["tip"]
    assert action["icon"] == bool(row.icon)
    assert action["checkable"] == (row.checked is not None)
    assert row.icon or not row.bar
    empty, with_scan, with_selection = (row.id in stage for stage in seen.enabled)
    assert empty == (row.id in ALWAYS)
    assert with_scan == (row.id not in SELECTION | LATER)
    assert with_selection == (row.id not in LATER)


def test_ids_keys_and_mnemonics_are_unique() -> None:
    assert max(Counter(row.id for row in ROWS).values()) == 1
    keys = Counter(QKeySequence(keys).toString() for row in ROWS for keys in row.keys)
    assert [k for k, n in keys.items() if n > 1] == []
    for menu, _ in TITLES:
        texts = [row.text for row in ROWS if row.menu == menu]
        letters = Counter(t[t.index("&") + 1].lower() for t in texts if "&" in t)
        assert [k for k, n in letters.items() if n > 1] == [], menu


def test_every_bar_action_has_a_button(shell: MainWindow) -> None:
    shown = {b.defaultAction() for b in shell.bar.findChildren(QToolButton)}
    assert {a for a in shell.table.actions.values() if a.row.bar} <= shown


def test_one_of_a_group_is_checked(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell)
    for row in ROWS:
        if row.group:
            shell.table.actions[row.id].trigger()
            checked = [r.id for r in ROWS if r.group == row.group
                       and shell.table.actions[r.id].isChecked()]  # fmt: skip
            assert checked == [row.id]


def test_tools_follow_the_actions(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell)
    trigger = shell.table.actions
    trigger["lasso.ghost"].trigger()
    assert (shell.tools.tool, shell.tools.purpose) == ("lasso", "ghost")
    trigger["reach.toggle"].trigger()
    assert shell.tools.mode == "through"
    assert trigger["reach.through"].isChecked()
    trigger["scan.next_leaf"].trigger()
    assert shell.tools.purpose == "leaf"
    assert trigger["lasso.leaf"].isChecked()
    trigger["tool.navigate"].trigger()
    assert shell.tools.tool == "navigate"


def test_edits_go_through_the_history(shell: MainWindow, put_scan: Put) -> None:
    key = put_scan(shell)
    project, trigger = shell.controller.project, shell.table.actions
    total = len(project.state.scan(key).scan)
    shell.controller.do(Select(key, PointSet(range(10))))
    trigger["edit.invert"].trigger()
    assert len(project.state.scan(key).selection) == total - 10
    trigger["edit.delete"].trigger()
    assert project.state.scan(key).shown == 10
    trigger["edit.bring_back"].trigger()
    assert project.state.scan(key).shown == total
    trigger["edit.undo"].trigger()
    assert project.state.scan(key).shown == 10
    assert trigger["edit.redo"].isEnabled()
    trigger["edit.undo"].trigger()
    trigger["scan.make_leaf"].trigger()
    (leaf,) = project.state.leaves.values()
    assert len(leaf.members) == total - 10
    trigger["edit.clear"].trigger()
    assert len(project.state.scan(key).selection) == 0
    trigger["file.close_scan"].trigger()
    assert shell.controller.current is None


def test_view_actions_change_the_view_only(shell: MainWindow, put_scan: Put) -> None:
    put_scan(shell)
    steps = len(shell.controller.project.history.done)
    size = shell.controller.view.point_size
    shell.table.actions["view.larger"].trigger()
    assert shell.controller.view.point_size == size + 1
    for _ in range(9):
        shell.table.actions["view.smaller"].trigger()
    assert shell.controller.view.point_size == 1.0
    shell.table.actions["view.leaves"].trigger()
    assert shell.controller.view.show_leaves
    assert len(shell.controller.project.history.done) == steps


def test_list_of_keys_names_every_shortcut(shell: MainWindow) -> None:
    text = shell.table.describe_keys()
    assert text.count("\n| ") >= sum(bool(row.keys) for row in ROWS)
    assert "| Ctrl+O | Open |" in text
