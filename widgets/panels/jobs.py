"""Jobs: what is being computed, how far it is, and the button that stops it."""

from __future__ import annotations

import math
import time

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.services.jobs import Job
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling

PATIENCE = 300  # ms; a job that is done by then is never shown
PERMILLE = 1000


class JobRow(QFrame):
    """One job: title, bar, time left, cancel."""

    def __init__(self, job: Job, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.job = job
        self._stopping = False
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.title = QLabel(f"<b>{job.title}</b>", self)
        self.detail = QLabel(self)
        self.bar = QProgressBar(self)
        self.bar.setTextVisible(False)
        self.bar.setAccessibleName(self.tr("Progress of {job}").format(job=job.title))
        self.button = QPushButton(self.tr("Cancel"), self)
        self.button.setAccessibleName(self.tr("Cancel {job}").format(job=job.title))
        self.button.clicked.connect(self.cancel)
        layout = QGridLayout(self)
        layout.addWidget(self.title, 0, 0)
        layout.addWidget(self.button, 0, 1, 3, 1)
        layout.addWidget(self.bar, 1, 0)
        layout.addWidget(self.detail, 2, 0)
        layout.setColumnStretch(0, 1)
        self.show_progress()

    def cancel(self) -> None:
        """Ask the job to stop."""
        self._stopping = True
        self.button.setEnabled(False)
        self.job.cancel()
        self.show_progress()

    def show_progress(self) -> None:
        """Show how far the job is."""
        waiting = self.job.state == "waiting"
        known = waiting or self.job.fraction > 0.0
        self.bar.setRange(0, PERMILLE if known else 0)
        self.bar.setValue(round(self.job.fraction * PERMILLE))
        self.detail.setText(self._describe(waiting))

    def _describe(self, waiting: bool) -> str:
        if self._stopping:
            return self.tr("Stopping…")
        if waiting:
            return self.tr("Waiting for its turn")
        parts = [self.job.text]
        if self.job.fraction > 0.0:
            parts.append(f"{100 * self.job.fraction:.0f} %")
        left = self.job.seconds_left
        if left is not None:
            parts.append(self.tr("about {time} left").format(time=self._write_time(left)))
        return ", ".join(filter(None, parts))

    def _write_time(self, seconds: float) -> str:
        if seconds < 100:
            return self.tr("{n} s").format(n=max(math.ceil(seconds), 1))
        return self.tr("{n} min").format(n=math.ceil(seconds / 60))


class JobsPanel(Panel):
    """All jobs that run or wait."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("jobs")
        self.setWindowTitle(self.tr("Jobs"))
        self.rows: dict[Job, JobRow] = {}
        self._since: dict[Job, float] = {}
        self.notice = Notice(self)
        content = QWidget(self)
        self._list = QVBoxLayout(content)
        self._list.addWidget(self.notice)
        self._list.addStretch(1)
        make_scrolling(content, self)
        self._clock = QTimer(self, interval=PATIENCE)
        self._clock.timeout.connect(self.refresh)
        self.controller.bridge.job_changed.connect(self._on_job)

    def refresh(self) -> None:
        """Show the jobs that have been there for a moment, drop those that ended."""
        jobs = self.controller.bridge.jobs
        for job in [job for job in self.rows if job not in jobs or job.over]:
            row = self.rows.pop(job)
            self._list.removeWidget(row)
            row.deleteLater()
        self._since = {job: self._since.get(job, time.monotonic()) for job in jobs}
        for job, since in self._since.items():
            if job not in self.rows and time.monotonic() - since >= PATIENCE / 1000:
                self._add(job)
        for row in self.rows.values():
            row.show_progress()
        if not jobs:
            self._clock.stop()
        self.notice.say("" if self.rows else self.tr("Nothing is being computed."))

    def _add(self, job: Job) -> None:
        row = JobRow(job, self)
        self.rows[job] = row
        self._list.insertWidget(self._list.count() - 1, row)

    def _on_job(self, job: Job) -> None:
        if job.over:
            if job in self.rows:
                self.refresh()
            return
        self._since.setdefault(job, time.monotonic())
        if not self._clock.isActive():
            self._clock.start()
