"""Files from the window: open, save, export; the slow part runs in the worker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.core.units import count_points
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.session import SUFFIX
from app.model.operations import CloseScan, SetPose
from app.model.project import Project
from app.model.scan import Pose, Scan, Vector
from app.model.view_state import ViewState
from app.services.export import Portion, export, gather, provenance
from app.services.opening import add_scans, given_pose, propose_pose
from app.services.reading import read_file
from app.services.sessions import open_session, save_session
from widgets.common.aside import copy_aside
from widgets.controller import Controller


class Documents(QObject):
    """What the File menu does.

    Signals
    -------
    pose_proposed(str, Pose or None)
        A scan has no pose; its grid speaks for this position, or for none. The user decides.
    path_changed(Path or None)
        The session file that is being worked on.
    """

    pose_proposed = Signal(str, object)
    path_changed = Signal(object)

    def __init__(self, controller: Controller) -> None:
        super().__init__(controller)
        self._controller = controller
        self.path: Path | None = None

    def open(self, paths: Sequence[Path], options: ReadOptions = DEFAULTS) -> None:
        """Open scans, or a session, by what the files are."""
        for path in paths:
            if path.suffix == SUFFIX:
                self.open_session(path)
            else:
                self._open_scan(path, options)

    def reopen(self, scan: str, options: ReadOptions) -> None:
        """Read the file of a scan again, in another way; the scan as it was is closed."""
        source = self._controller.project.state.scan(scan).scan.source
        if source is not None:
            self._open_scan(Path(source.path), options, scan)

    def new(self) -> None:
        """Begin an empty session."""
        self._controller.adopt(Project(), ViewState(theme=self._controller.view.theme))
        self._set_path(None)

    def open_session(self, path: Path) -> None:
        """Open a session in place of what is open."""

        def work(progress: Progress) -> tuple[Project, ViewState]:
            return open_session(path, progress)

        def done(opened: tuple[Project, ViewState]) -> None:
            self._controller.adopt(*opened)
            self._set_path(path)
            self._controller.said.emit(f"{path.name} opened.")

        self._controller.run(f"Opening {path.name}", work, done)

    def save(self, path: Path) -> bool:
        """Save the session; True when it is on the disk."""
        controller = self._controller
        saved = controller.attempt(lambda: save_session(controller.project, controller.view, path))
        if saved:
            self._set_path(path)
            controller.said.emit(f"{path.name} saved.")
        return saved

    def export(self, path: Path, portion: Portion, fields: Sequence[str]) -> None:
        """Write points of the current scan with fields; an existing file is replaced.

        The caller has asked the user about an existing file before.
        """
        controller, key = self._controller, self._controller.current
        if key is None:
            return
        project, aside = controller.project, copy_aside(controller.project, key)
        evaluation, made_by = project.evaluation(key), provenance(project, key)

        def compute(progress: Progress) -> None:
            evaluation.progress = progress
            for name in fields:
                evaluation.read(name)

        def write(progress: Progress) -> int:
            cloud = gather(aside, key, fields, portion)
            export(replace(cloud, provenance=made_by), path, True, progress)
            return len(cloud.scan)

        def then(_: object) -> None:
            project.accept(key, evaluation.results)
            aside.cache.accept(key, evaluation.results)
            controller.run(
                f"Writing {path.name}",
                write,
                lambda points: controller.said.emit(f"{count_points(points)} written to {path}."),
            )

        controller.run("Computing what is exported", compute, then)

    def set_origin(self, scan: str, position: Vector | None) -> None:
        """Say where the scanner stood; None means unknown."""
        state = self._controller.project.state.scan(scan)
        pose = None if position is None else given_pose(position, state.scan)
        self._controller.do(SetPose(scan, pose))

    def accept_pose(self, scan: str, pose: Pose) -> None:
        """Accept a proposed position; it is recorded as assumed."""
        self._controller.do(SetPose(scan, pose))

    def _open_scan(self, path: Path, options: ReadOptions, instead_of: str = "") -> None:
        def work(progress: Progress) -> list[tuple[Scan, Pose | None]]:
            return [(scan, propose_pose(scan)) for scan in read_file(path, options, progress)]

        def done(found: list[tuple[Scan, Pose | None]]) -> None:
            if instead_of in self._controller.project.state.scans:
                self._controller.do(CloseScan(instead_of))
            self._add([scan for scan, _ in found], [pose for _, pose in found])

        self._controller.run(f"Opening {path.name}", work, done)

    def _add(self, scans: list[Scan], proposed: list[Pose | None]) -> None:
        controller = self._controller
        try:
            keys = add_scans(controller.project, scans)
        except LeafscopeError as error:
            controller.failed.emit(error)
            return
        first = scans[0]
        colour = controller.view.colour or (first.channels[0].name if first.channels else "")
        controller.look(current=keys[0], colour=colour)
        controller.said.emit(f"{first.name}: {count_points(sum(map(len, scans)))}.")
        for key, scan, pose in zip(keys, scans, proposed, strict=True):
            if scan.pose is None:
                self.pose_proposed.emit(key, pose)

    def _set_path(self, path: Path | None) -> None:
        self.path = path
        self.path_changed.emit(path)
