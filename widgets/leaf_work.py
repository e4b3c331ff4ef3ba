"""What the lasso and the panels do with leaves, ghosts and curves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import msgspec
import numpy as np
from PySide6.QtCore import QObject, Signal

from app.core.arrays import Ints
from app.core.progress import Progress
from app.core.screen import LassoResult, View, select_in_lasso
from app.model.leaf import FitRecord, Leaf
from app.model.operations import MarkGhosts, PutLeaf, Select, SetDeleted, SetParameters, Several
from app.model.parameters import Curve
from app.model.points import EMPTY, PointSet
from app.model.project import Project
from app.model.selection import Difference, Explicit, Lasso, LassoMode, Selection, Union
from app.model.state import next_leaf_key
from app.services.cleaning import correct_ghosts, delete_ghosts, mark_ghosts
from app.services.curves import fit_leaves, members_of, use_curve, use_fit
from app.services.leaf_edits import merge_leaves, split_leaf
from app.services.leaves import find_leaves, key_number
from widgets.controller import Controller

Purpose = Literal["select", "leaf", "ghost", "delete"]
Combine = Literal["replace", "add", "subtract"]
Service = Callable[[Project, str, Progress], object]


class LeafWork(QObject):
    """Selections become leaves, ghosts or deletions; leaves get fits and curves.

    Signals
    -------
    fitted(FitRecord)
    """

    fitted = Signal(object)

    def __init__(self, controller: Controller) -> None:
        super().__init__(controller)
        self._controller = controller

    def lasso(
        self,
        view: View,
        polygon: Sequence[tuple[float, float]],
        mode: LassoMode,
        purpose: Purpose,
        combine: Combine = "replace",
    ) -> None:
        """Find the points in a contour, on all points, and do with them what the tool is for."""
        controller, key, state = self._controller, self._controller.current, self._controller.scan
        if key is None or state is None:
            controller.said.emit("Open a scan first.")
            return
        corners = tuple((float(x), float(y)) for x, y in polygon)

        def work(progress: Progress) -> LassoResult:
            progress.report(0.1, "Selecting")
            return select_in_lasso(state.scan.xyz, state.alive, view, np.array(corners), mode)

        def done(found: LassoResult) -> None:
            controller.said.emit(found.describe())
            basis = Lasso(view, corners, mode, found.tolerance)
            self.apply(key, PointSet(found.indices), basis, purpose, combine)

        controller.run("Selecting", work, done)

    def apply(
        self,
        scan: str,
        points: PointSet,
        basis: Selection,
        purpose: Purpose,
        combine: Combine = "replace",
    ) -> None:
        """Do with points what a tool is for; an empty set changes nothing."""
        if len(points) == 0 or scan not in self._controller.project.state.scans:
            return
        if purpose == "leaf":
            self._extend_leaf(scan, points, basis, combine)
        elif purpose == "ghost":
            taken = combine == "subtract"
            self._controller.do(
                MarkGhosts(scan, cleared=points, basis=basis)
                if taken
                else MarkGhosts(scan, ghosts=points, basis=basis)
            )
        elif purpose == "delete":
            self._controller.do(SetDeleted(scan, points, combine != "subtract", basis))
        else:
            self._select(scan, points, basis, combine)

    def brush(self, scan: str, points: PointSet, basis: Selection, drag: str = "") -> None:
        """Select what a brush in a plot covers; the steps of one drag are one step of undo.

        Unlike a lasso, a brush over nothing selects nothing. Where the selection is the same
        already, nothing is done.
        """
        state = self._controller.project.state.scans.get(scan)
        if state is not None and not state.closed and state.selection != points:
            self._controller.do(Select(scan, points, basis, drag))

    def _select(self, scan: str, points: PointSet, basis: Selection, combine: Combine) -> None:
        old = self._controller.project.state.scan(scan).selection
        if combine == "add":
            points, basis = old | points, Union((Explicit(old), basis))
        elif combine == "subtract":
            points, basis = old - points, Difference(Explicit(old), basis)
        self._controller.do(Select(scan, points, basis))

    def _extend_leaf(self, scan: str, points: PointSet, basis: Selection, combine: Combine) -> None:
        leaves = self._controller.project.state.leaves
        current = leaves.get(self._controller.view.leaf or "")
        if combine == "replace" or current is None or current.scan != scan:
            self.make_leaf(scan, points, basis)
        elif combine == "add":
            self._put(current, current.members | points, (*current.basis, basis), "Extend")
        else:
            kept = current.members - points
            less = Difference(Explicit(current.members), basis)
            self._put(current, kept, (less,), "Cut")

    def make_leaf(self, scan: str, points: PointSet, basis: Selection) -> None:
        """Make a leaf of points and let panels work on it."""
        key = next_leaf_key(self._controller.project.state)
        leaf = Leaf(key, scan, f"Leaf {key_number(key)}", points, (basis,))
        if self._controller.do(PutLeaf(key, leaf)):
            self._controller.look(leaf=key)

    def rename(self, key: str, name: str) -> None:
        """Give a leaf another name."""
        leaf = self._controller.project.state.leaves[key]
        if name and name != leaf.name:
            self._controller.do(PutLeaf(key, msgspec.structs.replace(leaf, name=name), "Rename"))

    def merge(self, keys: Sequence[str]) -> None:
        """Make one leaf of several: the first keeps its name."""
        self._controller.attempt(lambda: merge_leaves(self._controller.project, keys))

    def split(self, key: str, seeds: Sequence[PointSet]) -> None:
        """Make a leaf around each group of seeds; the first keeps its name."""
        leaf = self._controller.project.state.leaves[key]

        def service(aside: Project, progress: Progress) -> list[str]:
            return split_leaf(aside, key, seeds, progress)

        self._controller.carry_out(leaf.scan, f"Splitting {leaf.name}", service, self._tell_split)

    def _tell_split(self, keys: list[str]) -> None:
        self._controller.said.emit(f"{len(keys)} leaves made of one.")

    def remove(self, keys: Sequence[str]) -> None:
        """Remove leaves; their points stay."""
        steps = tuple(PutLeaf(key, None) for key in keys)
        if len(steps) == 1:
            self._controller.do(steps[0])
        elif steps:
            self._controller.do(Several(f"Remove {len(steps)} leaves", steps))

    def clear_selection(self) -> None:
        """Select nothing."""
        if self._controller.current is not None:
            self._controller.do(Select(self._controller.current, EMPTY))

    def find_all(self) -> None:
        """Segment the current scan into leaves."""
        state = self._controller.scan
        # Without a position there are no ghosts to leave out, but there are leaves.
        needed = "ghost" if state is not None and state.scan.pose is not None else None
        self._carry_out("Finding leaves", needed, find_leaves, self._tell_found)

    def _tell_found(self, keys: list[str]) -> None:
        self._controller.said.emit(f"{len(keys)} leaves found.")

    def fit(self, keys: Sequence[str], model: str, channel: str) -> None:
        """Fit a model to leaves (none: the whole scan); the fit is kept as a step."""
        scan = self._controller.current
        if scan is None:
            return
        controller, project = self._controller, self._controller.project
        points: list[Ints | None] = []
        if not controller.attempt(lambda: points.append(members_of(project, scan, keys))):
            return

        def service(aside: Project, progress: Progress) -> FitRecord:
            return fit_leaves(aside, scan, keys, model, channel, progress)

        def then() -> None:
            controller.carry_out(scan, "Fitting", service, self.fitted.emit)

        controller.want(scan, "incidence", points[0], then)

    def use_fit(self, record: FitRecord) -> None:
        """Make a fit the curve in use."""
        self._controller.attempt(lambda: use_fit(self._controller.project, record))

    def use_curve(self, curve: Curve, drag: str = "") -> None:
        """Put a curve to use; the steps of one slider drag share the word `drag`."""
        key = self._controller.current
        if key is not None:
            self._controller.attempt(lambda: use_curve(self._controller.project, key, curve, drag))

    def set_parameters(self, drag: str = "", **changes: object) -> None:
        """Change parameters of the current scan, e.g. ``set_parameters(radius=0.006)``."""
        key, state = self._controller.current, self._controller.scan
        if key is not None and state is not None:
            self._controller.attempt(
                lambda: self._controller.project.do(
                    SetParameters(key, msgspec.structs.replace(state.parameters, **changes), drag)
                )
            )

    def mark_ghosts(self) -> None:
        """Mark what the threshold calls ghosts."""
        self._carry_out("Marking ghosts", "ghost", mark_ghosts)

    def delete_ghosts(self) -> None:
        """Delete what counts as ghosts."""
        self._carry_out("Deleting ghosts", "ghost", delete_ghosts)

    def correct_ghosts(self) -> None:
        """Put ghosts back on their surface."""
        self._carry_out("Correcting ghosts", "ghost", correct_ghosts)

    def _put(self, leaf: Leaf, members: PointSet, basis: tuple[Selection, ...], verb: str) -> None:
        changed = msgspec.structs.replace(leaf, members=members, basis=basis)
        self._controller.do(PutLeaf(leaf.key, changed, verb))

    def _carry_out(
        self,
        title: str,
        field: str | None,
        service: Service,
        done: Callable[[Any], object] = lambda _: None,
    ) -> None:
        # The field is asked for first, so that the document keeps it.
        controller, key = self._controller, self._controller.current
        if key is None:
            return

        def then() -> None:
            controller.carry_out(
                key, title, lambda aside, progress: service(aside, key, progress), done
            )

        if field is None:
            then()
        else:
            controller.want(key, field, None, then)
