"""Leaves carried through a series: the scans one after the other, and what was found in each."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.model.operations import Select, Several
from app.model.points import EMPTY, PointSet
from app.model.series import Series
from app.model.view_state import Preview
from app.services.series.carrying import Found
from app.services.series.document import correct_leaves
from widgets.common.notice import Notice
from widgets.common.series.finder import Finder
from widgets.common.series.found_list import FoundList
from widgets.common.series.scan_steps import ScanSteps
from widgets.common.series.words import SIGNS, name_entry
from widgets.controller import Controller


class CarryPage(QWidget):
    """Steps through the scans of one series; every word of the user is a step to undo."""

    def __init__(self, controller: Controller, finder: Finder, parent: QWidget) -> None:
        super().__init__(parent)
        self._controller, self._finder = controller, finder
        self._key = ""
        self._previewed: Hashable = None
        self.steps = ScanSteps(self)
        self.here = QLabel(self)
        self.notice = Notice(self)
        self.list = FoundList(self)
        self.here.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.steps, 1)
        layout.addWidget(self.here)
        layout.addWidget(self.notice)
        layout.addWidget(self.list, 1)
        self._connect()

    def _connect(self) -> None:
        self.steps.chosen.connect(self.show_scan)
        self.steps.all_asked.connect(self.look_through)
        self.steps.alone_asked.connect(self._hide_others)
        self.list.selected.connect(self._on_leaf)
        self.list.confirmed.connect(self.confirm)
        self.list.taken.connect(self.use_selection)
        self.list.missed.connect(self.say_missing)
        self.list.reset.connect(self.forget_words)

    # What is shown

    @property
    def series(self) -> Series | None:
        """The series that is shown, as it is now."""
        return self._controller.project.state.series.get(self._key)

    def refresh(self, series: Series) -> None:
        """Show a series; leaves of the current scan are looked for when they are not known."""
        self._key = series.key
        current = self._controller.current
        scans = [entry.scan for entry in series.entries]
        place = scans.index(current) if current in scans else -1
        rows = [self._write(series, entry.scan) for entry in series.entries]
        names = [self._controller.project.state.scan(scan).scan.name for scan in scans]
        self.steps.show_scans(rows, names, place)
        self._show_found(series, current if place >= 0 else None)

    def _write(self, series: Series, scan: str) -> list[str]:
        entry = series.entry(scan)
        name = name_entry(entry, self._controller.project.state.scan(scan).scan.name)
        if scan == series.reference:
            return [f"● {name}", "", "", "", ""]
        look = self._finder.look(series, scan)
        if look is None or look.problem:
            said = str(len(entry.corrections) or "")
            return [name, "…" if look is None else "!", "", "", said]
        counts = [sum(one.verdict == verdict for one in look.found) for verdict in SIGNS]
        return [name, *(str(count or "") for count in counts)]

    def _show_found(self, series: Series, scan: str | None) -> None:
        if scan is None:
            self.here.setText(self.tr("Choose a scan of the series to see its leaves."))
        else:
            self._finder.want(series, [scan])
        look = None if scan is None else self._finder.look(series, scan)
        found = () if look is None else look.found
        self.here.setVisible(scan is None)
        self.notice.say("" if look is None else look.problem)
        self.list.setVisible(scan is not None and not (look is not None and look.problem))
        state = self._controller.scan
        points = 0 if state is None else len(state.selection)
        leaf = self._controller.view.leaf or ""
        self.list.show_found(found, scan == series.reference, points, leaf)
        if look is not None and scan is not None:
            self._preview(series, scan, found)

    def _preview(self, series: Series, scan: str, found: Sequence[Found]) -> None:
        """Show the leaves in the picture; those of the reference are the document's own."""
        shown = () if scan == series.reference else tuple(found)
        mark = (scan, tuple(map(id, shown)))
        if mark == self._previewed and bool(shown) == bool(self._controller.view.previewed):
            return
        self._previewed = mark
        self._controller.look(
            previewed=tuple(
                Preview(scan, one.leaf.key, PointSet(one.rows)) for one in shown if len(one.rows)
            )
        )

    def forget(self) -> None:
        """Let go of a document that is gone."""
        self._previewed = None
        self._key = ""
        self.list.found = ()

    # Scans

    def show_scan(self, place: int) -> None:
        """Go to a scan of the series; the others are hidden where that is wanted."""
        if self.series is None or not 0 <= place < len(self.series.entries):
            return
        scan = self.series.entries[place].scan
        if self._controller.project.state.scan(scan).closed:
            self._controller.said.emit(self.tr("This scan was closed; undo brings it back."))
            return
        self._controller.look(current=scan, hidden=self._hidden(scan))

    def go_to(self, series: Series, scan: str) -> None:
        """Go to a scan of a series that was not shown before."""
        self._key = series.key
        self.show_scan([entry.scan for entry in series.entries].index(scan))

    def look_through(self) -> None:
        """Look for the leaves in all scans."""
        if self.series is not None:
            self._finder.want_again(self.series, [entry.scan for entry in self.series.entries])

    def _hide_others(self) -> None:
        if self._controller.current is not None:
            self._controller.look(hidden=self._hidden(self._controller.current))

    def _hidden(self, scan: str) -> tuple[str, ...]:
        entries = () if self.series is None else self.series.entries
        own = {entry.scan for entry in entries}
        kept = tuple(key for key in self._controller.view.hidden if key not in own)
        alone = self.steps.alone.isChecked()
        return (*kept, *(key for key in own if alone and key != scan))

    # What the user says of leaves

    def confirm(self) -> None:
        """The selected leaves have the points that were found."""
        chosen = [one for one in self.list.chosen if len(one.rows)]
        self._say("Confirm", {one.leaf.key: PointSet(one.rows) for one in chosen})

    def say_missing(self) -> None:
        """The selected leaves are not in this scan."""
        self._say("Leave out", {one.leaf.key: EMPTY for one in self.list.chosen})

    def forget_words(self) -> None:
        """Look again for the selected leaves."""
        self._say("Reset", {one.leaf.key: None for one in self.list.chosen})

    def use_selection(self) -> None:
        """The selected leaf has the selected points; the selection is then empty."""
        state, chosen = self._controller.scan, self.list.chosen
        if state is not None and len(chosen) == 1 and len(state.selection):
            self._say("Correct", {chosen[0].leaf.key: state.selection}, clears=True)

    def _say(self, verb: str, members: dict[str, PointSet | None], clears: bool = False) -> None:
        series, scan = self.series, self._controller.current
        if series is None or scan is None or not members:
            return
        step = correct_leaves(series, scan, members, verb)
        clearing = (Select(scan, EMPTY),) if clears else ()
        self._controller.do(Several(step.title, (step, *clearing)) if clears else step)

    def _on_leaf(self) -> None:
        chosen = self.list.chosen
        if len(chosen) == 1 and chosen[0].leaf.key != self._controller.view.leaf:
            self._controller.look(leaf=chosen[0].leaf.key)
        elif self.series is not None:
            self.refresh(self.series)
