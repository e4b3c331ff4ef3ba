"""Keeps what was worked out for each leaf, and has only those worked out again that changed."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal

from app.core.progress import Progress
from app.model.fields import Same
from app.model.leaf import Leaf
from app.model.project import Project
from app.model.state import ScanState
from widgets.common.aside import copy_aside
from widgets.controller import Controller, Then

Result = TypeVar("Result")


class LeafCache(QObject, Generic[Result]):
    """Results of leaves of the current scan, made in the background.

    Signals
    -------
    measured()
        There are new results.
    """

    measured = Signal()

    def __init__(self, controller: Controller, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.controller = controller
        self._held: dict[str, tuple[Hashable, Result]] = {}
        self._asked: dict[str, Hashable] = {}

    def title(self) -> str:
        """What is being done, for the list of jobs."""
        raise NotImplementedError

    def mark(self, leaf: Leaf, state: ScanState) -> Hashable:
        """All that the result of a leaf depends on."""
        raise NotImplementedError

    def prepare(self, scan: str, state: ScanState, leaves: list[Leaf], then: Then) -> None:
        """Have what leaves need computed, then go on; only where the scanner is known."""
        raise NotImplementedError

    def compute(
        self, project: Project, scan: str, keys: list[str], progress: Progress
    ) -> dict[str, Result]:
        """Results by the key of the leaf; runs in the worker."""
        raise NotImplementedError

    def results(self, leaves: tuple[Leaf, ...]) -> Mapping[str, Result]:
        """Results that are still valid, by the key of the leaf."""
        state = self.controller.scan
        if state is None:
            return {}
        held = ((leaf, self._held.get(leaf.key)) for leaf in leaves)
        return {
            leaf.key: found[1]
            for leaf, found in held
            if found is not None and found[0] == self.mark(leaf, state)
        }

    def measure(self, leaves: tuple[Leaf, ...]) -> None:
        """Work out in the background what is new or changed, and only that."""
        there = self.controller.project.state.leaves
        self._held = {key: one for key, one in self._held.items() if key in there}
        self._asked = {key: mark for key, mark in self._asked.items() if key in there}
        scan, state = self.controller.current, self.controller.scan
        if scan is None or state is None:
            return
        marks = {leaf.key: self.mark(leaf, state) for leaf in leaves}
        valid = self.results(leaves)
        wanted = {
            key: mark
            for key, mark in marks.items()
            if key not in valid and self._asked.get(key) != mark
        }
        if not wanted:
            return
        self._asked.update(wanted)
        if state.scan.pose is None:
            self._run(scan, wanted)
            return

        def then() -> None:
            self._run(scan, wanted)

        self.prepare(scan, state, [leaf for leaf in leaves if leaf.key in wanted], then)

    def _run(self, scan: str, marks: Mapping[str, Hashable]) -> None:
        aside = copy_aside(self.controller.project, scan)

        def work(progress: Progress) -> dict[str, Result]:
            return self.compute(aside, scan, list(marks), progress)

        def done(results: dict[str, Result]) -> None:
            self._held.update((key, (marks[key], one)) for key, one in results.items())
            self.measured.emit()

        self.controller.run(self.title(), work, done)


def mark_leaf(leaf: Leaf, state: ScanState) -> Hashable:
    """What every result depends on: the points of the leaf, and which of the scan are there."""
    return (
        leaf.scan, Same(leaf.members), Same(state.scan.xyz), state.scan.pose, Same(state.deleted),
    )  # fmt: skip
