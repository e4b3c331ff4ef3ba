"""What the View and Help menus do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QMainWindow

from app import __version__
from app.model.view_state import Theme
from widgets.controller import Controller
from widgets.dialogs.guide import GuideDialog
from widgets.docks import Docks
from widgets.theme import ThemeSwitch

if TYPE_CHECKING:
    from widgets.actions import ActionTable

SMALLEST_POINT, LARGEST_POINT, STEP = 1.0, 12.0, 1.0


class ViewDeeds(QObject):
    """Point size, theme, layout and help."""

    def __init__(
        self, window: QMainWindow, controller: Controller, theme: ThemeSwitch, docks: Docks
    ) -> None:
        super().__init__(window)
        self._window, self._controller, self._theme = window, controller, theme
        self._docks = docks
        self._layout = window.saveState()
        self.table: ActionTable | None = None

    @property
    def theme(self) -> Theme:
        """The theme that was chosen."""
        return self._theme.choice

    def choose_theme(self, theme: Theme) -> None:
        """Take a theme and remember it with the view."""
        self._theme.apply(theme)
        self._controller.look(theme=theme)

    def scale_points(self, steps: int) -> None:
        """Draw points larger or smaller."""
        size = self._controller.view.point_size + steps * STEP
        self._controller.look(point_size=min(max(size, SMALLEST_POINT), LARGEST_POINT))

    def show_panel(self, name: str) -> None:
        """Bring a panel to the front."""
        self._docks.raise_panel(name)

    def is_shown(self, name: str) -> bool:
        """Whether a panel is open, be it behind another."""
        return not self._docks.docks[name].isHidden()

    def set_shown(self, name: str, shown: bool) -> None:
        """Open a panel and bring it to the front, or close it."""
        if shown:
            self._docks.raise_panel(name)
        else:
            self._docks.docks[name].hide()

    def remember_layout(self) -> None:
        """Take the docks as they are for the layout to come back to."""
        self._layout = self._window.saveState()

    def reset_layout(self) -> None:
        """Put every dock back to where it was at the start."""
        self._window.restoreState(self._layout)

    def toggle_full_screen(self) -> None:
        """Fill the screen, or go back."""
        self._window.setWindowState(self._window.windowState() ^ Qt.WindowState.WindowFullScreen)

    def show_guide(self) -> None:
        """Open the user guide."""
        GuideDialog.of_guide(self._window).show()

    def show_shortcuts(self) -> None:
        """List every action with its keys."""
        if self.table is not None:
            title = self.tr("Keyboard and mouse")
            GuideDialog(title, self.table.describe_keys(), self._window).show()

    def show_about(self) -> None:
        """Say what this is."""
        text = self.tr(
            "# Leafscope {0}\n\nLaser scans of leaves: intensity, incidence angle, phase "
            "functions, wrinkle maps and ghost points.\n\nFree software under the BSD licence."
        )
        GuideDialog(self.tr("About Leafscope"), text.format(__version__), self._window).show()
