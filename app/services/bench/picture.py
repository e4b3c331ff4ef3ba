"""Pictures of benches, all in one style."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from app.core.errors import WrongUse

COLOURS = ("#2b6f5c", "#c9772f", "#4a6fb0", "#8a4f8f", "#7a7a3a")
INK = "#2b2f33"
DPI = 110
WIDTH, HEIGHT = 4.6, 3.4
"""Inches of one panel."""

Scale = Literal["linear", "log"]


@dataclass(frozen=True, slots=True)
class Curve:
    """One line of a panel; `dashed` for a rival or a limit."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Panel:
    """One diagram."""

    title: str
    x_name: str
    y_name: str
    curves: Sequence[Curve]
    x_scale: Scale = "linear"
    y_scale: Scale = "linear"


@dataclass(frozen=True, slots=True)
class Dots:
    """Points of one maker, joined in their order; hollow squares for a rival.

    `texts` stand beside the dots; those of `strong` are larger.
    """

    name: str
    x: Sequence[float]
    y: Sequence[float]
    texts: Sequence[str]
    strong: Sequence[bool]
    rival: bool = False


@dataclass(frozen=True, slots=True)
class Scatter:
    """A diagram of two costs, both on log axes; the lower left is best.

    The Pareto front, what no other dot beats in one cost and equals in the other, is marked.
    """

    title: str
    x_name: str
    y_name: str
    dots: Sequence[Dots]


def draw_panels(panels: Sequence[Panel], path: Path) -> None:
    """Draw panels side by side into a PNG file.

    Raises
    ------
    WrongUse
        There is no panel.
    """
    if not panels:
        raise WrongUse("A picture without a panel cannot be drawn.")
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH * len(panels), HEIGHT), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw(axes, panel)
    figure.savefig(path, format="png", metadata={"Software": None})


def _draw(axes: Any, panel: Panel) -> None:
    for colour, curve in zip(_cycle(len(panel.curves)), panel.curves, strict=True):
        axes.plot(
            curve.x,
            curve.y,
            color=colour,
            linestyle="--" if curve.dashed else "-",
            marker=None if curve.dashed and len(curve.x) > 20 else "o",
            markersize=3.5,
            linewidth=1.6,
            label=curve.name,
        )
    axes.set_title(panel.title, fontsize=10, color=INK, loc="left")
    axes.set_xlabel(panel.x_name, fontsize=9, color=INK)
    axes.set_ylabel(panel.y_name, fontsize=9, color=INK)
    axes.set_xscale(panel.x_scale)
    axes.set_yscale(panel.y_scale)
    for axis, scale in ((axes.xaxis, panel.x_scale), (axes.yaxis, panel.y_scale)):
        if scale == "log":
            number_axis(axis)
    if panel.y_scale == "linear" and min(min(curve.y) for curve in panel.curves) >= 0:
        axes.set_ylim(bottom=0)
    axes.grid(True, which="major", color="#d9dcdf", linewidth=0.6)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if len(panel.curves) > 1:
        axes.legend(fontsize=8, frameon=False)


def number_axis(axis: Any) -> None:
    """Plain numbers at 1, 2 and 5 of each decade, or at 1 alone where there are many."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 1000 * low else (1.0,)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def draw_scatters(panels: Sequence[Scatter], path: Path, across: int = 2) -> None:
    """Draw scatter diagrams in rows of `across` into a PNG file, with one legend for all.

    Raises
    ------
    WrongUse
        There is no panel.
    """
    from app.services.bench.scatter import draw_figure

    if not panels:
        raise WrongUse("A picture without a panel cannot be drawn.")
    draw_figure(panels, across).savefig(path, format="png", metadata={"Software": None})


def _cycle(count: int) -> list[str]:
    return [COLOURS[k % len(COLOURS)] for k in range(count)]
