"""Keeps what was measured of each leaf, and has only those measured again that changed."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

from PySide6.QtCore import QObject, Signal

from app.core.progress import Progress
from app.model.fields import Same
from app.model.leaf import Leaf, join_members
from app.model.state import ScanState
from app.services.leaves import Row, measure_leaves
from widgets.common.aside import copy_aside
from widgets.controller import Controller

FIELD = "incidence"


class LeafMeasures(QObject):
    """Rows of `measure_leaves` for the leaves of the current scan.

    Signals
    -------
    measured()
        There are new rows.
    """

    measured = Signal()

    def __init__(self, controller: Controller, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._rows: dict[str, tuple[Hashable, Row]] = {}
        self._asked: dict[str, Hashable] = {}

    def rows(self, leaves: tuple[Leaf, ...]) -> Mapping[str, Row]:
        """Rows that are still valid, by the key of the leaf."""
        state = self._controller.scan
        if state is None:
            return {}
        held = ((leaf, self._rows.get(leaf.key)) for leaf in leaves)
        return {
            leaf.key: found[1]
            for leaf, found in held
            if found is not None and found[0] == _mark(leaf, state)
        }

    def measure(self, leaves: tuple[Leaf, ...]) -> None:
        """Measure in the background what is new or changed, and only that."""
        there = self._controller.project.state.leaves
        self._rows = {key: row for key, row in self._rows.items() if key in there}
        self._asked = {key: mark for key, mark in self._asked.items() if key in there}
        scan, state = self._controller.current, self._controller.scan
        if scan is None or state is None:
            return
        marks = {leaf.key: _mark(leaf, state) for leaf in leaves}
        valid = self.rows(leaves)
        keys = [k for k, mark in marks.items() if k not in valid and self._asked.get(k) != mark]
        if not keys:
            return
        self._asked.update((key, marks[key]) for key in keys)
        wanted = {key: marks[key] for key in keys}
        if state.scan.pose is None:
            self._run(scan, wanted)
            return

        def then() -> None:
            self._run(scan, wanted)

        points = join_members([leaf for leaf in leaves if leaf.key in wanted], len(state.scan))
        self._controller.want(scan, FIELD, points[state.alive[points]], then)

    def _run(self, scan: str, marks: dict[str, Hashable]) -> None:
        project = self._controller.project
        aside = copy_aside(project, scan)

        def work(progress: Progress) -> list[Row]:
            return measure_leaves(aside, scan, list(marks), progress)

        def done(rows: list[Row]) -> None:
            for row in rows:
                key = str(row["leaf"])
                self._rows[key] = (marks[key], row)
            self.measured.emit()

        self._controller.run(self.tr("Measuring leaves"), work, done)


def _mark(leaf: Leaf, state: ScanState) -> Hashable:
    """All that the numbers of a leaf depend on, apart from deletions elsewhere."""
    parameters = state.parameters
    return (
        leaf.scan,
        Same(leaf.members),
        Same(state.scan.xyz),
        state.scan.pose,
        state.channels,
        Same(state.deleted),
        parameters.radiometry,
        parameters.radius,
        parameters.estimator,
        parameters.plane_gate,
    )
