"""How the figure of angular curves is drawn: one panel, its points, bars, curve and residuals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.units import to_degrees, to_radians
from app.services.bench.picture import INK
from app.services.lab.bins import average
from app.services.lab.figure import (
    COLOURS,
    MARKERS,
    DrawnCurve,
    FigureOrder,
    FigurePanel,
    Series,
)

MOST_DOTS = 20_000
"""Points above which their density is drawn instead."""
FEW_DOTS, RASTER = 500, 2000
"""Points up to which they are large, and from which they are an image in SVG and PDF."""
ANGLE_CELLS, VALUE_CELLS, RESIDUAL_CELLS = 180, 140, 50
STEEPEST = 90.0
STEP = 0.25
"""Degrees from one place of a drawn curve to the next."""
SINGLE, SMALL = (5.6, 4.6), (3.1, 3.0)
"""Inches of the only panel, and of one among others."""
HIGH = 0.999
"""Share of the values that the height of a panel shows."""
FAINT, DENSE = 0.35, 0.75
LARGE, SMALLER = 4.2, 3.2
ASIDE, ROOM = 0.9, 0.7
"""Degrees between the means of two series in the strip of residuals; share of a step for all."""
LEGEND: dict[str, Any] = {
    "fontsize": 7, "frameon": False, "handlelength": 2.2, "labelcolor": INK,
}  # fmt: skip


def build_figure(order: FigureOrder) -> Any:
    """A matplotlib figure without a window, on white."""
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    count = len(order.panels)
    across = min(count, 3) if count != 4 else 2
    down = math.ceil(count / across)
    wide, high = SINGLE if count == 1 else SMALL
    figure = Figure(figsize=(wide * across, high * down), layout="constrained")
    FigureCanvasAgg(figure)
    parts = figure.subfigures(down, across, squeeze=False).ravel()
    for part, panel in zip(parts, order.panels, strict=False):
        _draw_panel(part, panel, order, count == 1)
    if count > 1:
        _draw_legend(figure, parts)
    if order.note:
        figure.supxlabel(order.note, fontsize=7, color=INK, x=0.01, ha="left")
    return figure


def _draw_panel(part: Any, panel: FigurePanel, order: FigureOrder, single: bool) -> None:
    drawn = any(series.curve is not None for series in panel.series)
    if order.residuals and drawn:
        above, below = part.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    else:
        above, below = part.subplots(), None
    low, high = _find_height(panel)
    many = sum(len(series.angle) for series in panel.series) > MOST_DOTS
    dot = 1.0 if single else 0.6
    for series in panel.series:
        if many:
            _draw_density(above, series, (low, high), VALUE_CELLS)
        else:
            _draw_dots(above, series, dot)
        _draw_means(above, series, order.width)
        if series.curve is not None:
            _draw_curve(above, series, series.curve)
    if not any(len(series.angle) for series in panel.series):
        above.text(STEEPEST / 2, (low + high) / 2, "no points", color=INK, ha="center", fontsize=8)
    above.set_ylim(low, high)
    above.set_ylabel(order.y_title, fontsize=9, color=INK)
    if panel.title:
        above.set_title(panel.title, fontsize=10, color=INK, loc="left")
    if single:
        above.legend(**LEGEND)
    if below is not None:
        _draw_residuals(below, panel, order.width, many, dot)
    lowest = above if below is None else below
    lowest.set_xlabel(order.x_title, fontsize=9, color=INK)
    for axes in filter(None, (above, below)):
        _style(axes, single)


def _find_height(panel: FigurePanel) -> tuple[float, float]:
    """Values that nearly all points lie between, with zero unless all are negative."""
    value = np.concatenate([series.value for series in panel.series])
    value = value[np.isfinite(value)]
    if not len(value):
        return 0.0, 1.0
    low, high = (float(q) for q in np.quantile(value, (1 - HIGH, HIGH)))
    low = min(low, 0.0) if high > 0 else low
    room = (high - low) or abs(high) or 1.0
    return low - (0.04 * room if low < 0 else 0.0), high + 0.08 * room


def _draw_legend(figure: Any, parts: Any) -> None:
    """One legend for all panels, above them: a series has the same colour in each."""
    found: dict[str, Any] = {}
    for part in parts:
        for axes in part.axes[:1]:
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                found.setdefault(label, handle)
    figure.legend(
        found.values(), found.keys(), loc="outside upper left", ncols=min(len(found), 4), **LEGEND
    )


def _draw_dots(axes: Any, series: Series, scale: float) -> None:
    size = scale * (3.0 if len(series.value) < FEW_DOTS else 1.6)
    axes.plot(
        series.angle, series.value, _marker(series), color=_colour(series), markersize=size,
        alpha=FAINT, markeredgewidth=0, rasterized=len(series.value) > RASTER,
    )  # fmt: skip


def _draw_density(axes: Any, series: Series, height: tuple[float, float], cells: int) -> None:
    """How many points lie in small rectangles, as shades of the colour."""
    from matplotlib.colors import to_rgb

    counts, _, _ = np.histogram2d(
        series.value, series.angle, (cells, ANGLE_CELLS), (height, (0.0, STEEPEST))
    )
    picture = np.empty((*counts.shape, 4))
    picture[..., :3] = to_rgb(_colour(series))
    picture[..., 3] = DENSE * np.sqrt(counts / max(float(counts.max()), 1.0))
    axes.imshow(
        picture, extent=(0.0, STEEPEST, *height), origin="lower", aspect="auto",
        interpolation="nearest",
    )  # fmt: skip


def _colour(series: Series) -> str:
    return COLOURS[series.number % len(COLOURS)]


def _marker(series: Series) -> str:
    return MARKERS[series.number % len(MARKERS)]


def _draw_means(
    axes: Any, series: Series, width: float, aside: float = 0.0, size: float = LARGE
) -> None:
    """Means per step with bars of one standard deviation, moved `aside` by some degrees."""
    bins = average(series.angle, series.value, width)
    axes.errorbar(
        bins.angle + aside, bins.value, np.nan_to_num(bins.sd), fmt=_marker(series),
        color=_colour(series), markersize=size, markeredgecolor="white",
        markeredgewidth=0.6, elinewidth=0.9, capsize=1.8 if size == LARGE else 0.0, zorder=4,
        label=None if series.curve is not None else series.name,
    )  # fmt: skip


def _draw_curve(axes: Any, series: Series, curve: DrawnCurve) -> None:
    """Solid within the fitted angles, dashed beyond."""
    colour, (low, high) = _colour(series), curve.angle_range
    grid = np.unique(
        np.concatenate((np.arange(0.0, STEEPEST, STEP), to_degrees(curve.angle_range)))
    )
    angle = to_radians(grid)
    value = np.where(curve.model.accepts(angle), curve.model.evaluate(angle, curve.values), np.nan)
    inside: Bools = (angle >= low - 1e-12) & (angle <= high + 1e-12)
    axes.plot(grid[inside], value[inside], color=colour, linewidth=1.7, zorder=5)
    for side in (angle <= low, angle >= high):
        axes.plot(grid[side], value[side], "--", color=colour, linewidth=1.1, zorder=3, alpha=0.8)
    # For the legend alone: a symbol on the curve itself would pass for a mean.
    axes.plot(
        [], [], color=colour, linewidth=1.7, marker=_marker(series), markersize=LARGE,
        markeredgecolor="white", markeredgewidth=0.6, label=series.name,
    )  # fmt: skip


def _draw_residuals(axes: Any, panel: FigurePanel, width: float, many: bool, dot: float) -> None:
    """Value less curve of each series, with its means; the height shows nearly all of them."""
    rests = [_rest(series, series.curve) for series in panel.series if series.curve is not None]
    known = np.abs(np.concatenate([rest.value for rest in rests]))
    reach = (float(np.quantile(known, HIGH)) if len(known) else 0.0) or 1.0
    for place, rest in enumerate(rests):
        if many:
            _draw_density(axes, rest, (-reach, reach), RESIDUAL_CELLS)
        else:
            _draw_dots(axes, rest, dot)
        # Side by side, for all of them lie about zero.
        aside = min(ASIDE, ROOM * width / len(rests)) * (place - (len(rests) - 1) / 2)
        _draw_means(axes, rest, width, aside, LARGE if len(rests) == 1 else SMALLER)
    axes.axhline(0.0, color=INK, linewidth=0.8, zorder=3)
    axes.set_ylim(-1.1 * reach, 1.1 * reach)
    axes.set_ylabel("Residual", fontsize=9, color=INK)


def _rest(series: Series, curve: DrawnCurve) -> Series:
    rest = series.value - _along(series, curve)
    finite = np.isfinite(rest)
    return Series(series.name, series.angle[finite], rest[finite], None, series.number)


def _along(series: Series, curve: DrawnCurve) -> Floats:
    angle = to_radians(series.angle)
    return np.where(curve.model.accepts(angle), curve.model.evaluate(angle, curve.values), np.nan)


def _style(axes: Any, single: bool) -> None:
    axes.set_xlim(0.0, STEEPEST)
    axes.set_xticks(np.arange(0.0, STEEPEST + 1, 10.0 if single else 30.0))
    axes.grid(True, which="major", color="#e3e5e8", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
