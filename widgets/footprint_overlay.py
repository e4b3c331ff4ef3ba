"""Footprints in the 3-D view: worked out in the worker whenever what they rest on changes."""

from __future__ import annotations

from collections.abc import Hashable

from PySide6.QtCore import QObject, QTimer

from app.core.arrays import Floats
from app.core.errors import BadInput, MissingScanner
from app.model.fields import Same
from app.model.state import ScanState
from app.services.footprint_rings import choose_rows, find_beam, make_rings
from widgets.common.numbers import show_count
from widgets.controller import Controller
from widgets.picture import Picture


class FootprintOverlay(QObject):
    """Follows selection, leaf, beam and the wish of the view; keeps the rings of the last one."""

    def __init__(self, controller: Controller, picture: Picture, parent: QObject) -> None:
        super().__init__(parent)
        self._controller, self._picture = controller, picture
        self._of: Hashable = None
        self.rings: Floats | None = None
        # Many changes of one turn are one change.
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._follow)
        controller.document_changed.connect(self._later_follow)
        controller.view_changed.connect(self._later_follow)

    def stop(self) -> None:
        """Look no more; the window calls it before the picture goes."""
        self._later.stop()
        self._controller.document_changed.disconnect(self._later_follow)
        self._controller.view_changed.disconnect(self._later_follow)

    def _later_follow(self, *_: object) -> None:
        self._later.start()

    def _follow(self) -> None:
        state, wanted = self._controller.scan, self._mark()
        if wanted == self._of:
            return
        self._of = wanted
        if wanted is None or state is None:
            self._show(None)
            return
        view, scan = self._controller.view, self._controller.current or ""
        project = self._controller.project
        rows, every = choose_rows(project, scan, view.leaf, view.footprint_step)
        if not len(rows):
            self._show(None)
            self._controller.said.emit(
                self.tr("Select points, or choose a leaf, to see the beam's footprints there.")
            )
            return
        try:
            find_beam(state)
            state.scan.scanner("the footprint")
        except MissingScanner as error:
            self._fail(error)
            return
        except BadInput as error:
            hint = self.tr("Choose it in Scan ▸ Incidence angles, or in the Planner.")
            self._fail(BadInput(error.what, hint))
            return

        def done(rings: Floats) -> None:
            if wanted == self._of:
                self._show(rings)
                self._tell(len(rings), 1 if len(state.selection) else every)

        title = self.tr("Footprints")
        self._controller.run(title, lambda progress: make_rings(state, rows, progress), done)

    def _fail(self, error: BadInput) -> None:
        self._show(None)
        self._controller.failed.emit(error)

    def _mark(self) -> Hashable:
        """All that the rings rest on; None where none are wanted."""
        view, state = self._controller.view, self._controller.scan
        scan = self._controller.current
        if not view.show_footprints or state is None or scan is None or scan in view.hidden:
            return None
        leaf = self._controller.project.state.leaves.get(view.leaf or "")
        members = None if leaf is None or len(state.selection) else Same(leaf.members)
        return (scan, *self._facts_of(state), members, view.footprint_step)

    @staticmethod
    def _facts_of(state: ScanState) -> tuple[Hashable, ...]:
        p = state.parameters
        known = (Same(state.scan), Same(state.deleted), Same(state.selection))
        return (*known, p.beam, p.radius, p.estimator)

    def _show(self, rings: Floats | None) -> None:
        self.rings = rings
        if self._picture.view is not None:
            self._picture.view.drawings.show_rings(rings)

    def _tell(self, count: int, every: int) -> None:
        self._controller.said.emit(
            self.tr("{0} footprints at true scale, at every selected point.").format(
                show_count(count)
            )
            if every == 1
            else self.tr("{0} footprints at true scale, in every {1}th row and column.").format(
                show_count(count), every
            )
        )
