"""Index: how it depends on the angle, and on the size of the footprint."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QTabBar, QVBoxLayout, QWidget

from app.core.arrays import Ints
from app.core.channel_index import ChannelIndex
from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.core.units import MM_PER_M, to_mm
from app.model.events import Change
from app.model.fields import Same
from app.model.leaf import join_members
from app.model.smoothed_fields import SMOOTHED
from app.services.index_angle import IndexAngles, compare_angles
from app.services.index_angle_files import group_of_scan, groups_of_scan, join_groups
from app.services.synthetic_footprints import (
    Spread,
    index_in,
    set_synthetic_footprint,
    spread_of_index,
)
from widgets.common.aside import copy_aside
from widgets.common.index.angle_page import AnglePage
from widgets.common.index.choice import list_indices
from widgets.common.index.footprint_page import FootprintPage
from widgets.common.index.index_files import write_angles, write_spread
from widgets.common.index.index_form import IndexForm
from widgets.common.missing import find_missing, list_keys
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling
from widgets.dialogs.open_scan import FileDialogs


class IndexPanel(Panel):
    """Chooses an index, compares it at all angles, averages it over footprints.

    Signals
    -------
    own_asked()
        The user wants to write an index.
    """

    own_asked = Signal()

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("index")
        self.setWindowTitle(self.tr("Index"))
        self.dialogs = FileDialogs(self)
        self._chosen: tuple[str, ...] = ()
        self._angles_for: Hashable = None
        self._spread_for: Hashable = None
        self._trouble = ""
        self.notice = Notice(self)
        self.form = IndexForm(self)
        self.tabs = QTabBar(self)
        self.angles, self.footprint = AnglePage(self), FootprintPage(self)
        self._lay_out()
        self._connect()

    def choose_leaves(self, keys: Sequence[str]) -> None:
        """Take over which leaves are selected in the table."""
        self._chosen = tuple(keys)
        self.refresh_soon()

    def on_document(self, change: Change) -> None:
        """Note a change; when the smoothing is taken back, its colours go with it."""
        super().on_document(change)
        scan, colour = self.controller.current, self.controller.view.colour
        if scan is None or not colour.endswith(SMOOTHED) or "parameters" not in change.aspects:
            return
        catalogue, plain = self.controller.project.catalogue(scan), colour.removesuffix(SMOOTHED)
        if colour not in catalogue and plain in catalogue:
            self.controller.look(colour=plain)

    def refresh(self) -> None:
        """Show the index of what is chosen, or what is missing for it."""
        state, scan, project = (
            self.controller.scan,
            self.controller.current,
            self.controller.project,
        )
        if scan is not None:
            self.form.fill(list_indices(project, scan))
        missing, action = self._find_missing()
        index = None if missing or scan is None else self._find_index(scan)
        self.notice.say(missing or self._trouble, action)
        known = state is not None and state.scan.pose is not None and bool(state.channels)
        self.form.setVisible(known)
        self.tabs.setVisible(known)
        first = self.tabs.currentIndex() == 0
        self.angles.setVisible(known and index is not None and first)
        self.footprint.setVisible(known and not first)
        self._tell_picks(index)
        if scan is None or index is None:
            self._angles_for = None
            return
        if first:
            self._ask_angles(scan, index)
        else:
            self._show_smoothing(scan, index)

    def measure(self) -> None:
        """Measure the spread over footprints in the background."""
        scan, project = self.controller.current, self.controller.project
        index = None if scan is None else self._find_index(scan)
        if scan is None or index is None:
            return
        aside, keys, name = copy_aside(project, scan), self._list_keys(), self.form.index
        leaves, mark, error = keys or (), self._mark(scan, index), self.footprint.error.value()

        def work(progress: Progress) -> Spread:
            return spread_of_index(aside, scan, name, leaves=leaves, error=error, progress=progress)

        def done(found: Spread) -> None:
            if scan == self.controller.current and mark == self._mark(scan, index):
                self._spread_for = mark
                self.footprint.show_found(found)

        self.controller.run(self.tr("Measuring the spread of {0}").format(name), work, done)

    def smooth(self, mm: float, drag: str) -> None:
        """Smooth the view at a size, or (0) no more; steps of one drag are one step to undo."""
        scan, project = self.controller.current, self.controller.project
        if scan is None:
            return
        size = mm / MM_PER_M if mm > 0.0 else None
        if size == project.state.scan(scan).parameters.synthetic_footprint:
            return
        if not self.controller.attempt(lambda: set_synthetic_footprint(project, scan, size, drag)):
            return
        smoothed = self.controller.view.colour + SMOOTHED
        if smoothed in project.catalogue(scan):
            self.controller.look(colour=smoothed)

    def _find_missing(self) -> tuple[str, str]:
        if (
            self.controller.scan is not None
            and self.controller.scan.channels
            and not self.form.index
        ):
            return self.tr(
                "No named index can be had of these channels. Name their wavelengths in the "
                "Scans panel, or write an index of your own."
            ), ""
        return find_missing(
            self.controller.scan,
            self.tr("Open a scan to see its indices."),
            self.tr("This scan has no intensity, and indices are made of it."),
            self.form.what,
            self._list_keys(),
        )

    def _find_index(self, scan: str) -> ChannelIndex | None:
        try:
            return index_in(self.controller.project, scan, self.form.index)
        except LeafscopeError as error:
            self._trouble = str(error)
            return None

    def _list_keys(self) -> tuple[str, ...] | None:
        """Keys of the leaves that are looked at; None for the whole scan."""
        return list_keys(self.controller, self.form.what, self._chosen)

    def _mark(self, scan: str, index: ChannelIndex) -> tuple[Hashable, ...]:
        """What the values of the index depend on."""
        project, keys = self.controller.project, self._list_keys()
        state, leaves = project.state.scan(scan), project.state.leaves
        members = None if keys is None else tuple((leaves[k].name, Same(leaves[k].members))
                                                  for k in keys)  # fmt: skip
        return (scan, self.form.index, index.name, index.channels, self.form.what == "together",
                members, Same(state.deleted), state.channels, Same(state.parameters.profile),
                state.parameters.radiometry[1:])  # fmt: skip

    def _ask_angles(self, scan: str, index: ChannelIndex) -> None:
        project, keys = self.controller.project, self._list_keys()
        leaves = [project.state.leaves[key] for key in keys or ()]
        parts = tuple(Same(leaf.members) for leaf in leaves)
        points: Ints | None = None
        if leaves:
            points = join_members(leaves, len(project.state.scan(scan).scan))
        if not all(self.ask(scan, name, points, parts) for name in ("incidence", *index.channels)):
            return
        angles = Same(project.known_field(scan, "incidence"))
        mark = (self._mark(scan, index), angles, self.angles.model)
        if mark == self._angles_for:
            return
        self._angles_for = mark
        aside, model, together = copy_aside(project, scan), mark[2], self.form.what == "together"

        def work(progress: Progress) -> IndexAngles | LeafscopeError:
            first = progress.part(0.0, 0.3)
            try:
                if keys is None:
                    groups = [group_of_scan(aside, scan, index, first)]
                else:
                    groups = groups_of_scan(aside, scan, index, keys, first)
                wanted = [join_groups(groups)] if together else groups
                later = progress.part(0.3, 1.0)
                return compare_angles(index, wanted, model, None, holder=False, progress=later)
            except LeafscopeError as error:
                return error

        def done(found: IndexAngles | LeafscopeError) -> None:
            if mark == self._angles_for:
                self._take(found)

        self.controller.run(self.tr("Comparing angles"), work, done)

    def _take(self, found: IndexAngles | LeafscopeError) -> None:
        self._trouble = str(found) if isinstance(found, LeafscopeError) else ""
        self.notice.say(self._trouble)
        if isinstance(found, IndexAngles):
            self.angles.show_found(found)

    def _show_smoothing(self, scan: str, index: ChannelIndex) -> None:
        state = self.controller.project.state.scan(scan)
        catalogue, name = self.controller.project.catalogue(scan), self.form.index
        if self._mark(scan, index) != self._spread_for and self.footprint.found is not None:
            self.footprint.show_found(None)
        size = state.parameters.synthetic_footprint
        self.footprint.smoothing.show_size(0.0 if size is None else to_mm(size))
        fields = [f for f in (name, name + SMOOTHED) if f in catalogue and size is not None]
        tip = self.tr("Colour the view by {0}")
        self.footprint.colours.show_fields(
            [(self.tr("View {0}").format(f.replace("_", " ")), f, tip.format(f)) for f in fields],
            self.controller.view.colour,
        )
        names = [c.name for c in state.channels if c.name + SMOOTHED in catalogue]
        off = self.tr("Off: the view shows the points as they were measured.")
        text = self.tr("Smoothed over {mm} mm now: {names}, and the indices of them.")
        mm = "" if size is None else f"{to_mm(size):g}"
        self.footprint.note.setText(
            off if size is None else text.format(mm=mm, names=", ".join(names))
        )

    def _tell_picks(self, index: ChannelIndex | None) -> None:
        words = [] if index is None else [pick.words for pick in index.picks]
        if index is not None and not words:
            words = [self.tr("of {0}").format(", ".join(index.channels))]
        self.form.picks.setText("; ".join(words))
        self.form.picks.setVisible(bool(words))

    def _colour(self, field: str) -> None:
        self.controller.look(colour=field or self.form.index)

    def _export_angles(self, kind: str) -> None:
        found, leaf = self.angles.found, self.angles.leaf
        if found is not None:
            self._export(kind, lambda path: write_angles(found, leaf, kind, path))

    def _export_spread(self, kind: str) -> None:
        found, page = self.footprint.found, self.footprint
        error, reached = page.error.value(), page.reached_mm
        if found is not None:
            self._export(kind, lambda path: write_spread(found, error, reached, path))

    def _export(self, kind: str, write: Callable[[Path], None]) -> None:
        what, _, suffix = kind.partition(".")

        def save(path: Path) -> None:
            said = self.tr("{0} written.").format(path)
            self.controller.run(
                self.tr("Writing {0}").format(path.name),
                lambda _: write(path),
                lambda _: self.controller.said.emit(said),
            )

        suggested = self.dialogs.folder / f"{self.form.index}-{what}.{suffix}"
        self.dialogs.ask_save(suggested, save, self)

    def _on_notice(self) -> None:
        if self.controller.current is not None:
            self.origin_asked.emit(self.controller.current)

    def _on_choice(self) -> None:
        self._trouble = ""
        self.refresh_soon()

    def _lay_out(self) -> None:
        for title, tip in (
            (self.tr("Against angle"), self.tr("The index at each angle of incidence")),
            (self.tr("Footprint"), self.tr("How a wider beam averages angles out")),
        ):
            self.tabs.setTabToolTip(self.tabs.addTab(title), tip)
        self.tabs.setAccessibleName(self.tr("Pages of the index"))
        self.tabs.setExpanding(True)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        for widget in (self.notice, self.form, self.tabs, self.angles, self.footprint):
            layout.addWidget(widget)
        layout.addStretch(1)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.notice.clicked.connect(self._on_notice)
        self.form.changed.connect(self._on_choice)
        self.form.own_asked.connect(self.own_asked)
        self.tabs.currentChanged.connect(self.refresh_soon)
        self.angles.changed.connect(self.refresh_soon)
        self.angles.export_asked.connect(self._export_angles)
        self.footprint.measure_asked.connect(self.measure)
        self.footprint.export_asked.connect(self._export_spread)
        self.footprint.smoothing.moved.connect(self.smooth)
        self.footprint.colours.asked.connect(self._colour)
