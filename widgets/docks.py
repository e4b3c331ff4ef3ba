"""The panels around the picture: which there are, where they stand at the start."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabWidget, QWidget

from widgets.common.panel import Panel
from widgets.controller import Controller
from widgets.documents import Documents
from widgets.leaf_work import LeafWork

Area = Literal["top left", "bottom left", "bottom", "right"]
AREAS: tuple[Area, ...] = get_args(Area)

BELOW, LOWEST = 0.36, 13
"""Share of the window's height for what is opened below, where it would have fewer lines."""


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
    Place("series", "Series", "bottom left", "Leaves carried through scans at many angles"),
    Place("scan_image", "Scan image", "bottom", "What the scanner saw, as a picture"),
    Place("phase_lab", "Phase lab", "right", "Fit an angular curve to leaves"),
    Place("correct", "Correct", "right", "Correct channels for the angle of incidence: WF1 to WF3"),
    Place("index", "Index", "right", "An index against the angle and the size of the footprint"),
    Place("wrinkles", "Δω", "right", "Wrinkles: angle from intensity less the leaf's angle"),
    Place("ghosts", "Ghosts", "right", "Find mixed pixels; mark, delete or correct them"),
    Place("angles", "Angles", "right", "How incidence angles are found, and how good they are"),
    Place("calibration", "Calibration", "right", "From raw numbers to reflectance, and how sure"),
    Place("planner", "Planner", "right", "What a scan will show of a leaf, before it is made"),
)


class Docks(QObject):
    """Docks are there at once; the panels in them come after the window is shown."""

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.docks: dict[str, QDockWidget] = {}
        self.panels: dict[str, Panel] = {}
        window.setDockNestingEnabled(True)
        left = Qt.DockWidgetArea.LeftDockWidgetArea
        right = Qt.DockWidgetArea.RightDockWidgetArea
        window.setTabPosition(left, QTabWidget.TabPosition.North)
        # Beside the panels there is room for all of their names.
        window.setTabPosition(right, QTabWidget.TabPosition.East)
        window.setCorner(Qt.Corner.BottomLeftCorner, left)
        window.setCorner(Qt.Corner.BottomRightCorner, right)
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._dress)
        self._room = QTimer(self, singleShot=True, interval=0)
        self._room.timeout.connect(self._give_room)
        self._arranged = False
        for place in PLACES:
            self.docks[place.id] = self._make(place)
        for dock in self._in_area("bottom"):
            dock.visibilityChanged.connect(self._note_bottom)

    def fill(self, controller: Controller, work: LeafWork, documents: Documents) -> None:
        """Make the panels and put them in."""
        for name, panel in make_panels(controller, work, documents).items():
            self.panels[name] = panel
            self.docks[name].setWidget(panel)

    def toggles(self) -> list[QAction]:
        """Actions that show and hide the panels."""
        return [dock.toggleViewAction() for dock in self.docks.values()]

    def raise_panel(self, name: str) -> None:
        """Bring a panel to the front."""
        self.docks[name].show()
        self.docks[name].raise_()

    def arrange(self) -> None:
        """Put the docks in their places, once; only when the window is being shown.

        Before that, Qt forgets to hide the tab bars that it made on the way.
        """
        if self._arranged:
            return
        self._arranged = True
        window, first = self._window, {area: self._in_area(area)[0] for area in AREAS}
        window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, first["top left"])
        window.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, first["right"])
        window.addDockWidget(Qt.DockWidgetArea.BottomDockWidgetArea, first["bottom"])
        # Split before tabs are made: a dock that is a tab already is not split but joined.
        vertical = Qt.Orientation.Vertical
        window.splitDockWidget(first["top left"], first["bottom left"], vertical)
        for area in AREAS:
            for dock, neighbour in pairwise(self._in_area(area)):
                window.tabifyDockWidget(dock, neighbour)
            first[area].raise_()
        first["bottom"].hide()  # the 3-D view has all the room until somebody asks
        self._size_up()

    def _in_area(self, area: Area) -> list[QDockWidget]:
        return [self.docks[place.id] for place in PLACES if place.area == area]

    def _size_up(self) -> None:
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

    def _note_bottom(self, seen: bool) -> None:
        if seen:
            self._room.start()

    def _give_room(self) -> None:
        """Give what is opened below the picture a height at which something can be seen."""
        em = self._window.fontMetrics().height()
        for dock in self._in_area("bottom"):
            if dock.isVisible() and not dock.isFloating() and dock.height() < LOWEST * em:
                height = round(BELOW * self._window.height())
                self._window.resizeDocks([dock], [height], Qt.Orientation.Vertical)

    def _make(self, place: Place) -> QDockWidget:
        dock = QDockWidget(self.tr(place.title), self._window)
        dock.setObjectName(f"dock-{place.id}")
        dock.toggleViewAction().setToolTip(self.tr(place.tip))
        for signal in (dock.visibilityChanged, dock.topLevelChanged, dock.dockLocationChanged):
            signal.connect(self._dress_soon)
        return dock

    def _dress_soon(self, *_: object) -> None:
        self._later.start()

    def _dress(self) -> None:
        """Take the title off docks whose tab says it already."""
        for dock in self.docks.values():
            tab = bool(self._window.tabifiedDockWidgets(dock)) and not dock.isFloating()
            if tab and dock.titleBarWidget() is None:
                dock.setTitleBarWidget(QWidget(dock))
            elif not tab and dock.titleBarWidget() is not None:
                bare = dock.titleBarWidget()
                dock.setTitleBarWidget(None)  # type: ignore[arg-type]
                bare.deleteLater()


def make_panels(controller: Controller, work: LeafWork, documents: Documents) -> dict[str, Panel]:
    """Make every panel; their libraries are loaded here, not when the window opens."""
    from widgets.panels.angles import AnglesPanel
    from widgets.panels.calibration import CalibrationPanel
    from widgets.panels.correct import CorrectPanel
    from widgets.panels.ghosts import GhostsPanel
    from widgets.panels.history import HistoryPanel
    from widgets.panels.index import IndexPanel
    from widgets.panels.jobs import JobsPanel
    from widgets.panels.leaves import LeavesPanel
    from widgets.panels.phase_lab import PhaseLabPanel
    from widgets.panels.pick import PickPanel
    from widgets.panels.planner import PlannerPanel
    from widgets.panels.scan_image import ScanImagePanel
    from widgets.panels.scans import ScansPanel
    from widgets.panels.series import SeriesPanel
    from widgets.panels.wrinkles import WrinklesPanel

    return {
        "scans": ScansPanel(controller, work, documents),
        "pick": PickPanel(controller, work, documents),
        "history": HistoryPanel(controller, work, documents),
        "leaves": LeavesPanel(controller, work, documents),
        "jobs": JobsPanel(controller, work, documents),
        "series": SeriesPanel(controller, work, documents),
        "scan_image": ScanImagePanel(controller, work, documents),
        "phase_lab": PhaseLabPanel(controller, work, documents),
        "wrinkles": WrinklesPanel(controller, work, documents),
        "ghosts": GhostsPanel(controller, work, documents),
        "angles": AnglesPanel(controller, work, documents),
        "correct": CorrectPanel(controller, work, documents),
        "index": IndexPanel(controller, work, documents),
        "calibration": CalibrationPanel(controller, work, documents),
        "planner": PlannerPanel(controller, work, documents),
    }
