"""Ghosts: points between two surfaces, found by score, explained, and cleaned up."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QSizePolicy, QTabWidget, QVBoxLayout, QWidget

from app.model.events import EVERYTHING, Change
from app.model.fields import Same, Values
from widgets.common.ghosts.find_page import FindPage
from widgets.common.ghosts.session_page import SessionPage
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling

SCORE = "ghost_score"


class GhostsPanel(Panel):
    """Two pages: find ghosts, and go through them.

    Signals
    -------
    session_shown(bool)
        The page of the queue came to the front, or went.
    """

    session_shown = Signal(bool)

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("ghosts")
        self.setWindowTitle(self.tr("Ghosts"))
        self._kept_up: Same | None = None
        self.notice = Notice(self)
        self.finder = FindPage(self.controller, self.work, self)
        self.page = SessionPage(self.controller, self)
        self.pages = QTabWidget(self)
        self.pages.setDocumentMode(True)
        self.pages.addTab(self.finder, self.tr("Find"))
        self.pages.addTab(self.page, self.tr("Go through"))
        self.pages.setTabToolTip(0, self.tr("Which points count as ghosts; act on all at once"))
        self.pages.setTabToolTip(
            1, self.tr("One after the other: why it is a ghost, and what is to become of it")
        )
        self.pages.tabBar().setAccessibleName(self.tr("Find ghosts, or go through them"))
        self.point = QLabel(self)
        self.point.setWordWrap(True)
        self.point.setAccessibleName(self.tr("What is known of the point that was picked"))
        self.point.hide()
        self._arrange()
        self._make_room(0)
        self._connect()

    def _arrange(self) -> None:
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.notice)
        layout.addWidget(self.pages, 1)
        layout.addWidget(self.point)
        layout.addStretch(0)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.notice.clicked.connect(self._on_notice)
        self.pages.currentChanged.connect(self._on_page)
        self.finder.settings.answers_changed.connect(self.refresh_soon)

    @property
    def in_session(self) -> bool:
        """Whether somebody goes through the queue."""
        return self.page.isVisible()

    @property
    def known_score(self) -> Values | None:
        """Score of all points of the current scan, if it is there."""
        scan = self.controller.current
        if scan is None:
            return None
        known = self.controller.project.known_field(scan, SCORE)
        return known if known is not None and known.complete else None

    def refresh(self) -> None:
        """Show score and queue of the current scan, or what is missing."""
        known = self.known_score
        if known is not None:
            self._kept_up = self._current_scan()
        missing, action = self._find_missing(known)
        self.notice.say(missing, action)
        self.pages.setVisible(known is not None)
        if known is None:
            self.point.hide()
        self.finder.show_score(known)
        if self.pages.currentIndex() == 1:
            settings = self.finder.settings
            self.page.session.follow(known, settings.sure, settings.uncertain)
        elif known is None:
            self.page.session.drop()

    def on_document(self, change: Change) -> None:
        """Let go of a document that is gone."""
        if change is EVERYTHING:
            self._kept_up = None
            self.page.session.drop()
        super().on_document(change)

    def restyle(self) -> None:
        """Draw in the new colours."""
        self.finder.plot.restyle()

    def explain(self, text: str) -> None:
        """Show what is known of the point that was picked; nothing hides it."""
        self.point.setText(text)
        self.point.setVisible(bool(text) and self.known_score is not None)

    def _find_missing(self, known: Values | None) -> tuple[str, str]:
        state, scan = self.controller.scan, self.controller.current
        if state is None or scan is None:
            return self.tr("Open a scan to look for ghost points in it."), ""
        if state.scan.pose is None:
            return self.tr(
                "Nobody knows where the scanner stood. Ghosts lie along its beams, so the "
                "score needs its position."
            ), self.tr("Set position…")
        if known is not None:
            return "", ""
        if self._is_kept_up():
            self.ask(scan, SCORE, None)
            if self.controller.bridge.jobs:
                return self.tr("The points are not where they were: the score is found anew."), ""
        return self.tr(
            "Where a beam met two surfaces, the scanner reports a ghost in between. "
            "The score tells how much each point looks like one."
        ), self.tr("Compute score")

    def _is_kept_up(self) -> bool:
        """Whether the score of this scan was shown before: then it follows the points."""
        return self._kept_up is not None and self._kept_up == self._current_scan()

    def _current_scan(self) -> Same:
        """The current scan as it was read, whatever was done to it since."""
        return Same(self.controller.project.state.library.get(self.controller.current or ""))

    def _on_notice(self) -> None:
        state, scan = self.controller.scan, self.controller.current
        if state is None or scan is None:
            return
        if state.scan.pose is None:
            self.origin_asked.emit(scan)
        else:
            self.controller.want(scan, SCORE)

    def _make_room(self, page: int) -> None:
        """Let the page that is not shown claim no height."""
        policy = QSizePolicy.Policy
        for number, each in enumerate((self.finder, self.page)):
            vertical = policy.Preferred if number == page else policy.Ignored
            each.setSizePolicy(policy.Preferred, vertical)

    def _on_page(self, page: int) -> None:
        self._make_room(page)
        self.session_shown.emit(page == 1)
        self.refresh_soon()
        if page == 1:
            self.page.table.setFocus()
