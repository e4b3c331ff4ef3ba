"""What the lab shows, as orders for files: the figure, and the fits of all targets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from app.core.fitting import FitResult
from app.core.fitting.single import AnyModel
from app.model.project import Project
from app.services.curves import result_of
from app.services.fit import FitReport, GroupFit
from app.services.lab.figure import DrawnCurve, FigureOrder, FigurePanel
from app.services.lab.figure import Series as DrawnSeries
from app.services.lab.fit_table import CHANNEL, SAMPLE
from app.services.lab.method import describe_method
from widgets.common.angular_points import STEP
from widgets.common.curve_choice import CurveChoice, Target
from widgets.common.known_fits import find_newest
from widgets.common.lab.fitting import name_samples
from widgets.common.lab.series import Series, Shape


def order_figure(
    series: Sequence[Series],
    targets: Sequence[Target],
    title: str,
    choice: CurveChoice,
    residuals: bool,
) -> FigureOrder | None:
    """The figure as it is shown; None where there is no point to draw."""
    drawn = tuple(
        DrawnSeries(
            one.title, one.points.angle, one.points.value, _draw(one, one.shape), one.number
        )
        for one in series
        if one.points.count
    )
    if not drawn:
        return None
    method = targets[0].method
    width = method.width if method.to == "bins" else STEP
    note = f"{choice.model.title}, {describe_method(method)}"
    return FigureOrder((FigurePanel("", drawn),), title, width, residuals, note)


def move_first(
    order: FigureOrder | None, series: Series, shape: Shape | None
) -> FigureOrder | None:
    """The same figure with another curve for the first series: that of the sliders."""
    if order is None or not order.panels[0].series:
        return order
    panel = order.panels[0]
    first = replace(panel.series[0], curve=_draw(series, shape))
    return replace(order, panels=(replace(panel, series=(first, *panel.series[1:])),))


def report_fits(project: Project, targets: Sequence[Target], model: AnyModel) -> FitReport | None:
    """The newest fits of all targets as a table; None where none was made."""
    groups = list(dict.fromkeys(target.leaves for target in targets))
    names = {s.leaves: s.name for s in name_samples(project, groups)}
    fits = []
    for target in targets:
        record = find_newest(project.state, target)
        result = None if record is None else result_of(record)
        if result is not None and result.angular_model == model:
            fits.append(_as_group(names[target.leaves], target.channel, model, result))
    return FitReport(tuple(fits), targets[0].method) if fits else None


def _as_group(sample: str, channel: str, model: AnyModel, result: FitResult) -> GroupFit:
    labels = {SAMPLE: sample, CHANNEL: channel}
    return GroupFit(labels, model, result.n, result, result.warnings)


def _draw(series: Series, shape: Shape | None) -> DrawnCurve | None:
    if shape is None:
        return None
    low, high = series.points.reach
    return DrawnCurve(shape.model, shape.values, (math.radians(low), math.radians(high)))
