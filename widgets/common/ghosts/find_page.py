"""Which points count as ghosts, and what can be done with all of them at once."""

from __future__ import annotations

from collections.abc import Hashable
from uuid import uuid4

from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.model.fields import Same, Values
from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.model.selection import FieldRange
from app.services.beams import propose_beam
from app.services.cleanup.evidence import DENSITY_METHOD, GRID_METHOD
from widgets.common.ghosts.counts import GhostCounts, count_ghosts
from widgets.common.ghosts.score_plot import ScorePlot
from widgets.common.ghosts.settings import GhostSettings
from widgets.common.numbers import show_count, show_number
from widgets.controller import Controller
from widgets.leaf_work import LeafWork

GHOST = "ghost"
FEW_POINTS = 200_000
PLOT_LINES = 15


def say_method(known: Values) -> str:
    """How the score was found, in words."""
    return GRID_METHOD if known.notes.get("method") == "scan grid" else DENSITY_METHOD


class FindPage(QWidget):
    """Score, threshold, counts; mark, delete or correct what counts as a ghost."""

    def __init__(self, controller: Controller, work: LeafWork, parent: QWidget) -> None:
        super().__init__(parent)
        self.controller, self.work = controller, work
        self.counts: GhostCounts | None = None
        self._counts_for: Hashable = None
        self._drag = uuid4().hex
        self._colour_before = ""
        self._on_grid = True
        self.plot = ScorePlot(self)
        self.settings = GhostSettings(self)
        self.summary = QLabel(self)
        self.method = QLabel(self)
        self.preview = QCheckBox(self.tr("Colour the cloud by &ghost"), self)
        self.mark_button = QPushButton(self.tr("&Mark"), self)
        self.delete_button = QPushButton(self.tr("&Delete"), self)
        self.correct_button = QPushButton(self.tr("&Correct"), self)
        self.unmark_button = QPushButton(self.tr("&Unmark"), self)
        self._arrange()
        self._explain()
        self._connect()

    def _arrange(self) -> None:
        for label in (self.summary, self.method):
            label.setWordWrap(True)
        self.method.setProperty("faint", "true")
        buttons = QGridLayout()
        for place, button in enumerate(self._buttons):
            buttons.addWidget(button, place // 2, place % 2)
        layout = QVBoxLayout(self)
        # The page is as high as the other one: buttons stay in sight in a low window.
        self.plot.setMaximumHeight(PLOT_LINES * self.fontMetrics().height())
        layout.addWidget(self.plot)
        layout.addWidget(self.settings)
        layout.addWidget(self.summary)
        layout.addWidget(self.method)
        layout.addWidget(self.preview)
        layout.addLayout(buttons)
        layout.addStretch(1)

    def _explain(self) -> None:
        tips = (
            self.tr("Mark what the threshold calls ghosts; nothing is removed"),
            self.tr("Delete the ghosts; undo brings them back"),
            self.tr("Put ghosts back on the surface that fills most of their beam"),
            self.tr("Forget all marks and answers of this scan: the score decides again"),
        )
        for button, tip in zip(self._buttons, tips, strict=True):
            button.setToolTip(tip)

    @property
    def _buttons(self) -> tuple[QPushButton, ...]:
        return self.mark_button, self.delete_button, self.correct_button, self.unmark_button

    def _connect(self) -> None:
        self.settings.threshold_moved.connect(self.show_threshold)
        self.settings.threshold_set.connect(self._commit)
        self.settings.grabbed.connect(self._begin_drag)
        self.settings.beam.changed.connect(self._use_beam)
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
        return self.settings.threshold

    def show_score(self, known: Values | None) -> None:
        """Show the score of the current scan; None where there is none."""
        state = self.controller.scan
        self.preview.setChecked(self.controller.view.colour == GHOST)
        if state is None or known is None:
            self.counts, self._counts_for = None, None
            return
        self.settings.beam.show_beam(state.parameters.beam, propose_beam(state.scan))
        self.method.setText(self.tr("Score from: {0}.").format(say_method(known)))
        self._on_grid = say_method(known) == GRID_METHOD
        self.settings.suggest("delete" if self._on_grid else "mark")
        self.correct_button.setToolTip(
            self.tr("Put ghosts back on the surface that fills most of their beam")
            if self._on_grid
            else self.tr("Nothing can be corrected without rows and columns; mark or delete")
        )
        if not self.settings.slider.isSliderDown():
            self.show_threshold(state.parameters.ghost_threshold)
        mark = (Same(known), Same(state.marks), Same(state.deleted))
        if mark != self._counts_for:
            self._counts_for = mark
            self._count(known, mark)
        else:
            self._tell()

    def show_threshold(self, threshold: float) -> None:
        """Show what a threshold would do; the document is not touched."""
        self.settings.show_threshold(threshold)
        self.plot.show_threshold(self.threshold)
        self._tell()

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
        for button in (self.mark_button, self.delete_button):
            button.setEnabled(ghosts > 0)
        self.correct_button.setEnabled(ghosts > 0 and self._on_grid)
        self.unmark_button.setEnabled(counts.marked + counts.kept > 0)

    def unmark(self) -> None:
        """Forget all marks of the scan."""
        scan, state = self.controller.current, self.controller.scan
        if scan is not None and state is not None:
            judged = PointSet.from_mask(state.marks != 0)
            self.controller.do(MarkGhosts(scan, cleared=judged, basis=FieldRange(GHOST, 0.0, 1.0)))

    def _begin_drag(self) -> None:
        self._drag = uuid4().hex

    def _commit(self, _: float = 0.0) -> None:
        state = self.controller.scan
        if state is not None and self.threshold != state.parameters.ghost_threshold:
            self.work.set_parameters(
                drag=f"ghost threshold {self._drag}", ghost_threshold=self.threshold
            )

    def _on_line(self, value: float) -> None:
        self._begin_drag()
        self.show_threshold(value)
        self._commit()

    def _use_beam(self, beam: object) -> None:
        self.work.set_parameters(beam=beam)

    def _on_preview(self, wanted: bool) -> None:
        if wanted:
            self._colour_before = self.controller.view.colour
        self.controller.look(colour=GHOST if wanted else self._colour_before)
