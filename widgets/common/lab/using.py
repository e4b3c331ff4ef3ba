"""The curve that is shown, put to use: by the button, by a slider, for the map of residuals."""

from __future__ import annotations

from collections.abc import Callable
from uuid import uuid4

import numpy as np
from PySide6.QtCore import QObject

from app.core.phase.formula_model import FormulaModel
from app.core.units import to_radians
from app.model.parameters import Curve
from app.model.view_state import ColourRange
from widgets.common.curve_choice import Target
from widgets.common.curve_editor import CurveEditor
from widgets.common.known_fits import have_same_values
from widgets.common.lab.follow import CurveFollower
from widgets.controller import Controller
from widgets.leaf_work import LeafWork

RESIDUAL = "residual"
ENOUGH = 50_000
"""Points that tell the limits of the map."""


class CurveUse(QObject):
    """What one drag of a slider changes is one step of undo."""

    def __init__(
        self,
        controller: Controller,
        work: LeafWork,
        editor: CurveEditor,
        follower: CurveFollower,
        read_target: Callable[[], Target | None],
    ) -> None:
        super().__init__(editor)
        self._controller, self._work = controller, work
        self._editor, self._follower, self._read_target = editor, follower, read_target
        self._drag = uuid4().hex
        editor.released.connect(self._on_released)
        editor.rows.grabbed.connect(self.end_drag)

    @property
    def curve(self) -> Curve | None:
        """The curve in use."""
        state = self._controller.scan
        return None if state is None else state.parameters.curve

    @property
    def is_used(self) -> bool:
        """Whether the curve that is shown is the one in use."""
        curve, target = self.curve, self._read_target()
        return (
            curve is not None
            and target is not None
            and (curve.model, curve.channel) == (target.model, target.channel)
            and have_same_values(curve.values, self._editor.values)
        )

    @property
    def is_mapped(self) -> bool:
        """Whether the view shows what the curve leaves."""
        return self.is_used and self._controller.view.colour == RESIDUAL

    def end_drag(self) -> None:
        """What comes next is another step."""
        self._drag = uuid4().hex

    def use(self) -> None:
        """Put the curve that is shown to use."""
        record = self._follower.shown_record(self._read_target())
        if record is not None:
            self._work.use_fit(record)
        else:
            self._use_by_hand("")

    def map_residuals(self, wanted: bool) -> None:
        """Colour the view by what each point leaves over; the curve shown is put to use for it."""
        if wanted:
            if not self.is_used:
                self.use()
            reach = self._find_reach()
            ranges = dict(self._controller.view.ranges)
            if reach > 0.0:
                ranges[RESIDUAL] = ColourRange(-reach, reach)
            self._controller.look(colour=RESIDUAL, ranges=ranges)
            return
        state = self._controller.scan
        channels = () if state is None else state.channels
        self._controller.look(colour=channels[0].name if channels else "")

    def _find_reach(self) -> float:
        """What all but 2 % of the points shown keep within; a wall behind the leaf has no say."""
        shape, points = self._editor.shape, self._editor.points
        if shape is None or points.count == 0:
            return 0.0
        some = slice(None, None, 1 + points.count // ENOUGH)
        curve = shape.model.evaluate(to_radians(points.angle[some]), shape.values)
        miss = np.abs(points.value[some] - curve)
        return float(np.nanquantile(miss, 0.98)) if np.isfinite(miss).any() else 0.0

    def _on_released(self) -> None:
        self._use_by_hand(f"curve {self._drag}")

    def _use_by_hand(self, drag: str) -> None:
        target, shape = self._read_target(), self._editor.shape
        if target is None or shape is None:
            return
        formula = shape.model.definition if isinstance(shape.model, FormulaModel) else None
        origin = self.tr("set by hand")
        curve = Curve(target.model, dict(shape.values), target.channel, origin, formula=formula)
        self._work.use_curve(curve, drag)
