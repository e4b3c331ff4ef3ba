"""The menu bar, built from the table of actions."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QMenuBar

from widgets.actions import ActionTable, Menu

TITLES: tuple[tuple[Menu, str], ...] = (
    ("file", "&File"),
    ("edit", "&Edit"),
    ("scan", "&Scan"),
    ("tools", "&Tools"),
    ("view", "&View"),
    ("help", "&Help"),
)


def build_menus(bar: QMenuBar, table: ActionTable) -> dict[Menu, QMenu]:
    """Fill the menu bar; give the menus."""
    menus: dict[Menu, QMenu] = {}
    for menu, title in TITLES:
        menus[menu] = made = bar.addMenu(QCoreApplication.translate("Menus", title))
        made.setToolTipsVisible(True)
        section = 0
        for action in sorted(table.in_menu(menu), key=lambda action: action.row.section):
            if action.row.section != section:
                made.addSeparator()
                section = action.row.section
            made.addAction(action)
    return menus


def add_panels(menu: QMenu, toggles: list[QAction]) -> None:
    """Put a submenu that shows and hides the panels."""
    panels = menu.addMenu(QCoreApplication.translate("Menus", "&Panels"))
    panels.addActions(toggles)
