"""The clean-up of one scan as it goes on: the queue, where we are in it, and the answers."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.core.arrays import AnyArray, Floats, Ints
from app.core.progress import Progress
from app.model.fields import Same, Values
from app.model.project import Project
from app.services.cleanup.answers import Answer, Uncertain, answer_ghosts
from app.services.cleanup.apply import make_step
from app.services.cleanup.areas import AreaChange, compare_areas
from app.services.cleanup.plan import Plan, plan_cleanup
from app.services.cleanup.queue import Batch, list_batches, order_by_doubt
from app.services.cleanup.statistics import Statistics, sum_up
from widgets.common.aside import copy_aside
from widgets.common.numbers import show_count
from widgets.controller import Controller


@dataclass(frozen=True, slots=True, eq=False)
class Queue:
    """A plan in the order in which it is looked at."""

    plan: Plan
    batches: list[Batch]


class Session(QObject):
    """Answers are steps of the document; what is here can be worked out again from it.

    Signals
    -------
    changed()
        Another plan, another batch.
    moved()
        Another ghost is looked at.
    answered()
        The document holds other answers.
    measured(tuple of AreaChange)
        What the clean-up that was applied made of the areas of the leaves.
    """

    changed = Signal()
    moved = Signal()
    answered = Signal()
    measured = Signal(object)

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller
        self._asked: Hashable = None
        self._batch = ""
        self._last: int | None = None
        self.plan: Plan | None = None
        self.batches: list[Batch] = []
        self.place = -1

    # The plan

    def follow(self, known: Values | None, sure: float, uncertain: Uncertain) -> None:
        """Have a plan made where the document is not that of the present one."""
        state, scan = self._controller.scan, self._controller.current
        if known is None or state is None or scan is None:
            self.drop()
            return
        low = ~(known.values >= state.parameters.ghost_threshold)
        extra = np.flatnonzero((state.marks > 0) & low)
        leaves = tuple(Same(leaf) for leaf in self._controller.project.state.leaves_of(scan))
        mark = (scan, Same(known), Same(state.scan), Same(state.deleted), leaves, sure, uncertain,
                state.parameters.ghost_threshold, extra.tobytes())  # fmt: skip
        if mark == self._asked:
            self.answered.emit()
            return
        self._last = self.ghost
        self.drop()
        self._asked = mark

        def service(aside: Project, progress: Progress) -> Queue:
            plan = plan_cleanup(aside, scan, sure, uncertain, progress)
            return Queue(plan, list_batches(plan, order_by_doubt(plan)))

        def done(queue: Queue) -> None:
            if mark == self._asked:
                self._take(queue)

        self._controller.carry_out(scan, self.tr("Looking at ghosts"), service, done)

    def drop(self) -> None:
        """Forget the plan: its document is gone, or another one."""
        self._asked = None
        if self.plan is not None:
            self.plan, self.batches, self.place = None, [], -1
            self.changed.emit()

    def _take(self, queue: Queue) -> None:
        before = self._last
        self.plan, self.batches = queue.plan, queue.batches
        self.place = -1
        if before is not None:
            at = int(np.searchsorted(self.plan.ghosts, before))
            if at < len(self.plan) and self.plan.ghosts[at] == before:
                self.place = at
        self.changed.emit()

    # Where we are

    @property
    def ghost(self) -> int | None:
        """Number of the point that is looked at."""
        if self.plan is None or self.place < 0:
            return None
        return int(self.plan.ghosts[self.place])

    @property
    def batch(self) -> Batch | None:
        """Ghosts that are looked at one after the other."""
        named = (batch for batch in self.batches if batch.name == self._batch)
        return next(named, self.batches[0] if self.batches else None)

    @property
    def order(self) -> Ints:
        """Places of the batch in the order of the queue."""
        batch = self.batch
        return np.empty(0, np.int64) if batch is None else batch.places

    @property
    def row(self) -> int:
        """Where the ghost stands in the queue; -1 when none is looked at."""
        found = np.flatnonzero(self.order == self.place)
        return int(found[0]) if len(found) else -1

    def choose_batch(self, name: str) -> None:
        """Look at the ghosts of a leaf, or of a reason; "" is all of them."""
        self._batch = name
        self.changed.emit()

    def go(self, row: int) -> None:
        """Look at the ghost in a row of the queue."""
        if 0 <= row < len(self.order) and self.order[row] != self.place:
            self.place = int(self.order[row])
            self.moved.emit()

    def step(self, by: int) -> None:
        """Go on in the queue, or back; at its ends it stays."""
        row, size = self.row, len(self.order)
        if size:
            self.go(0 if row < 0 else min(max(row + by, 0), size - 1))

    # Answers

    @property
    def marks(self) -> AnyArray | None:
        """What the user said of each point of the scan."""
        state = self._controller.project.state
        if self.plan is None or self.plan.scan not in state.scans:
            return None
        return state.scan(self.plan.scan).marks

    def answers(self, proposals: bool = True) -> AnyArray:
        """What becomes of each ghost of the plan; 0 where it is open and no proposals count."""
        marks = self.marks
        if self.plan is None or marks is None:
            return np.empty(0, np.int8)
        return self.plan.answers(marks, proposals)

    def answer(self, answer: Answer | None, accept: bool = False) -> None:
        """Answer for the ghost that is looked at, and go on to the next open one."""
        if self.place >= 0 and self.give(np.array([self.place]), answer, accept):
            self._go_on()

    def give(
        self, places: Ints, answer: Answer | None, accept: bool = False, name: str = ""
    ) -> bool:
        """Answer for some ghosts; `accept` takes what is proposed for each. True when done."""
        if self.plan is None or not len(places):
            return False
        if answer == Answer.CORRECT:
            there = self.plan.correctable[places]
            if not there.all():
                text = self.tr("{0} of {1} ghosts have no surface to be put back on.")
                count = show_count(int((~there).sum()))
                self._controller.said.emit(text.format(count, show_count(len(places))))
            places = places[there]
            if not len(places):
                return False
        every = self.plan.proposal[places] if accept else None
        points = self.plan.ghosts[places]
        return self._controller.do(answer_ghosts(self.plan.scan, points, answer, name, every))

    def select(self, places_of: Ints) -> Ints:
        """Places of those ghosts of the plan that are among some points."""
        if self.plan is None:
            return np.empty(0, np.int64)
        return np.flatnonzero(np.isin(self.plan.ghosts, places_of))

    def _go_on(self) -> None:
        marks = self.marks
        if self.plan is None or marks is None:
            return
        order = self.order
        open_ = ~self.plan.answered(marks)[order]
        later = np.flatnonzero(open_[self.row + 1 :])
        rest = np.flatnonzero(open_)
        if len(later):
            self.go(self.row + 1 + int(later[0]))
        elif len(rest):
            self.go(int(rest[0]))

    # What comes of it

    def count(self, proposals: bool) -> Statistics | None:
        """What the answers change."""
        if self.plan is None or self.marks is None:
            return None
        state = self._controller.project.state.scan(self.plan.scan)
        return sum_up(self.plan, self.answers(proposals), state.alive)

    def apply(self, proposals: bool) -> Statistics | None:
        """Do what is answered, as one step; tell what was done, and later of the areas."""
        plan, answers, found = self.plan, self.answers(proposals), self.count(proposals)
        if plan is None:
            return None
        before = copy_aside(self._controller.project, plan.scan)
        step = make_step(before.state, plan, answers)
        if not step.steps or not self._controller.do(step):
            return None
        self._measure(before, plan, answers)
        return found

    def _measure(self, before: Project, plan: Plan, answers: AnyArray) -> None:
        if not plan.names.keys or plan.reasons is None:
            return  # no leaves, or no rows and columns to mesh them on

        def work(progress: Progress) -> tuple[AreaChange, ...]:
            return compare_areas(before, plan, answers, progress)

        self._controller.run(self.tr("Meshing leaves"), work, self.measured.emit)

    def ghost_and_scanner(self) -> tuple[Floats, Floats, float] | None:
        """Where the ghost is, where the scanner stood, and how far it is to the next surface."""
        ghost, state = self.ghost, self._controller.scan
        if ghost is None or state is None or self.plan is None:
            return None
        if self.plan.scan != self._controller.current:
            return None
        shift = float(np.nan_to_num(self.plan.shift[self.place]))
        return state.scan.xyz[ghost], state.scan.scanner("the beam of a ghost"), shift
