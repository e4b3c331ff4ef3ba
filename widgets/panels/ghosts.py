"""Ghosts: points between two surfaces, found by score, then marked, deleted or corrected."""

from __future__ import annotations

from collections.abc import Hashable
from uuid import uuid4

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from app.model.fields import Same, Values
from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.model.selection import FieldRange
from widgets.common.ghost_counts import GhostCounts, count_ghosts
from widgets.common.notice import Notice
from widgets.common.numbers import NumberField, show_count, show_number
from widgets.common.panel import Panel, make_scrolling
from widgets.common.score_plot import ScorePlot

SCORE, GHOST = "ghost_score", "ghost"
STEPS = 100
FEW_POINTS = 200_000


class GhostsPanel(Panel):
    """Score, threshold and what to do with the ghosts."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("ghosts")
        self.setWindowTitle(self.tr("Ghosts"))
        self.counts: GhostCounts | None = None
        self._counts_for: Hashable = None
        self._drag = uuid4().hex
        self._colour_before = ""
        self.notice = Notice(self)
        self.plot = ScorePlot(self)
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.field = NumberField(0.0, 1.0, 2, "", self)
        self.summary = QLabel(self)
        self.preview = QCheckBox(self.tr("Colour the cloud by &ghost"), self)
        self.mark_button = QPushButton(self.tr("&Mark"), self)
        self.delete_button = QPushButton(self.tr("&Delete"), self)
        self.correct_button = QPushButton(self.tr("&Correct"), self)
        self.unmark_button = QPushButton(self.tr("&Unmark"), self)
        self._arrange()
        self._explain()
        self._connect()

    def _arrange(self) -> None:
        self.slider.setRange(0, STEPS)
        self.slider.setPageStep(STEPS // 20)
        self.field.setSingleStep(0.05)
        self.summary.setWordWrap(True)
        label = QLabel(self.tr("&Threshold"), self)
        label.setBuddy(self.field)
        row = QHBoxLayout()
        row.addWidget(label)
        row.addWidget(self.slider, 1)
        row.addWidget(self.field)
        buttons = QGridLayout()
        for place, button in enumerate(self._buttons):
            buttons.addWidget(button, place // 2, place % 2)
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addWidget(self.plot, 1)
        inner.addLayout(row)
        inner.addWidget(self.summary)
        inner.addWidget(self.preview)
        inner.addLayout(buttons)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.notice)
        layout.addWidget(self.body, 1)
        layout.addStretch(0)
        make_scrolling(content, self)

    def _explain(self) -> None:
        for widget in (self.slider, self.field):
            widget.setAccessibleName(self.tr("Ghost threshold, 0 to 1"))
            widget.setToolTip(self.tr("Points with this score or more count as ghosts (0–1)"))
        for button, tip in zip(
            self._buttons,
            (
                self.tr("Mark what the threshold calls ghosts; nothing is removed"),
                self.tr("Delete the ghosts; undo brings them back"),
                self.tr("Put ghosts back on the surface that fills most of their beam"),
                self.tr("Forget all marks of this scan: the score decides again"),
            ),
            strict=True,
        ):
            button.setToolTip(tip)

    @property
    def _buttons(self) -> tuple[QPushButton, ...]:
        return self.mark_button, self.delete_button, self.correct_button, self.unmark_button

    def _connect(self) -> None:
        self.notice.clicked.connect(self._on_notice)
        self.slider.sliderPressed.connect(self._on_grabbed)
        self.slider.valueChanged.connect(self._on_slider)
        self.slider.sliderReleased.connect(self._commit)
        self.field.valueChanged.connect(self._on_field)
        self.plot.moved.connect(self.show_threshold)
        self.plot.released.connect(self._on_line)
        self.preview.clicked.connect(self._on_preview)
        self.mark_button.clicked.connect(self.work.mark_ghosts)
        self.delete_button.clicked.connect(self.work.delete_ghosts)
        self.correct_button.clicked.connect(self.work.correct_ghosts)
        self.unmark_button.clicked.connect(self.unmark)

    @property
    def threshold(self) -> float:
        """The threshold that is shown."""
        return self.field.value()

    def refresh(self) -> None:
        """Show score and threshold of the current scan, or what is missing."""
        state, known = self.controller.scan, self._known_score()
        missing, action = self._find_missing(known)
        self.notice.say(missing, action)
        self.body.setVisible(known is not None)
        self.preview.setChecked(self.controller.view.colour == GHOST)
        if state is None or known is None:
            self.counts, self._counts_for = None, None
            return
        if not self.slider.isSliderDown():
            self.show_threshold(state.parameters.ghost_threshold)
        mark = (Same(known), Same(state.marks), Same(state.deleted))
        if mark != self._counts_for:
            self._counts_for = mark
            self._count(known, mark)
        else:
            self._tell()

    def restyle(self) -> None:
        """Draw in the new colours."""
        self.plot.restyle()

    def show_threshold(self, threshold: float) -> None:
        """Show what a threshold would do; the document is not touched."""
        with QSignalBlocker(self.slider), QSignalBlocker(self.field):
            self.slider.setValue(round(threshold * STEPS))
            self.field.setValue(threshold)
        self.plot.show_threshold(self.threshold)
        self._tell()

    def _known_score(self) -> Values | None:
        scan = self.controller.current
        if scan is None:
            return None
        known = self.controller.project.known_field(scan, SCORE)
        return known if known is not None and known.complete else None

    def _find_missing(self, known: Values | None) -> tuple[str, str]:
        state = self.controller.scan
        if state is None:
            return self.tr("Open a scan to look for ghost points in it."), ""
        if state.scan.pose is None:
            return self.tr(
                "Nobody knows where the scanner stood. Ghosts lie along its beams, so the "
                "score needs its position."
            ), self.tr("Set position…")
        if known is None:
            return self.tr(
                "Where a beam met two surfaces, the scanner reports a ghost in between. "
                "The score tells how much each point looks like one."
            ), self.tr("Compute score")
        return "", ""

    def _count(self, known: Values, mark: Hashable) -> None:
        state = self.controller.scan
        if state is None:
            return
        score, marks, alive = known.values, state.marks, state.alive

        def done(found: GhostCounts) -> None:
            if mark == self._counts_for:
                self.counts = found
                self.plot.show_counts(found.histogram, self.threshold)
                self._tell()

        if len(score) <= FEW_POINTS:
            done(count_ghosts(score, marks, alive))
        else:
            title = self.tr("Counting ghosts")
            self.controller.run(title, lambda _: count_ghosts(score, marks, alive), done)

    def _tell(self) -> None:
        counts = self.counts
        if counts is None:
            self.summary.clear()
            return
        ghosts = counts.count(self.threshold)
        share = 100.0 * ghosts / counts.total if counts.total else 0.0
        text = self.tr("<b>{n} ghosts</b>, {share} % of {total} points").format(
            n=show_count(ghosts), share=show_number(share, 2), total=show_count(counts.total)
        )
        if counts.marked or counts.kept:
            text += "<br>" + self.tr("Judged by hand: {n} ghosts, {m} kept").format(
                n=show_count(counts.marked), m=show_count(counts.kept)
            )
        self.summary.setText(text)
        for button in (self.mark_button, self.delete_button, self.correct_button):
            button.setEnabled(ghosts > 0)
        self.unmark_button.setEnabled(counts.marked + counts.kept > 0)

    def unmark(self) -> None:
        """Forget all marks of the scan."""
        scan, state = self.controller.current, self.controller.scan
        if scan is not None and state is not None:
            judged = PointSet.from_mask(state.marks != 0)
            self.controller.do(MarkGhosts(scan, cleared=judged, basis=FieldRange(GHOST, 0.0, 1.0)))

    def _commit(self) -> None:
        state = self.controller.scan
        if state is not None and self.threshold != state.parameters.ghost_threshold:
            self.work.set_parameters(
                drag=f"ghost threshold {self._drag}", ghost_threshold=self.threshold
            )

    def _on_grabbed(self) -> None:
        self._drag = uuid4().hex

    def _on_slider(self, position: int) -> None:
        self.show_threshold(position / STEPS)
        if not self.slider.isSliderDown():
            self._commit()  # moved by the keyboard or the wheel

    def _on_field(self, value: float) -> None:
        self._drag = uuid4().hex
        self.show_threshold(value)
        self._commit()

    def _on_line(self, value: float) -> None:
        self._drag = uuid4().hex
        self.show_threshold(value)
        self._commit()

    def _on_notice(self) -> None:
        state, scan = self.controller.scan, self.controller.current
        if state is None or scan is None:
            return
        if state.scan.pose is None:
            self.origin_asked.emit(scan)
        else:
            self.controller.want(scan, SCORE)

    def _on_preview(self, wanted: bool) -> None:
        if wanted:
            self._colour_before = self.controller.view.colour
        self.controller.look(colour=GHOST if wanted else self._colour_before)
