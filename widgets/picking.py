"""A click in the picture becomes a point: looked for among all points, in the worker."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from app.core.progress import Progress
from app.core.screen import View, pick, project
from widgets.controller import Controller

REACH = 6.0  # pixels around the cursor

Found = tuple[str, int] | None


class Picker(QObject):
    """Finds the point that a click means.

    Signals
    -------
    picked(scan, row)
    """

    picked = Signal(str, int)

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller

    def pick(self, view: View, x: float, y: float, scale: float = 1.0) -> None:
        """Look for the point at a place.

        Parameters
        ----------
        view : View
        x, y : float
            Shares of the viewport, y down.
        scale : float
            Device pixels per pixel of the hand.
        """
        scans = self._controller.project.state.scans
        clouds = [(c.scan, scans[c.scan]) for c in self._controller.scene.clouds]
        place = (x * view.size[0], y * view.size[1])

        def work(progress: Progress) -> Found:
            found: list[tuple[float, str, int]] = []
            for number, (key, state) in enumerate(clouds):
                progress.report(number / len(clouds))
                where = project(state.scan.xyz, view.origin, view.matrix, view.size)
                mask = where.inside & state.alive
                row = pick(where.px, where.depth, mask, place, REACH * scale)
                if row >= 0:
                    found.append((float(where.depth[row]), key, row))
            return min(found)[1:] if found else None

        self._controller.run(self.tr("Picking"), work, self._tell)

    def _tell(self, found: Found) -> None:
        if found is None:
            self._controller.said.emit(self.tr("There is no point here."))
        else:
            self.picked.emit(*found)
