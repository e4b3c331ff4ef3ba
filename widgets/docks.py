"""The panels around the picture: which there are, where they stand at the start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import QObject, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget, QMainWindow, QScrollArea, QTabWidget, QWidget

from widgets.controller import Controller
from widgets.documents import Documents
from widgets.leaf_work import LeafWork

Area = Literal["top left", "bottom left", "right"]


@dataclass(frozen=True, slots=True)
class Place:
    """A panel: its name, title, and where it is; those of one area are tabs."""

    id: str
    title: str
    area: Area
    tip: str


PLACES = (
    Place("scans", "Scans", "top left", "Open scans, their channels and positions"),
    Place("pick", "Point", "top left", "All values of the point that was picked"),
    Place("history", "History", "top left", "Every step; go back to any of them"),
    Place("leaves", "Leaves", "bottom left", "The leaves and their measures"),
    Place("jobs", "Jobs", "bottom left", "What is running and what was done"),
    Place("phase_lab", "Phase lab", "right", "Fit an angular curve to leaves"),
    Place("wrinkles", "Δω", "right", "Wrinkles: angle from intensity less the leaf's angle"),
    Place("ghosts", "Ghosts", "right", "Find mixed pixels; mark, delete or correct them"),
)
SIDES = {
    "top left": Qt.DockWidgetArea.LeftDockWidgetArea,
    "bottom left": Qt.DockWidgetArea.LeftDockWidgetArea,
    "right": Qt.DockWidgetArea.RightDockWidgetArea,
}


class Docks(QObject):
    """Docks are there at once; the panels in them come after the window is shown."""

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.docks: dict[str, QDockWidget] = {}
        self.panels: dict[str, QWidget] = {}
        window.setDockNestingEnabled(True)
        left = Qt.DockWidgetArea.LeftDockWidgetArea
        right = Qt.DockWidgetArea.RightDockWidgetArea
        for side in (left, right):
            window.setTabPosition(side, QTabWidget.TabPosition.North)
        window.setCorner(Qt.Corner.BottomLeftCorner, left)
        window.setCorner(Qt.Corner.BottomRightCorner, right)
        self._arrange()

    def fill(self, controller: Controller, work: LeafWork, documents: Documents) -> None:
        """Make the panels and put them in."""
        for name, panel in make_panels(controller, work, documents).items():
            scroll = ScrollableTall(panel, self.docks[name])
            self.panels[name] = panel
            self.docks[name].setWidget(scroll)

    def toggles(self) -> list[QAction]:
        """Actions that show and hide the panels."""
        return [dock.toggleViewAction() for dock in self.docks.values()]

    def raise_panel(self, name: str) -> None:
        """Bring a panel to the front."""
        self.docks[name].show()
        self.docks[name].raise_()

    def size_up(self) -> None:
        """Give the sides a share of the window that suits its width."""
        em = self._window.fontMetrics().height()
        share = self._window.width()
        left = min(max(20 * em, share // 5), share // 3)
        right = min(max(24 * em, share // 4), share // 3)
        horizontal = Qt.Orientation.Horizontal
        sides = [self.docks["scans"], self.docks["phase_lab"]]
        self._window.resizeDocks(sides, [left, right], horizontal)
        column = [self.docks["scans"], self.docks["leaves"]]
        self._window.resizeDocks(column, [2, 3], Qt.Orientation.Vertical)

    def _arrange(self) -> None:
        first: dict[str, QDockWidget] = {}
        for place in PLACES:
            dock = self.docks[place.id] = QDockWidget(self.tr(place.title), self._window)
            dock.setObjectName(f"dock-{place.id}")
            dock.toggleViewAction().setToolTip(self.tr(place.tip))
            if place.area in first:
                self._window.tabifyDockWidget(first[place.area], dock)
            elif place.area == "bottom left":
                top = first["top left"]
                self._window.splitDockWidget(top, dock, Qt.Orientation.Vertical)
                first[place.area] = dock
            else:
                self._window.addDockWidget(SIDES[place.area], dock)
                first[place.area] = dock
        for dock in first.values():
            dock.raise_()


class ScrollableTall(QScrollArea):
    """A panel that scrolls up and down on a low screen instead of being squeezed."""

    def __init__(self, panel: QWidget, parent: QWidget) -> None:
        super().__init__(parent)
        self.setFrameShape(QScrollArea.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(panel)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """As wide as the panel needs, however low."""
        em = self.fontMetrics().height()
        bar = self.verticalScrollBar().sizeHint().width()
        return QSize(self.widget().minimumSizeHint().width() + bar, 6 * em)


def make_panels(
    controller: Controller, work: LeafWork, documents: Documents
) -> dict[str, QWidget]:
    """Make every panel; their libraries are loaded here, not when the window opens."""
    from widgets.panels.ghosts import GhostsPanel
    from widgets.panels.history import HistoryPanel
    from widgets.panels.jobs import JobsPanel
    from widgets.panels.leaves import LeavesPanel
    from widgets.panels.phase_lab import PhaseLabPanel
    from widgets.panels.pick import PickPanel
    from widgets.panels.scans import ScansPanel
    from widgets.panels.wrinkles import WrinklesPanel

    return {
        "scans": ScansPanel(controller, work, documents),
        "pick": PickPanel(controller, work, documents),
        "history": HistoryPanel(controller, work, documents),
        "leaves": LeavesPanel(controller, work, documents),
        "jobs": JobsPanel(controller, work, documents),
        "phase_lab": PhaseLabPanel(controller, work, documents),
        "wrinkles": WrinklesPanel(controller, work, documents),
        "ghosts": GhostsPanel(controller, work, documents),
    }
