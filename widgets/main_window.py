"""The window: puts the parts together. Shown first; what is slow to load comes right after."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent, QShowEvent, Qt
from PySide6.QtOpenGLWidgets import QOpenGLWidget
from PySide6.QtWidgets import QMainWindow, QStackedWidget, QVBoxLayout, QWidget

from app.core.errors import LeafscopeError, MissingChannel, MissingScanner, UnclearLayout
from app.model.events import Change
from app.model.scan import Pose
from app.model.scene import Scene
from widgets.action_rows import list_rows
from widgets.actions import ActionTable
from widgets.colour_by import ColourBy
from widgets.controller import Controller
from widgets.desk import Desk
from widgets.dialogs.error import ErrorDialog
from widgets.docks import Docks
from widgets.documents import Documents
from widgets.faults import Faults, Trouble
from widgets.file_deeds import FileDeeds, holds_work
from widgets.footprint_overlay import FootprintOverlay
from widgets.leaf_work import LeafWork
from widgets.menus import add_panels, build_menus
from widgets.mesh_overlay import MeshOverlay
from widgets.notices import Answer, Kind, NoticeArea
from widgets.picture import Picture
from widgets.scan_deeds import ScanDeeds
from widgets.series_deeds import SeriesDeeds
from widgets.split_sight import SplitSight
from widgets.status import Status
from widgets.theme import ThemeSwitch
from widgets.toolbar import MainBar
from widgets.tools import Tools
from widgets.view_deeds import ViewDeeds
from widgets.welcome import Welcome

if TYPE_CHECKING:
    from widgets.panels.leaves import LeavesPanel
    from widgets.viewport.view3d import View3D

SIZE = (112, 66)  # in heights of a line of text


class MainWindow(QMainWindow):
    """Menus, tool bar, picture, panels, notices and status bar around one controller."""

    def __init__(self, theme: ThemeSwitch, faults: Faults | None = None) -> None:
        super().__init__()
        self.theme = theme
        self.controller = Controller(self)
        self.documents = Documents(self.controller)
        self.work = LeafWork(self.controller)
        self.tools = Tools(self)
        self.notices = NoticeArea(self)
        self.stack = QStackedWidget(self)
        self.picture = Picture(self.controller, self.work, self.tools, theme, self)
        self.docks = Docks(self)
        self.desk = self._make_desk()
        self.table = ActionTable(list_rows(), self.desk, self)
        self.desk.views.table = self.table
        self.status = Status(self.controller, self)
        self._agreed_to_close = self._away = False
        self._build()
        self._connect()
        if faults is not None:
            faults.raised.connect(self.tell)
        self._tell_title()
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self.complete)
        self._later.start()

    # Putting together

    def _make_desk(self) -> Desk:
        controller, documents = self.controller, self.documents
        files = FileDeeds(self, controller, documents, self.picture)
        return Desk(
            controller,
            self.tools,
            files,
            ScanDeeds(self, controller, documents, self.work, self.tools),
            self.picture,
            ViewDeeds(self, controller, self.theme, self.docks),
            SeriesDeeds(self, controller, files.dialogs),
        )

    def _build(self) -> None:
        self.setObjectName("window")
        self.setAcceptDrops(True)
        self.welcome = Welcome(
            self.table.actions["file.open"], self.table.actions["file.demo"], self.stack
        )
        self.stack.addWidget(self.welcome)
        # The first OpenGL widget makes Qt replace the native window: better before it is shown.
        spare = QOpenGLWidget(self.welcome)
        spare.setGeometry(-2, -2, 1, 1)
        middle = QWidget(self)
        column = QVBoxLayout(middle)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.notices)
        column.addWidget(self.stack, 1)
        self.setCentralWidget(middle)
        menus = build_menus(self.menuBar(), self.table)
        add_panels(menus["view"], self.docks.toggles())
        self.colour_by = ColourBy(self.controller, self)
        self.bar = MainBar(self.table, self.colour_by, self)
        self.addToolBar(self.bar)
        self.setStatusBar(self.status)
        self._size()

    def _size(self) -> None:
        em = self.fontMetrics().height()
        room = self.screen().availableGeometry()
        self.resize(min(SIZE[0] * em, room.width()), min(SIZE[1] * em, room.height()))

    def _connect(self) -> None:
        controller, table = self.controller, self.table
        controller.failed.connect(self.tell)
        controller.document_changed.connect(self._follow_document)
        controller.view_changed.connect(table.refresh)
        controller.view_changed.connect(self._tell_title)
        controller.scene_changed.connect(self._follow_scene)
        self.tools.changed.connect(table.refresh)
        self.documents.pose_proposed.connect(self._propose_pose)
        self.documents.path_changed.connect(self._tell_title)
        self.theme.changed.connect(table.recolour)
        self.theme.changed.connect(table.refresh)
        self.theme.changed.connect(self.notices.recolour)
        self.theme.changed.connect(self.status.recolour)

    def complete(self) -> None:
        """Load what is slow: the 3-D view and the panels."""
        if self.picture.view is not None:
            return
        from widgets.viewport.view3d import View3D

        view = View3D(self.stack)
        self.stack.addWidget(view)
        self.picture.attach(view)
        self.footprints = FootprintOverlay(self.controller, self.picture, self)
        view.camera_moved.connect(self._follow_camera)
        self.docks.fill(self.controller, self.work, self.documents)
        self._connect_panels()
        leaves: LeavesPanel = self.docks.panels["leaves"]  # type: ignore[assignment]
        self.mesh = MeshOverlay(self.controller, self.picture, leaves.areas, self)
        SplitSight(self.controller, self.picture, self.tools, leaves.split, self)
        self.desk.scans.serve(leaves)
        self._watch_ghosts(view)
        self.picture.picker.picked.connect(partial(self.docks.raise_panel, "pick"))
        self.picture.picker.described.connect(self._show_point)
        self.desk.views.remember_layout()
        self._follow_scene(self.controller.scene)

    def _connect_panels(self) -> None:
        panels = self.docks.panels
        for panel in panels.values():
            panel.origin_asked.connect(self._ask_origin)
        panels["scans"].channel_asked.connect(self._ask_channel)  # type: ignore[attr-defined]
        calibration = panels["calibration"]
        calibration.dialogs = self.desk.files.dialogs  # type: ignore[attr-defined]
        panels["phase_lab"].dialogs = self.desk.files.dialogs  # type: ignore[attr-defined]
        self.picture.picker.found.connect(calibration.show_point)  # type: ignore[attr-defined]
        planner = panels["planner"]
        planner.dialogs = self.desk.files.dialogs  # type: ignore[attr-defined]
        self.picture.picker.found.connect(planner.take_point)  # type: ignore[attr-defined]
        series = panels["series"]
        self.desk.series.serve(series, self.docks)  # type: ignore[arg-type]
        series.pick_asked.connect(partial(self.tools.arm, "pick"))  # type: ignore[attr-defined]
        self.picture.picker.found.connect(series.take_point)  # type: ignore[attr-defined]
        image = panels["scan_image"]
        image.use_tools(self.tools)  # type: ignore[attr-defined]
        image.point_picked.connect(self.picture.picker.take)  # type: ignore[attr-defined]
        self.picture.picker.found.connect(image.show_point)  # type: ignore[attr-defined]
        toggle = self.table.actions["view.scan_image"]
        self.docks.docks["scan_image"].visibilityChanged.connect(toggle.refresh)
        chosen = panels["leaves"].chosen  # type: ignore[attr-defined]
        chosen.connect(panels["phase_lab"].choose_leaves)  # type: ignore[attr-defined]
        for name in ("correct", "index"):
            chosen.connect(panels[name].choose_leaves)  # type: ignore[attr-defined]
            panels[name].dialogs = self.desk.files.dialogs  # type: ignore[attr-defined]
        own_asked = panels["index"].own_asked  # type: ignore[attr-defined]
        own_asked.connect(self.desk.scans.write_indices)

    def _watch_ghosts(self, view: View3D) -> None:
        from widgets.ghost_sight import GhostSight

        panel = self.docks.panels["ghosts"]
        self.ghosts = GhostSight(self.controller, self.picture, panel, view, self)  # type: ignore[arg-type]
        self.ghosts.explained.connect(self.docks.panels["pick"].explain)  # type: ignore[attr-defined]

    def put_away(self) -> None:
        """Close the picture and end the worker, in this order; a second time does nothing."""
        if self._away:
            return
        self._away = True
        self._later.stop()
        if self.picture.view is not None:
            self.footprints.stop()
            self.mesh.stop()
            self.ghosts.stop()
        self.picture.detach()
        self.controller.close()

    # News

    def tell(self, error: BaseException) -> None:
        """Show an error as a notice, with what can be done about it."""
        trouble = Trouble.of(error)
        hint, topic = trouble.hint, ""
        answers: list[Answer] = []
        if isinstance(error, MissingScanner):
            hint, topic = "", "scanner"
            answers.append((self.tr("Set scanner position…"), self._ask_origin))
        elif isinstance(error, MissingChannel):
            hint, topic = "", "channel"
            answers.append((self.tr("Name a channel…"), self.desk.scans.name_channel))
        elif isinstance(error, UnclearLayout):
            hint, ask = "", self.desk.scans.name_columns_of
            answers.append((self.tr("Name the columns…"), partial(ask, Path(error.path))))
        if not isinstance(error, LeafscopeError) or error.__cause__ is not None:
            answers.append((self.tr("Details…"), partial(self._show_details, trouble)))
        kind: Kind = "warning" if isinstance(error, LeafscopeError) else "error"
        self.notices.show_notice(kind, trouble.what, hint, answers, topic)

    def _show_details(self, trouble: Trouble) -> None:
        ErrorDialog(trouble, self).show()

    def _propose_pose(self, scan: str, pose: Pose | None) -> None:
        name = self.controller.project.state.scan(scan).scan.name
        if pose is None:
            text = self.tr("{0} does not say where the scanner stood.").format(name)
            hint = self.tr("Range, incidence angle and ghosts need to know it.")
            answer: Answer = (self.tr("Set position…"), partial(self._ask_origin, scan))
            self.notices.show_notice("info", text, hint, [answer], "scanner")
            return
        place = ", ".join(f"{value:g}" for value in pose.position)
        text = self.tr("{0} does not say where the scanner stood. Its grid speaks for {1}.").format(
            name, place
        )

        def accept() -> None:
            self.documents.accept_pose(scan, pose)

        answers: list[Answer] = [
            (self.tr("Accept {0}").format(place), accept),
            (self.tr("Other…"), self._ask_origin),
        ]
        self.notices.show_notice("info", text, "", answers, "scanner")

    def _ask_origin(self, scan: str = "") -> None:
        if scan and scan != self.controller.current:
            self.controller.look(current=scan)
        self.desk.scans.set_origin()

    def _ask_channel(self, scan: str, channel: str) -> None:
        if scan != self.controller.current:
            self.controller.look(current=scan)
        self.desk.scans.name_channel(channel)

    def _show_point(self, values: object) -> None:
        self.docks.panels["pick"].set_values(values)  # type: ignore[attr-defined]

    # What the window follows

    def _follow_document(self, change: Change) -> None:
        if "pose" in change.aspects:
            self.notices.dismiss("scanner")
        if "channels" in change.aspects:
            self.notices.dismiss("channel")
        if change.aspects != {"fields"}:
            self.table.refresh()
            self._tell_title()

    def _follow_scene(self, scene: Scene) -> None:
        view = self.picture.view
        picture = view is not None and bool(self.controller.project.state.scans)
        self.stack.setCurrentWidget(view if view is not None and picture else self.welcome)

    def _follow_camera(self) -> None:
        self.table.actions["view.ortho"].refresh()

    def _tell_title(self, *_: object) -> None:
        scan, path = self.controller.scan, self.documents.path
        name = path.name if path is not None else scan.scan.name if scan is not None else ""
        self.setWindowTitle(f"{name}[*] – Leafscope" if name else "Leafscope[*]")
        self.setWindowModified(holds_work(self.controller.project))

    # Qt

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        """Arrange the docks the first time."""
        super().showEvent(event)
        self.docks.arrange()

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        """Ask about unsaved work, then put everything away."""
        if not self._agreed_to_close and holds_work(self.controller.project):
            event.ignore()
            self.desk.files.when_safe(self._close_now)
            return
        self.put_away()
        super().closeEvent(event)

    def _close_now(self) -> None:
        self._agreed_to_close = True
        self.close()

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Escape puts the tool away, wherever the keyboard is."""
        if event.key() == Qt.Key.Key_Escape:
            self.tools.arm("navigate")
        else:
            super().keyPressEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        """Welcome files."""
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        """Open what was dropped."""
        paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
        if paths:
            event.acceptProposedAction()
            self.desk.files.open_paths(paths)
