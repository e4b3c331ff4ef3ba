"""All that actions may call, in one hand."""

from __future__ import annotations

from dataclasses import dataclass

from widgets.controller import Controller
from widgets.file_deeds import FileDeeds
from widgets.picture import Picture
from widgets.scan_deeds import ScanDeeds
from widgets.series_deeds import SeriesDeeds
from widgets.tools import Tools
from widgets.view_deeds import ViewDeeds


@dataclass(frozen=True, slots=True)
class Desk:
    """The parts of the window that an action works with."""

    controller: Controller
    tools: Tools
    files: FileDeeds
    scans: ScanDeeds
    picture: Picture
    views: ViewDeeds
    series: SeriesDeeds

    @property
    def has_scan(self) -> bool:
        """Whether there is a scan to work on."""
        return self.controller.current is not None

    @property
    def has_pose(self) -> bool:
        """Whether it is known where the scanner stood."""
        scan = self.controller.scan
        return scan is not None and scan.scan.pose is not None

    @property
    def has_text(self) -> bool:
        """Whether the current scan came from a text file."""
        scan = self.controller.scan
        return scan is not None and scan.scan.metadata.get("format") == "text"

    @property
    def has_selection(self) -> bool:
        """Whether points are selected."""
        scan = self.controller.scan
        return scan is not None and len(scan.selection) > 0

    @property
    def has_leaves(self) -> bool:
        """Whether the current scan has a leaf."""
        scan = self.controller.current
        return scan is not None and bool(self.controller.project.state.leaves_of(scan))

    @property
    def has_deleted(self) -> bool:
        """Whether points are deleted."""
        scan = self.controller.scan
        return scan is not None and bool(scan.deleted.any())

    @property
    def can_undo(self) -> bool:
        """Whether a step is in force."""
        return bool(self.controller.project.history.done)

    @property
    def can_redo(self) -> bool:
        """Whether a step was undone."""
        return bool(self.controller.project.history.undone)
