"""Scan images as they are made in the background, and kept for each scan."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from app.core.progress import Progress
from app.model.fields import Same
from app.model.state import ScanState
from app.render.scan_image.image import ScanImage, make_image
from app.render.scan_image.layout import Layout, lay_out
from app.services.jobs import Job
from widgets.controller import Controller

Mark = tuple[object, ...]


@dataclass(frozen=True, slots=True)
class _Held:
    place: Mark
    deleted: Same
    image: ScanImage


class Rasters(QObject):
    """The scan image of each scan: laid out once, and again when points or scanner move.

    Signals
    -------
    made()
        There is a new one; or it failed, which was told.
    """

    made = Signal()

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller
        self._held: dict[str, _Held] = {}
        self._asked: dict[str, tuple[Mark, Same, Job]] = {}
        controller.bridge.job_changed.connect(self._note_job)

    def find(self, scan: str, state: ScanState) -> ScanImage | None:
        """The image of a scan, the one before while only deleted points differ.

        What is not there yet is asked for; what was cancelled is so only after `forget`.
        """
        held, place, deleted = self._held.get(scan), _mark(state), Same(state.deleted)
        if held is not None and held.place != place:
            held = None
        if held is not None and held.deleted == deleted:
            return held.image
        asked = self._asked.get(scan)
        if asked is None or asked[:2] != (place, deleted):
            self._ask(scan, state, None if held is None else held.image.layout)
        return None if held is None else held.image

    def stopped(self, scan: str) -> bool:
        """Whether the image was asked for and did not come."""
        asked = self._asked.get(scan)
        return asked is not None and asked[2].state in ("failed", "cancelled")

    def forget(self, scan: str | None = None) -> None:
        """Drop the image of a scan, or all: they are asked for again when somebody looks."""
        if scan is None:
            self._held.clear()
            self._asked.clear()
        else:
            self._held.pop(scan, None)
            self._asked.pop(scan, None)

    def keep_only(self, scans: set[str]) -> None:
        """Drop the images of scans that are no longer on the table."""
        for gone in (self._held.keys() | self._asked.keys()) - scans:
            self.forget(gone)

    def _ask(self, scan: str, state: ScanState, layout: Layout | None) -> None:
        place, deleted = _mark(state), Same(state.deleted)

        def work(progress: Progress) -> ScanImage:
            return make_image(layout or lay_out(state.scan, progress), state.alive)

        def done(image: ScanImage) -> None:
            asked = self._asked.get(scan)
            if asked is not None and asked[:2] == (place, deleted):
                del self._asked[scan]
                self._held[scan] = _Held(place, deleted, image)
                self.made.emit()

        job = self._controller.run(self.tr("Laying out the scan image"), work, done)
        self._asked[scan] = place, deleted, job

    def _note_job(self, job: Job) -> None:
        if any(job is asked[2] for asked in self._asked.values()) and job.over:
            self.made.emit()


def _mark(state: ScanState) -> Mark:
    scan = state.scan
    return Same(scan.xyz), scan.pose, Same(scan.grid)
