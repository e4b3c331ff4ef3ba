"""Which curve is shown: the one in use when it changes, else the newest fit, else a start."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer

from app.core.fitting import FitResult
from app.core.fitting.single import AnyModel
from app.model.fields import Same
from app.model.leaf import FitRecord
from app.services.curves import result_of
from app.services.lab.method import describe_method
from widgets.common.angular_points import AngularPoints
from widgets.common.curve_choice import CurveChoice, Target
from widgets.common.curve_editor import CurveEditor
from widgets.common.known_fits import find_newest, find_source
from widgets.common.lab.stale import is_stale
from widgets.controller import Controller

NOTHING_SEEN = (None, None, None, None)


class CurveFollower(QObject):
    """Brings the curve of the document into the editor; what a user moves there stays."""

    def __init__(self, controller: Controller, choice: CurveChoice, editor: CurveEditor) -> None:
        super().__init__(editor)
        self._controller, self._choice, self._editor = controller, choice, editor
        self._seen: tuple[object, ...] = NOTHING_SEEN
        self._record: FitRecord | None = None
        self._checked: object = None
        self._asked: tuple[Target, AngularPoints] | None = None
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._say)

    def forget(self) -> None:
        """The document is another one."""
        self._seen, self._record, self._checked = NOTHING_SEEN, None, None
        self._asked = None
        self._later.stop()

    def follow(self, read_target: Callable[[], Target | None]) -> None:
        """Show what changed last; the choice follows a curve that was put to use."""
        state, before = self._controller.scan, self._seen
        if state is None:
            return
        curve = state.parameters.curve
        turned = curve is not None and curve != before[0]
        if curve is not None and turned:
            self._choice.models.show_model(curve.angular_model)
            self._choice.show_channel(curve.channel)
        target, model = read_target(), self._choice.model
        if target is None:
            return
        record, result = self._find(target, model)
        self._seen = (curve, record, target, model)
        if self._seen == before:
            return
        fits = curve is not None and (curve.model, curve.channel) == (target.model, target.channel)
        if curve is not None and (turned or (record is None and fits)):
            source = find_source(self._controller.project.state, target.scan, curve)
            own = source is not None and source == result
            self._record = record if own else None
            method = describe_method(record.method_used) if own and record is not None else ""
            shown = curve.values if source is None else source.values
            self._editor.show_curve(model, shown, source, method)
        else:
            self._record = record
            method = "" if record is None else describe_method(record.method_used)
            values = None if result is None else result.values
            self._editor.show_curve(model, values, result, method)

    def shown_record(self, target: Target | None) -> FitRecord | None:
        """The fit that is shown, if the sliders did not move it since."""
        if target is None or self._editor.result is None:
            return None
        record, result = self._find(target, self._choice.model)
        return record if result == self._editor.result else None

    def check(self, target: Target, points: AngularPoints) -> None:
        """Say when the fit that is shown was made on other points, or in another way."""
        record, result = self._record, self._editor.result
        mark = (Same(record), Same(result), target, Same(points.measured))
        if mark == self._checked:
            return
        self._checked = mark
        self._asked = (target, points)
        if record is None or result is None:
            self._editor.say_stale("")
        else:
            self._later.start()

    def _say(self) -> None:
        """Judge when the curve is on the screen: all points are summed for it."""
        record, result = self._record, self._editor.result
        if record is not None and result is not None and self._asked is not None:
            self._editor.say_stale(self._judge(record, result, *self._asked))

    def _judge(
        self, record: FitRecord, result: FitResult, target: Target, points: AngularPoints
    ) -> str:
        if is_stale(result, record.method_used, points.measured):
            return self.tr(
                "This fit was made on other points than those shown: leaf, angles or intensities "
                "have changed since. Fit again."
            )
        if record.method_used != target.method:
            return self.tr("This fit was made on {was}; fit again for {wanted}.").format(
                was=describe_method(record.method_used), wanted=describe_method(target.method)
            )
        return ""

    def _find(self, target: Target, model: AnyModel) -> tuple[FitRecord | None, FitResult | None]:
        """The newest fit of a target; not one of a formula that was changed since."""
        record = find_newest(self._controller.project.state, target)
        result = None if record is None else result_of(record)
        if result is not None and result.angular_model != model:
            return None, None
        return record, result
