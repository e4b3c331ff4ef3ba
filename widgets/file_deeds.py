"""What the File menu does: dialogs around `Documents`, and never a loss without a question."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMessageBox, QWidget

from app.core.progress import Progress
from app.core.units import count_points
from app.formats.session import SUFFIX
from app.model.operations import AddScan, CloseScan, Several
from app.model.project import Project
from widgets.controller import Controller
from widgets.dialogs.export import ExportDialog
from widgets.dialogs.open_scan import FileDialogs
from widgets.documents import Documents
from widgets.picture import Picture

if TYPE_CHECKING:
    from app.services.simulation_order import Order

DEMO_COLOUR = "reflectance_1063"
Button = QMessageBox.StandardButton


class FileDeeds(QObject):
    """Opens, saves, exports and closes; every dialog is open, none blocks."""

    def __init__(
        self, window: QWidget, controller: Controller, documents: Documents, picture: Picture
    ) -> None:
        super().__init__(window)
        self._window, self._controller, self._documents = window, controller, documents
        self._picture = picture
        self.dialogs = FileDialogs(window)

    def new(self) -> None:
        """Begin an empty session."""
        self.when_safe(self._documents.new)

    def open(self) -> None:
        """Ask for scans or a session."""
        self.dialogs.ask_open(self.open_paths)

    def open_paths(self, paths: list[Path]) -> None:
        """Open files; a session takes the place of what is open, so ask first."""
        if any(path.suffix == SUFFIX for path in paths):
            self.when_safe(lambda: self._documents.open(paths))
        else:
            self._documents.open(paths)

    def open_demo(self) -> None:
        """Open the demo scan, made on the spot the first time."""

        def work(progress: Progress) -> Path:
            from app.services.demo import demo_file

            return demo_file(progress)

        def done(path: Path) -> None:
            self._controller.look(colour=DEMO_COLOUR)
            self._documents.open([path])

        self._controller.run(self.tr("Preparing the demo"), work, done)

    def simulate(self) -> None:
        """Ask which scene to scan with which instrument, and where to write the points."""
        from widgets.dialogs.simulate import SimulateDialog

        SimulateDialog(self._controller, self.dialogs, self._simulate, self._window).open()

    def save(self) -> None:
        """Save to the session's file; ask for a name the first time."""
        self.save_then(_nothing)

    def save_as(self) -> None:
        """Ask for a name and save there."""
        self.dialogs.ask_save(self._suggest(SUFFIX), self._save)

    def save_then(self, then: Callable[[], object]) -> None:
        """Save, and go on only when it is on the disk."""

        def save(path: Path) -> None:
            if self._save(path):
                then()

        if self._documents.path is not None:
            save(self._documents.path)
        else:
            self.dialogs.ask_save(self._suggest(SUFFIX), save)

    def export(self) -> None:
        """Ask what of the current scan to write, and where."""
        if self._controller.current is not None:
            ExportDialog(self._controller, self._documents, self.dialogs, self._window).open()

    def close_scan(self) -> None:
        """Take the current scan off the table; undo brings it back."""
        controller, key = self._controller, self._controller.current
        if key is None or not controller.do(CloseScan(key)):
            return
        scans = controller.project.state.scans
        rest = [other for other, state in scans.items() if not state.closed]
        controller.look(current=rest[0] if rest else None)

    def quit(self) -> None:
        """Close the window; it asks about unsaved work itself."""
        self._window.close()

    def when_safe(self, then: Callable[[], object]) -> None:
        """Go on at once if nothing can be lost, else ask: save, discard or cancel."""
        if not holds_work(self._controller.project):
            then()
            return
        box = QMessageBox(self._window)
        box.setObjectName("unsaved")
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(self.tr("Save the session before going on?"))
        box.setInformativeText(
            self.tr("Leaves, fits, marks and deletions since the last save would be lost.")
        )
        box.setStandardButtons(Button.Save | Button.Discard | Button.Cancel)
        box.setDefaultButton(Button.Save)

        def decide(answer: int) -> None:
            box.deleteLater()
            if answer == Button.Save:
                self.save_then(then)
            elif answer == Button.Discard:
                then()

        box.finished.connect(decide)
        box.open()

    def _save(self, path: Path) -> bool:
        self._picture.keep_camera()
        return self._documents.save(path)

    def _simulate(self, order: Order, path: Path, opens: bool) -> None:
        def work(progress: Progress) -> dict[str, Any]:
            from app.services.simulation import Targets, simulate_file

            # The file dialog has asked about an existing file.
            return simulate_file(order, Targets(path, overwrite=True), progress)

        def done(report: dict[str, Any]) -> None:
            written = self.tr("{0} written to {1}.").format(count_points(report["points"]), path)
            self._controller.said.emit(written)
            if opens:
                self._controller.look(colour=report["channels"][0])
                self._documents.open([path])

        self._controller.run(self.tr("Simulating {0}").format(path.name), work, done)

    def _suggest(self, suffix: str) -> Path:
        scan = self._controller.scan
        stem = Path(scan.scan.name).stem if scan is not None else "session"
        return self.dialogs.folder / f"{stem}{suffix}"


def holds_work(project: Project) -> bool:
    """Whether closing would lose more than a file that can be opened again."""
    if not project.modified:
        return False
    if project.saved_at:
        return True
    return any(not _only_opens(entry.operation) for entry in project.history.log)


def _only_opens(operation: object) -> bool:
    if isinstance(operation, Several):
        return all(_only_opens(step) for step in operation.steps)
    return isinstance(operation, AddScan)


def _nothing() -> None:
    """Go on with nothing."""
