"""What is brushed in the plot is selected in the document, and what is selected lights up."""

from __future__ import annotations

import math
from uuid import uuid4

import numpy as np
from PySide6.QtCore import QObject, QTimer

from app.core.arrays import Floats
from app.model.fields import Same
from app.model.leaf import join_members
from app.model.points import EMPTY, PointSet
from app.model.selection import Difference, Explicit, FieldRange, Intersection, Selection, Union
from widgets.common.angular_plot import AngularPlot
from widgets.common.angular_points import NO_POINTS, AngularPoints, find_lit
from widgets.common.curve_choice import Target
from widgets.common.lab.brush import Brush
from widgets.controller import Controller
from widgets.leaf_work import LeafWork

PAUSE = 100
"""Milliseconds between selections while the mouse is dragged."""
MOST_LIVE = 1_000_000
"""Points up to which the selection follows the mouse; with more it waits for the release."""


class Brushing(QObject):
    """Joins the plot's brush to the one selection of the document."""

    def __init__(self, controller: Controller, work: LeafWork, plot: AngularPlot) -> None:
        super().__init__(plot)
        self._controller, self._work, self._plot = controller, work, plot
        self._target: Target | None = None
        self._points: AngularPoints = NO_POINTS
        self._brush: Brush | None = None
        self._drag, self._before = "", EMPTY
        self._made: PointSet | None = None
        self._lit_for: object = None
        self._later = QTimer(self, singleShot=True, interval=PAUSE)
        self._later.timeout.connect(self._select)
        plot.box.brushed.connect(self._on_brushed)
        plot.cleared.connect(self.clear)

    def follow(self, target: Target | None, points: AngularPoints) -> None:
        """Take over what the plot shows, and light up what is selected of it."""
        self._target, self._points = target, points
        state = None if target is None else self._controller.project.state.scans.get(target.scan)
        selection = EMPTY if state is None else state.selection
        if self._made is not None and selection is not self._made and not self._drag:
            self._made = None
            self._plot.box.hide_brush()
        mark = (Same(selection), Same(points.measured))
        if mark == self._lit_for:
            return
        self._lit_for = mark
        some = state is not None and len(selection) and points.count
        size = len(state.scan) if state is not None else 0
        self._plot.light_up(find_lit(points, selection.indices, size) if some else None)

    def clear(self) -> None:
        """Select nothing."""
        self._later.stop()
        self._drag, self._made = "", None
        self._plot.box.hide_brush()
        state = self._controller.scan
        if state is not None and len(state.selection):
            self._work.clear_selection()

    def _on_brushed(self, brush: Brush, done: bool) -> None:
        state = self._controller.scan
        if self._target is None or state is None:
            return
        if not self._drag:
            self._drag, self._before = f"brush {uuid4().hex}", state.selection
        self._brush = brush
        if done:
            self._later.stop()
            self._select()
            self._drag = ""
        elif self._points.count <= MOST_LIVE and not self._later.isActive():
            self._later.start()

    def _select(self) -> None:
        target, brush = self._target, self._brush
        if (
            target is None
            or brush is None
            or target.scan not in self._controller.project.state.scans
        ):
            return
        covered = brush.covers(self._points.angle, self._points.value)
        points = PointSet(self._points.measured.point[covered])
        basis: Selection = self._explain(target, brush)
        if brush.combine == "add":
            points, basis = self._before | points, Union((Explicit(self._before), basis))
        elif brush.combine == "subtract":
            points, basis = self._before - points, Difference(Explicit(self._before), basis)
        self._made = points
        self._work.brush(target.scan, points, basis, self._drag)
        state = self._controller.project.state.scan(target.scan)
        self._made = state.selection  # an equal one may have been there already

    def _explain(self, target: Target, brush: Brush) -> Selection:
        """What the brush means, so that it can be found again."""
        parts: list[Selection] = [
            _limit("incidence", brush.angles, self._points.angle),
            _limit(target.channel, brush.values, self._points.value),
        ]
        if target.leaves:
            project = self._controller.project
            leaves = [project.state.leaves[key] for key in target.leaves]
            size = len(project.state.scan(target.scan).scan)
            parts.append(Explicit(PointSet(join_members(leaves, size))))
        return Intersection(tuple(parts))


def _limit(field: str, limits: tuple[float, float], values: Floats) -> FieldRange:
    """A range of a field; where the brush has no limit, that of the data: NaN is not brushed."""
    low, high = limits
    if not math.isfinite(low):
        low = float(np.min(values, initial=math.inf)) if len(values) else 0.0
    if not math.isfinite(high):
        high = float(np.max(values, initial=-math.inf)) if len(values) else 0.0
    return FieldRange(field, low, high)
