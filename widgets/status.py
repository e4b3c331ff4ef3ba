"""The status bar: the last sentence, how much is selected and shown, and what is running."""

from __future__ import annotations

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar, QToolButton, QWidget

from app.model.scene import Scene
from app.services.jobs import Job
from widgets.common.numbers import show_count
from widgets.controller import Controller
from widgets.icons import draw_icon

PATIENCE_MS = 1000


class Status(QStatusBar):
    """What takes less than a second is not shown: a flash of progress tells nobody anything."""

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._running = False
        self.setSizeGripEnabled(False)
        self.points = QLabel(self)
        self.points.setAccessibleName(self.tr("Points selected and shown"))
        self.job = QLabel(self)
        self.progress = QProgressBar(self)
        self.progress.setAccessibleName(self.tr("Progress"))
        self.cancel = QToolButton(self)
        self.cancel.setText(self.tr("Cancel"))
        self.cancel.setToolTip(self.tr("Stop what is running; nothing is half done"))
        self.cancel.clicked.connect(self._cancel)
        self._patience = QTimer(self, singleShot=True, interval=PATIENCE_MS)
        self._patience.timeout.connect(self._show_job)
        self._lay_out()
        controller.said.connect(self.showMessage)
        controller.scene_changed.connect(self._count)
        controller.bridge.job_changed.connect(self._note_job)
        self._count(controller.scene)
        self._hide_job()

    def recolour(self, dark: bool = False) -> None:
        """Draw the icon in the colours of the theme."""
        self.cancel.setIcon(draw_icon("ph.x-circle"))

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        self.progress.setFixedWidth(9 * em)
        self.setContentsMargins(em // 2, 0, em // 2, 0)
        for widget in (self.job, self.progress, self.cancel, self.points):
            self.addPermanentWidget(widget)
        self.recolour()

    def _count(self, scene: Scene) -> None:
        state = self._controller.scan
        selected = len(state.selection) if state is not None else 0
        parts = []
        if selected:
            parts.append(self.tr("{0} selected").format(show_count(selected)))
        if scene.clouds:
            shown, total = show_count(scene.shown), show_count(scene.total)
            parts.append(self.tr("{0} / {1} points").format(shown, total))
        self.points.setText("   ".join(parts))

    def _note_job(self, job: Job) -> None:
        running = bool(self._controller.bridge.jobs)
        if running and not self._running:
            self._patience.start()
        elif not running:
            self._patience.stop()
            self._hide_job()
        elif self.progress.isVisibleTo(self):
            self._show_job()
        self._running = running

    def _show_job(self) -> None:
        job = self._current()
        if job is None:
            return
        waiting = len(self._controller.bridge.jobs) - 1
        text = f"{job.title}: {job.text}" if job.text and job.text != job.title else job.title
        more = self.tr(" (+{0})").format(waiting) if waiting else ""
        self.job.setText(self._shorten(text) + more)
        self.job.setToolTip(text)
        self.progress.setRange(0, 100 if job.fraction > 0 else 0)
        self.progress.setValue(round(100 * job.fraction))
        for widget in (self.job, self.progress, self.cancel):
            widget.show()

    def _shorten(self, text: str) -> str:
        room = max(self.width() // 3, 12 * self.fontMetrics().height())
        return self.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, room)

    def _hide_job(self) -> None:
        for widget in (self.job, self.progress, self.cancel):
            widget.hide()

    def _current(self) -> Job | None:
        jobs = self._controller.bridge.jobs
        return next((job for job in jobs if job.state == "running"), jobs[0] if jobs else None)

    def _cancel(self) -> None:
        job = self._current()
        if job is not None:
            job.cancel()
            self.job.setText(self.tr("Cancelling…"))
