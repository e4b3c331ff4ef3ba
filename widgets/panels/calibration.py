"""Calibration: from raw numbers to reflectance, whose profile it is, and how sure it is."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from pathlib import Path

from PySide6.QtWidgets import QTabBar, QVBoxLayout, QWidget

from app.core.progress import Progress
from app.core.radiometry.profile import Profile
from app.model.calibrated import calibrated_channels
from app.model.events import EVERYTHING, Change
from app.model.fields import Same
from app.services.radiometry import apply_profile, join_profiles, take_partial_hits
from widgets.common.calibration.budget_page import BudgetPage
from widgets.common.calibration.making_page import MakingPage
from widgets.common.calibration.power_page import PowerPage
from widgets.common.calibration.profile_in_use import ProfileInUse
from widgets.common.calibration.profile_words import Counts, count_marks
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling
from widgets.dialogs.open_scan import FileDialogs

MAKE, POWER, BUDGET = range(3)


class CalibrationPanel(Panel):
    """The profile in use on top; below it making one, the laser's power, the error budget."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("calibration")
        self.setWindowTitle(self.tr("Calibration"))
        self.dialogs = FileDialogs(self)
        self.counts: Counts | None = None
        self._counts_of: Hashable = None
        self.notice = Notice(self)
        self.profile = ProfileInUse(self)
        self.tabs = QTabBar(self)
        self.making = MakingPage(self.controller, self)
        self.power = PowerPage(self.controller, self)
        self.budget = BudgetPage(self.controller, self)
        self._lay_out()
        self._connect()

    def refresh(self) -> None:
        """Show the profile of the current scan, and the page that is open."""
        state = self.controller.scan
        profile = None if state is None else state.parameters.profile
        self.notice.say(*self._find_missing())
        self.profile.setVisible(state is not None)
        self.tabs.setVisible(state is not None)
        self.profile.show_profile(profile)
        self._tell_counts()
        for place, page in enumerate(self._pages):
            page.setVisible(state is not None and place == self.tabs.currentIndex())
        if state is not None:
            self._pages[self.tabs.currentIndex()].refresh()

    def on_document(self, change: Change) -> None:
        """Let go of what belongs to a document that is gone."""
        if change is EVERYTHING:
            self.budget.forget()
            self.making.forget()
        super().on_document(change)

    def show_point(self, scan: str, row: int) -> None:
        """Take over which point was picked."""
        self.budget.show_point(scan, row)

    def use(self, profile: Profile | None) -> None:
        """Put a profile to use for the current scan (None: use none), as one step."""
        key = self.controller.current
        if key is not None:
            self.controller.attempt(lambda: apply_profile(self.controller.project, key, profile))

    @property
    def _pages(self) -> tuple[MakingPage, PowerPage, BudgetPage]:
        return self.making, self.power, self.budget

    def _find_missing(self) -> tuple[str, str]:
        state = self.controller.scan
        if state is None:
            return self.tr("Open a scan to turn its raw numbers into reflectance."), ""
        if state.parameters.profile is not None:
            return "", ""
        if not state.scan.channels:
            return self.tr(
                "This scan has no intensity. If one of its values is one, name it as a channel in "
                "the Scans panel."
            ), ""
        return self.tr(
            "Raw numbers become reflectance by a profile of the instrument: open one, or make one "
            "from panels of known reflectance."
        ), ""

    def _tell_counts(self) -> None:
        """How many points have the first reflectance, as far as it was computed."""
        key, state = self.controller.current, self.controller.scan
        if key is None or state is None or state.parameters.profile is None:
            return
        channels = calibrated_channels(state.scan, state.parameters.profile)
        if not channels:
            return
        field = self._counted([channel.name for channel in channels])
        known = self.controller.project.known_field(key, field)
        self.profile.show_partial(state.parameters.partial_hits, "")
        if known is None or "mark" not in known.beside:
            self.counts = self._counts_of = None
            self.profile.show_counts(field, None, 0, state.shown)
            return
        mark = (Same(known), known.computed, Same(state.deleted))
        if mark != self._counts_of:
            self._counts_of, self.counts = mark, count_marks(known, state.alive)
        counts = self.counts or {}
        self.profile.show_counts(field, counts, sum(counts.values()), state.shown)
        words = str(known.notes.get("partial hits", ""))
        self.profile.show_partial(state.parameters.partial_hits, words)

    def _counted(self, names: list[str]) -> str:
        """The reflectance that points are coloured by, else the first one."""
        colour = self.controller.view.colour
        return colour if colour in names else names[0]

    def _open(self) -> None:
        self.dialogs.ask_file(self.tr("Open a profile"), ".toml", self._open_file, self)

    def _open_file(self, path: Path) -> None:
        from app.services.profiles import read_profile

        self.controller.attempt(lambda: self.use(read_profile(path)))

    def _offer(self) -> None:
        from app.services.profiles import list_profiles

        self.profile.offer(list_profiles())

    def _save_used(self) -> None:
        state = self.controller.scan
        if state is not None and state.parameters.profile is not None:
            self._save(state.parameters.profile)

    def _save(self, profile: Profile) -> None:
        from app.services.profiles import write_profile

        def write(path: Path) -> None:
            if self.controller.attempt(lambda: write_profile(profile, path, overwrite=True)):
                self.controller.said.emit(self.tr("Profile written to {0}.").format(path))

        self._ask_target(profile.name, ".toml", write)

    def _choose_table(self) -> None:
        self.dialogs.ask_file(self.tr("A table of panels"), ".csv", self.making.open_table, self)

    def _use_made(self) -> None:
        if self.making.fit.report is not None:
            state, made = self.controller.scan, self.making.fit.report.profile
            self.use(join_profiles(state.parameters.profile if state else None, made))

    def _save_made(self) -> None:
        if self.making.fit.report is not None:
            self._save(self.making.fit.report.profile)

    def _save_report(self) -> None:
        from app.services.panel_files import write_report

        report = self.making.fit.report
        if report is None:
            return

        def write(path: Path) -> None:
            def work(_: Progress) -> None:
                write_report(report, path, overwrite=True)

            def done(_: None) -> None:
                self.controller.said.emit(self.tr("Report written to {0}.").format(path))

            self.controller.run(self.tr("Writing the report"), work, done)

        self._ask_target(report.profile.name, ".md", write)

    def _ask_target(self, name: str, suffix: str, then: Callable[[Path], object]) -> None:
        self.dialogs.ask_save(self.dialogs.folder / f"{_as_file_name(name)}{suffix}", then, self)

    def _lay_out(self) -> None:
        for title, tip in (
            (self.tr("Make a profile"), self.tr("Fit a profile to panels of known reflectance")),
            (self.tr("Laser power"), self.tr("How strong the laser was in this scan")),
            (self.tr("Error budget"), self.tr("How sure a reflectance is, and why not more")),
        ):
            self.tabs.setTabToolTip(self.tabs.addTab(title), tip)
        self.tabs.setAccessibleName(self.tr("Pages of the calibration"))
        self.tabs.setExpanding(True)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        for widget in (self.notice, self.profile, self.tabs, *self._pages):
            layout.addWidget(widget)
        layout.addStretch(1)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.tabs.currentChanged.connect(self.refresh_soon)
        self.profile.open_asked.connect(self._open)
        self.profile.ready_asked.connect(self.use)
        self.profile.list_asked.connect(self._offer)
        self.profile.save_asked.connect(self._save_used)
        self.profile.removed.connect(self._remove)
        self.profile.partial_asked.connect(self._take_partial)
        self.profile.compute_asked.connect(self._compute)
        self.making.table_asked.connect(self._choose_table)
        self.making.fit.use_asked.connect(self._use_made)
        self.making.fit.save_asked.connect(self._save_made)
        self.making.fit.report_asked.connect(self._save_report)

    def _remove(self) -> None:
        self.use(None)

    def _take_partial(self, wanted: bool) -> None:
        key, project = self.controller.current, self.controller.project
        if key is not None:
            self.controller.attempt(lambda: take_partial_hits(project, key, wanted))

    def _compute(self, field: str) -> None:
        if self.controller.current is not None:
            self.controller.want(self.controller.current, field)


def _as_file_name(name: str) -> str:
    """A name without what file systems refuse."""
    kept = "".join(c if c.isalnum() or c in " -_." else "-" for c in name).strip(" .")
    return kept or "profile"
