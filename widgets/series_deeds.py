"""What the window does with series: ask for one, open its scans, put it into the document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from app.core.units import count_points
from app.model.scan import Scan
from app.model.series import SeriesEntry
from app.model.state import ScanState
from app.services.opening import add_scans
from app.services.series.document import change_series, make_series
from app.services.series.entries import Entry
from app.services.series.opening import read_all
from app.services.series.order import list_scans
from widgets.common.series.entry_table import ScanRow
from widgets.controller import Controller
from widgets.dialogs.open_scan import FileDialogs
from widgets.dialogs.series import SeriesDialog, WantedSeries

if TYPE_CHECKING:
    from widgets.docks import Docks
    from widgets.panels.series import SeriesPanel


class SeriesDeeds(QObject):
    """Makes series of open scans and of files.

    Signals
    -------
    made(str)
        Key of a series that was made or changed.
    """

    made = Signal(str)

    def __init__(self, window: QWidget, controller: Controller, dialogs: FileDialogs) -> None:
        super().__init__(window)
        self._window, self._controller, self._dialogs = window, controller, dialogs

    def serve(self, panel: SeriesPanel, docks: Docks) -> None:
        """Do what a panel asks for, and show it what was made."""
        self._panel, self._docks = panel, docks
        panel.dialogs = self._dialogs
        panel.make_asked.connect(self.make)
        panel.change_asked.connect(self.change)
        self.made.connect(self._show)

    def make(self) -> None:
        """Ask for a series, of the scans that are open to begin with."""
        rows = [
            ScanRow(_file_of(state), key, Entry(_file_of(state)))
            for key, state in self._controller.project.state.scans.items()
            if not state.closed
        ]
        self._ask(rows)

    def open_folder(self) -> None:
        """Ask for a folder, and for what its scans are."""
        self._dialogs.ask_folder(self.tr("A folder with the scans of a series"), self.offer_folder)

    def offer_folder(self, folder: Path) -> None:
        """Ask what the scans of a folder are."""
        self._controller.attempt(
            lambda: self._ask([ScanRow(file, "", Entry(file)) for file in list_scans([folder])])
        )

    def change(self, key: str) -> None:
        """Ask what is different about a series."""
        series = self._controller.project.state.series.get(key)
        if series is None:
            return
        scans = self._controller.project.state.scans
        rows = [
            ScanRow(
                _file_of(scans[one.scan]), one.scan,
                Entry(_file_of(scans[one.scan]), one.angle_deg, one.hours, None,
                      one.treatment, one.label),
            )
            for one in series.entries
        ]  # fmt: skip
        reference = [one.scan for one in series.entries].index(series.reference)
        self._ask(rows, key, series.name, reference)

    def put(self, wanted: WantedSeries, key: str = "") -> None:
        """Open the scans that are not open yet, then make the series (or change one)."""
        new = [row.file for row in wanted.rows if not row.scan]
        if not new:
            self._put(wanted, key)
            return

        def done(scans: list[Scan]) -> None:
            self._add(wanted, key, scans)

        title = self.tr("Opening {n} scans").format(n=len(new))
        self._controller.run(title, partial(read_all, new), done)

    def _show(self, key: str) -> None:
        self._docks.raise_panel("series")
        self._panel.show_series(key)

    def _ask(
        self, rows: Sequence[ScanRow], key: str = "", name: str = "", reference: int = -1
    ) -> None:
        then = partial(self.put, key=key)
        SeriesDialog(
            self._controller, rows, self._dialogs, then, self._window, name, reference
        ).open()

    def _add(self, wanted: WantedSeries, key: str, scans: list[Scan]) -> None:
        controller = self._controller
        keys: list[str] = []
        if not controller.attempt(lambda: keys.extend(add_scans(controller.project, scans))):
            return
        opened = iter(keys)
        rows = tuple(row if row.scan else replace(row, scan=next(opened)) for row in wanted.rows)
        first = scans[0]
        colour = controller.view.colour or (first.channels[0].name if first.channels else "")
        controller.look(colour=colour)
        self._put(replace(wanted, rows=rows), key)
        controller.said.emit(
            self.tr("{n} scans with {points} opened.").format(
                n=len(scans), points=count_points(sum(map(len, scans)))
            )
        )

    def _put(self, wanted: WantedSeries, key: str) -> None:
        project = self._controller.project
        entries = [
            SeriesEntry(
                row.scan, row.entry.angle_deg, row.entry.hours, row.entry.treatment,
                row.entry.label,
            )
            for row in wanted.rows
        ]  # fmt: skip
        reference = wanted.rows[wanted.reference].scan
        keys = [key]

        def put() -> None:
            if key in project.state.series:
                change_series(project, key, wanted.name, entries, reference)
            else:
                keys[0] = make_series(project, wanted.name, entries, reference)

        if self._controller.attempt(put):
            self.made.emit(keys[0])


def _file_of(state: ScanState) -> Path:
    source = state.scan.source
    return Path(state.scan.name if source is None else source.path)
