"""From fits of groups to the figure of them: samples as panels, channels as colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.services.fit import FitReport
from app.services.lab.figure import (
    ANGLE,
    MOST_SERIES,
    DrawnCurve,
    FigureOrder,
    FigurePanel,
    Series,
)
from app.services.lab.method import describe_method
from app.services.lab.orders import PairGroup

ALL = "all"
BARS = "bars: standard deviation of a value per {width:g}° step"


def order_figure(
    groups: Sequence[PairGroup], report: FitReport, y_title: str, x_title: str = ANGLE
) -> FigureOrder:
    """The figure of groups with the curves of their fits, as far as there are fits.

    With several labels the last one tells the colour and the others the panel; with one there is
    one panel, or where that would be crowded one for each group.

    Parameters
    ----------
    groups : sequence of PairGroup
    report : FitReport
        Of the same groups in the same order, or of none.
    y_title, x_title : str
    """
    names = list(groups[0].labels) if groups else []
    crowded = len(names) == 1 and len(groups) > MOST_SERIES
    down = names if crowded else names[:-1]
    across = names[-1:] if not crowded else []
    colours = list(dict.fromkeys(_join(group, across) for group in groups))
    panels: dict[str, list[Series]] = {}
    for place, group in enumerate(groups):
        result = report.fits[place].result if report.fits else None
        label = _join(group, across)
        known = np.isfinite(group.angle) & np.isfinite(group.value)
        panels.setdefault(_join(group, down, ""), []).append(
            Series(
                label,
                group.angle[known],
                group.value[known],
                None if result is None else DrawnCurve.of(result),
                colours.index(label),
            )
        )
    return FigureOrder(
        tuple(FigurePanel(title, tuple(series)) for title, series in panels.items()),
        y_title,
        report.method.width,
        note=describe_figure(report),
        x_title=x_title,
    )


def describe_figure(report: FitReport) -> str:
    """The line below a figure: the model, how it was fitted, and what the bars are."""
    bars = BARS.format(width=report.method.width)
    if not report.fits:
        return bars.capitalize()
    return f"{report.fits[0].model.title}, fitted to {describe_method(report.method)}; {bars}"


def _join(group: PairGroup, names: Sequence[str], none: str = ALL) -> str:
    return ", ".join(_tell(name, group.labels[name]) for name in names) or none


def _tell(name: str, value: str) -> str:
    """A bare number says little: ``channel 3``."""
    return f"{name} {value}" if value.replace(".", "").isdecimal() else value
