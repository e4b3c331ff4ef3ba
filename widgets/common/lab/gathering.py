"""The points of a plot: asked of the document, read once, made ready to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.model.fields import Same
from app.model.leaf import join_members
from app.model.project import Project
from app.services.lab.gather import gather
from widgets.common.angular_points import STEP, AngularPoints, reduce_points
from widgets.common.aside import copy_aside
from widgets.common.panel import Panel
from widgets.common.plots import MOST_DOTS

FEW_POINTS = 50_000
Group = tuple[str, ...]
Wanted = tuple[Group, str]
Mark = tuple[object, ...]


@dataclass(frozen=True, slots=True)
class Order:
    """Points to be read: leaves (none: the whole scan) and channel of each, width of the steps."""

    scan: str
    wanted: tuple[Wanted, ...]
    width: float = STEP


class Gathering(QObject):
    """Holds the points of what was asked for last; what did not change is not read again.

    Signals
    -------
    ready()
        Points arrived from the worker.
    """

    ready = Signal()

    def __init__(self, panel: Panel) -> None:
        super().__init__(panel)
        self._panel, self._controller = panel, panel.controller
        self._found: dict[Wanted, tuple[Mark, AngularPoints]] = {}
        self._on_the_way: dict[Wanted, Mark] = {}

    def forget(self) -> None:
        """Let go of everything."""
        self._found, self._on_the_way = {}, {}

    def gather(self, order: Order) -> dict[Wanted, AngularPoints] | None:
        """The points of an order; None while some are still being computed or read."""
        if not self._ask(order):
            return None
        marks = {wanted: self._mark(order, wanted) for wanted in order.wanted}
        self._found = {
            w: held for w, held in self._found.items() if w in marks and held[0] == marks[w]
        }
        missing = {w: mark for w, mark in marks.items() if w not in self._found}
        if missing and self._measure(order, missing) > FEW_POINTS:
            self._read_aside(order, missing)
            return None
        for wanted, mark in missing.items():
            self._found[wanted] = (mark, _read(self._controller.project, order, wanted))
        return {wanted: self._found[wanted][1] for wanted in order.wanted}

    def _ask(self, order: Order) -> bool:
        """Have the fields computed that the points need."""
        project, panel = self._controller.project, self._panel
        state = project.state.scan(order.scan)
        keys = dict.fromkeys(key for group, _ in order.wanted for key in group)
        leaves = [project.state.leaves[key] for key in keys]
        parts = tuple(Same(leaf.members) for leaf in leaves)
        points = join_members(leaves, len(state.scan)) if leaves else None
        catalogue = project.catalogue(order.scan)
        needed = dict.fromkeys(("incidence", *(channel for _, channel in order.wanted)))
        known = [
            panel.ask(order.scan, name, points, parts)
            for name in needed
            if name == "incidence" or not catalogue[name].stored
        ]
        return all(known)

    def _mark(self, order: Order, wanted: Wanted) -> Mark:
        """What the points depend on."""
        project, (group, channel) = self._controller.project, wanted
        state = project.state.scan(order.scan)
        stored = project.catalogue(order.scan)[channel].stored
        values = state.scan.attributes if stored else project.known_field(order.scan, channel)
        return (
            order.scan,
            channel,
            order.width,
            tuple(Same(project.state.leaves[key].members) for key in group),
            Same(project.known_field(order.scan, "incidence")),
            Same(values),
            Same(state.deleted),
            state.channels,
            state.parameters.radiometry,
        )

    def _measure(self, order: Order, missing: dict[Wanted, Mark]) -> int:
        state = self._controller.project.state
        whole = state.scan(order.scan).shown
        return sum(
            sum(len(state.leaves[key].members) for key in group) if group else whole
            for group, _ in missing
        )

    def _read_aside(self, order: Order, missing: dict[Wanted, Mark]) -> None:
        if missing == self._on_the_way:
            return
        self._on_the_way = missing
        aside = copy_aside(self._controller.project, order.scan)

        def work(progress: Progress) -> dict[Wanted, AngularPoints] | LeafscopeError:
            try:
                return {wanted: _read(aside, order, wanted, progress) for wanted in missing}
            except LeafscopeError as error:
                return error

        def done(found: dict[Wanted, AngularPoints] | LeafscopeError) -> None:
            if missing is not self._on_the_way:
                return
            if isinstance(found, dict):
                self._on_the_way = {}
                self._found |= {w: (missing[w], points) for w, points in found.items()}
                self.ready.emit()
            else:
                self._controller.failed.emit(found)

        self._controller.run(self.tr("Drawing intensity against angle"), work, done)


def _read(
    project: Project, order: Order, wanted: Wanted, progress: Progress | None = None
) -> AngularPoints:
    group, channel = wanted
    given: Sequence[Progress] = () if progress is None else (progress,)
    return reduce_points(
        gather(project, order.scan, group, channel, *given), MOST_DOTS, order.width
    )
