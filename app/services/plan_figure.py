"""The figure of a plan: the footprint against the angle, as Balduzzi's figure 7, and how steep."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from app.core.footprint import footprint_axis
from app.core.planning import BOUNDS
from app.core.units import to_mm, to_radians
from app.formats.atomic import atomic_path, refuse_target
from app.services.bench.picture import INK
from app.services.lab.figure import COLOURS, Kind, figure_kind, save_to_bytes
from app.services.plan_texts import describe_leaf, describe_tool_line, list_assumptions, tell_limits
from app.services.planning import SHARES, Plan

MOST_CURVES = 6
SIZE = (9.2, 4.4)
TOP = 1.35
"""Height of the diagram in widths of the leaf."""
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
MARKERS = {"footprint": "o", "full hits": "s", "ghosts": "^"}
LEGEND: dict[str, Any] = {"fontsize": 7, "frameon": False, "labelcolor": INK}


def draw_plan(plan: Plan, path: Path, overwrite: bool = False) -> None:
    """Write the figure as PNG (300 dots per inch), SVG or PDF, as the file's ending tells.

    Raises
    ------
    WrongUse
        Another ending.
    BadInput
        The file cannot be written.
    """
    kind = figure_kind(path)
    refuse_target(path, overwrite)
    content = plan_bytes(plan, kind)
    with atomic_path(path, overwrite) as temporary:
        temporary.write_bytes(content)


def plan_bytes(plan: Plan, kind: Kind = "png") -> bytes:
    """The content of the file that `draw_plan` writes."""
    return save_to_bytes(build_figure(plan), kind)


def build_figure(plan: Plan) -> Any:
    """A matplotlib figure without a window, on white."""
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    _draw_footprints(left, plan)
    _draw_steepest(right, plan)
    for axes in (left, right):
        _style(axes)
    title = f"{describe_tool_line(plan)}; {describe_leaf(plan)}"
    figure.suptitle(title, fontsize=9, color=INK, x=0.01, ha="left")
    note = f"{tell_limits(plan)}\n{list_assumptions(plan)[0]}"
    figure.supxlabel(note, fontsize=7, color=INK, x=0.01, ha="left")
    return figure


def choose_ranges(plan: Plan, most: int = MOST_CURVES) -> list[int]:
    """Rows of a plan that are drawn as curves: evenly among them, both ends included."""
    count = len(plan.rows)
    return sorted({int(k) for k in np.rint(np.linspace(0, count - 1, min(count, most)))})


def _draw_footprints(axes: Any, plan: Plan) -> None:
    order, beam = plan.order, plan.order.tool.beam
    low, high = min(order.angles_deg), max(order.angles_deg)
    angle = np.linspace(low, high, 400) if high > low else np.linspace(0.0, 89.0, 400)
    width = to_mm(min(order.length, order.width))
    for number, k in enumerate(choose_ranges(plan)):
        row, colour = plan.rows[k], COLOURS[number]
        axis = footprint_axis(row.range_m, to_radians(angle), beam.radius, beam.half_divergence)
        axes.plot(
            angle, to_mm(axis), linestyle=STYLES[number], color=colour, linewidth=1.6,
            label=f"{row.range_m:g} m",
        )  # fmt: skip
        if row.largest_deg is not None:
            axes.plot(row.largest_deg, row.footprint_mm, "o", color=colour, markersize=4.5,
                      markeredgecolor="white", zorder=5)  # fmt: skip
    for share in SHARES:
        axes.axhline(share * width, color=INK, linewidth=0.7, zorder=1)
        axes.annotate(
            f"{100 * share:g} % of the width" if share < 1 else f"the leaf's width, {width:.4g} mm",
            (0.01, share * width), (0, 2), xycoords=("axes fraction", "data"),
            textcoords="offset points", fontsize=7, color=INK,
        )  # fmt: skip
    axes.set_xlim(float(angle[0]), float(angle[-1]))
    axes.set_ylim(0.0, TOP * width)
    axes.set_xlabel("Incidence angle ω (°)", fontsize=9, color=INK)
    axes.set_ylabel("Footprint, major axis (mm)", fontsize=9, color=INK)
    axes.set_title("Dots: largest usable angle", fontsize=8, color=INK, loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.97), ncols=2, **LEGEND)


def _draw_steepest(axes: Any, plan: Plan) -> None:
    reached = [(r.range_m, 0.0 if r.largest_deg is None else r.largest_deg) for r in plan.rows]
    axes.plot(*zip(*reached, strict=True), "-", color="#9aa1a9", linewidth=1.0, zorder=2)
    for number, bound in enumerate(BOUNDS):
        for hollow in (False, True):
            mine = [
                place
                for row, place in zip(plan.rows, reached, strict=True)
                if row.bound == bound and (row.largest_deg is None) == hollow
            ]
            if mine:
                axes.plot(
                    *zip(*mine, strict=True), MARKERS[bound], color=COLOURS[number], markersize=5,
                    markerfacecolor="white" if hollow else COLOURS[number], zorder=3,
                    label=f"none: {bound}" if hollow else f"bound by {bound}", clip_on=False,
                )  # fmt: skip
    axes.set_ylim(0.0, 90.0)
    axes.set_yticks(range(0, 91, 15))
    axes.set_xlabel("Range (m)", fontsize=9, color=INK)
    axes.set_ylabel("Largest usable ω (°)", fontsize=9, color=INK)
    axes.legend(loc="best", **LEGEND)


def _style(axes: Any) -> None:
    axes.grid(True, which="major", color="#e3e5e8", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
