"""Between the panel of ghosts and the picture: where to look, what is hovered, how it would be."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QPoint, QTimer, Signal
from PySide6.QtWidgets import QToolTip

from app.core.progress import Progress
from app.core.screen import pick, project
from app.model.events import Change
from app.model.fields import Same
from app.model.project import Project
from app.render.camera import Camera, centre_on
from app.services.cleanup.answers import Answer
from app.services.cleanup.apply import make_step
from app.services.cleanup.explain import Explainer
from app.services.jobs import Job
from widgets.common.aside import copy_aside
from widgets.common.ghosts.sight import (
    choose_view,
    corners_around,
    is_turned,
    mark_ghost,
    mark_moves,
    reach_around,
)
from widgets.controller import Controller
from widgets.panels.ghosts import GhostsPanel
from widgets.picture import Picture

if TYPE_CHECKING:
    from widgets.viewport.view3d import View3D

REST_MS = 150
REACH = 6.0  # pixels around the cursor


class GhostSight(QObject):
    """Moves the camera to ghosts, says why what is hovered is one, and shows the after.

    Signals
    -------
    explained(str)
        Why the point that was picked is a ghost, or none; empty where that is not known.
    """

    explained = Signal(str)

    def __init__(
        self, controller: Controller, picture: Picture, panel: GhostsPanel, view: View3D,
        parent: QObject,
    ) -> None:  # fmt: skip
        super().__init__(parent)
        self._controller, self._picture, self._panel = controller, picture, panel
        self._explainer: tuple[object, Explainer] | None = None
        self._place: tuple[float, float] | None = None
        self._job: Job | None = None
        self._given: Camera | None = None
        self._shown = False
        self._rest = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest.timeout.connect(self._hover)
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._mark)
        session = panel.page.session
        session.moved.connect(self._go)
        session.changed.connect(self._begin)
        panel.session_shown.connect(self._begin)
        panel.page.after_toggled.connect(self._show_after)
        panel.page.keys.serve(view)
        view.hovered.connect(self._note_hover)
        picture.picker.found.connect(self._explain_picked)
        self.explained.connect(panel.explain)
        controller.document_changed.connect(self._on_document)

    def stop(self) -> None:
        """Look no more; the window calls it before the picture goes."""
        self._rest.stop()
        self._later.stop()
        self._controller.document_changed.disconnect(self._on_document)

    # Where to look

    def _go(self) -> None:
        """Look at the ghost from where nothing hides it; who turned the picture keeps his view."""
        view, session = self._picture.view, self._panel.page.session
        found, state = session.ghost_and_scanner(), self._controller.scan
        if view is None or found is None or state is None:
            return
        point, scanner, shift = found
        camera, ghost, given = view.camera(), session.ghost, self._given
        if given is not None and is_turned(camera, given):
            view.set_camera(centre_on(camera, point))
            self._mark()
            return
        reach = reach_around(point, scanner, shift)

        def work(_: Progress) -> Camera:
            return choose_view(camera, state.scan.xyz, state.alive, point, scanner, reach)

        def done(chosen: Camera) -> None:
            if view is self._picture.view and session.ghost == ghost:
                view.set_camera(chosen)
                view.fit(corners_around(point, reach))
                self._given = view.camera()
                self._mark()

        self._controller.run(self.tr("Looking at a ghost"), work, done)

    def _begin(self, *_: object) -> None:
        """The page of the queue came or went, or another queue: look across the beams again."""
        self._given = None
        self._later.start()

    def _mark(self) -> None:
        """Point out the ghost that is looked at, or take the lines away."""
        view = self._picture.view
        if view is None:
            return
        found = self._panel.page.session.ghost_and_scanner() if self._panel.in_session else None
        if found is not None:
            point, scanner, shift = found
            lines = mark_ghost(point, scanner, reach_around(point, scanner, shift), shift)
            view.drawings.show_marks(lines)
            self._shown = True
        elif self._shown:
            view.drawings.show_marks(None)
            self._shown = False

    # Before and after

    def _show_after(self, on: bool) -> None:
        page = self._panel.page
        plan = page.session.plan
        if not on or plan is None:
            self._picture.show_instead(None)
            self._mark()
            return
        answers = page.session.answers(page.proposals.isChecked())
        document, colour = self._controller.project, self._controller.view.colour
        aside = copy_aside(document, plan.scan)
        known = colour in document.catalogue(plan.scan) and document.known_field(plan.scan, colour)

        def work(progress: Progress) -> Project:
            aside.do(make_step(aside.state, plan, answers))
            if known:
                aside.field(plan.scan, colour, None, progress)
            return aside

        def done(after: Project) -> None:
            view = self._picture.view
            if not page.after_button.isChecked() or page.session.plan is not plan or view is None:
                return
            self._picture.show_instead(after)
            rows = plan.ghosts[answers == Answer.CORRECT]
            if len(rows):
                places = (state.scan(plan.scan).scan.xyz[rows]
                          for state in (document.state, after.state))  # fmt: skip
                view.drawings.show_marks(mark_moves(*places))
                self._shown = True

        self._controller.run(self.tr("Showing the scan cleaned"), work, done)

    def _on_document(self, change: Change) -> None:
        if not change.aspects <= {"fields", "selection"}:
            self._panel.page.after_button.setChecked(False)

    # What is hovered or picked

    def _note_hover(self, x: float, y: float) -> None:
        self._place = (x, y)
        if self._panel.isVisible() and self._panel.known_score is not None:
            self._rest.start()

    def _hover(self) -> None:
        view, scan, place = self._picture.view, self._controller.current, self._place
        explainer = self._prepare()
        if view is None or scan is None or place is None or explainer is None:
            return
        if self._job in self._controller.bridge.jobs:
            self._rest.start()  # one at a time
            return
        seen, state = view.current_view(), self._controller.project.state.scan(scan)
        spot = (place[0] * seen.size[0], place[1] * seen.size[1])
        reach = REACH * view.devicePixelRatioF()

        def work(progress: Progress) -> str:
            where = project(state.scan.xyz, seen.origin, seen.matrix, seen.size)
            row = pick(where.px, where.depth, where.inside & state.alive, spot, reach)
            return explainer.explain(row, progress).sentence if row >= 0 else ""

        def done(sentence: str) -> None:
            if place == self._place and view is self._picture.view and view.underMouse():
                at = QPoint(round(place[0] * view.width()), round(place[1] * view.height()))
                QToolTip.showText(view.mapToGlobal(at), sentence, view)

        self._job = self._controller.run(self.tr("Explaining a point"), work, done)

    def _explain_picked(self, scan: str, row: int) -> None:
        explainer = self._prepare()
        self.explained.emit("")
        if explainer is None or scan != self._controller.current:
            return

        def work(progress: Progress) -> str:
            return explainer.explain(row, progress).sentence

        def done(sentence: str) -> None:
            if self._picture.picker.point == (scan, row):
                self.explained.emit(sentence)

        self._controller.run(self.tr("Explaining a point"), work, done)

    def _prepare(self) -> Explainer | None:
        """What explains points of the current scan as it is now; None without a score."""
        known, state, scan = (self._panel.known_score, self._controller.scan,
                              self._controller.current)  # fmt: skip
        if known is None or state is None or scan is None:
            self._explainer = None
            return None
        leaves = self._controller.project.state.leaves_of(scan)
        mark = (Same(known), Same(state), tuple(Same(leaf) for leaf in leaves))
        if self._explainer is None or self._explainer[0] != mark:
            self._explainer = (mark, Explainer(state, leaves, known.values))
        return self._explainer[1]
