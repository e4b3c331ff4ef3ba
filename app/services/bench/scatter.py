"""Scatter diagrams: dots with texts that keep clear of each other, and the Pareto front."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np

from app.core.arrays import Bools, Floats
from app.services.bench.picture import COLOURS, DPI, INK, Dots, Scatter

WIDTH, HEIGHT, LEGEND = 5.8, 4.4, 0.55
"""Inches of one panel, and of the legend below all."""
RIVALS = ("#b3452f", "#d98a4e", "#8d5a2b", "#5b5f63", "#a9adb1")
FRONT = "#d7e6c8"
DIRECTIONS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
DISTANCES = (5.0, 8.0, 12.0, 17.0)
"""Points of type between a dot and its text; nearer is tried first."""
ROOM = 1.6
"""Factor by which the axes reach beyond the dots."""


def find_front(x: Floats, y: Floats) -> Bools:
    """Dots that no other beats in one cost and at least equals in the other."""
    with np.errstate(invalid="ignore"):
        no_worse = (x[:, None] <= x) & (y[:, None] <= y)
        better = (x[:, None] < x) | (y[:, None] < y)
    beaten = (no_worse & better).any(axis=0)
    return np.asarray(~beaten & np.isfinite(x) & np.isfinite(y))


def draw_figure(panels: Sequence[Scatter], across: int) -> Any:
    """The figure of all panels, ready to be saved."""
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    down = -(-len(panels) // across)
    size = (WIDTH * across, HEIGHT * down + LEGEND)
    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    places = list(figure.subplots(down, across, squeeze=False).ravel())
    colours = _choose_colours(panels)
    for axes, panel in zip(places, panels, strict=False):
        _draw(axes, panel, colours)
    for axes in places[len(panels) :]:
        axes.set_axis_off()
    _explain(figure, places[: len(panels)])
    for _ in range(2):  # the axes make room for the legend first, which moves the dots
        figure.draw_without_rendering()
    figure.set_layout_engine("none")  # the texts that come now must not move them again
    for axes, panel in zip(places, panels, strict=False):
        _place_texts(axes, panel, colours)
    return figure


def _choose_colours(panels: Sequence[Scatter]) -> dict[str, str]:
    """A colour by name, the same in all panels; rivals have colours of their own."""
    chosen: dict[str, str] = {}
    for rival, palette in ((False, COLOURS), (True, RIVALS)):
        names = dict.fromkeys(d.name for p in panels for d in p.dots if d.rival == rival)
        chosen |= {name: palette[k % len(palette)] for k, name in enumerate(names)}
    return chosen


def _draw(axes: Any, panel: Scatter, colours: dict[str, str]) -> None:
    from app.services.bench.picture import number_axis

    _draw_front(axes, panel)
    for dots in panel.dots:
        colour = colours[dots.name]
        axes.plot(dots.x, dots.y, color=colour, linewidth=1.0, alpha=0.45, zorder=2)
        axes.scatter(
            dots.x,
            dots.y,
            s=[64.0 if strong else 26.0 for strong in dots.strong],
            marker="s" if dots.rival else "o",
            facecolor="white" if dots.rival else colour,
            edgecolor=colour,
            linewidth=1.5,
            zorder=3,
            label=dots.name,
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    x, y = _gather(panel.dots)
    axes.set_xlim(x.min() / ROOM, x.max() * ROOM)
    spare = ROOM ** (np.log(y.max() / y.min() + 1.0) / 2.0)
    axes.set_ylim(y.min() / spare, y.max() * spare)
    for axis in (axes.xaxis, axes.yaxis):
        number_axis(axis)
    axes.set_title(panel.title, fontsize=10.5, color=INK, loc="left")
    axes.set_xlabel(panel.x_name, fontsize=9, color=INK)
    axes.set_ylabel(panel.y_name, fontsize=9, color=INK)
    axes.grid(True, which="major", color="#e3e6e8", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _gather(dots: Sequence[Dots]) -> tuple[Floats, Floats]:
    x = np.array([value for each in dots for value in each.x])
    y = np.array([value for each in dots for value in each.y])
    return x, y


def _draw_front(axes: Any, panel: Scatter) -> None:
    """A broad stair through the dots of the front, from the least time to the least error."""
    x, y = _gather(panel.dots)
    on = find_front(x, y)
    order = np.argsort(x[on], kind="stable")
    far_x, far_y = x.max() * ROOM**2, y.max() * ROOM**2
    stair_x = np.concatenate([x[on][order][:1], x[on][order], [far_x]])
    stair_y = np.concatenate([[far_y], y[on][order], y[on][order][-1:]])
    axes.step(
        stair_x, stair_y, where="post", color=FRONT, linewidth=7, zorder=1,
        solid_joinstyle="round", label="Pareto front",
    )  # fmt: skip


def _explain(figure: Any, places: Sequence[Any]) -> None:
    """One legend for all panels, the front first."""
    known: dict[str, Any] = {}
    for axes in places:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            known.setdefault(name, handle)
    figure.legend(
        known.values(), known.keys(), loc="outside lower center", ncols=min(len(known), 5),
        fontsize=8.5, frameon=False, labelcolor=INK,
    )  # fmt: skip


Box = tuple[float, float, float, float]


def _place_texts(axes: Any, panel: Scatter, colours: dict[str, str]) -> None:
    """Put each text where it covers no dot and no other text, as near its dot as can be."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    pixel = axes.figure.dpi / 72.0
    taken = [_dot_box(axes, at, 5.0 * pixel) for at in zip(*_gather(panel.dots), strict=True)]
    window = axes.get_window_extent()
    inside: Box = (window.x0, window.y0, window.x1, window.y1)
    for dots in panel.dots:
        for x, y, text, strong in zip(dots.x, dots.y, dots.texts, dots.strong, strict=True):
            if not text:
                continue
            font = FontProperties(size=9.0 if strong else 7.5, weight="bold" if strong else None)
            extent = TextPath((0, 0), text, prop=font).get_extents()
            size = (extent.width * pixel + 2, extent.height * pixel + 2)
            centre, box = _find_place(axes.transData.transform((x, y)), size, taken, inside, pixel)
            taken.append(box)
            axes.text(
                *axes.transData.inverted().transform(centre), text, fontproperties=font,
                color=colours[dots.name], ha="center", va="center", zorder=4,
            )  # fmt: skip


def _dot_box(axes: Any, at: tuple[float, float], half: float) -> Box:
    x, y = axes.transData.transform(at)
    return x - half, y - half, x + half, y + half


def _find_place(
    at: Floats, size: tuple[float, float], taken: Sequence[Box], inside: Box, pixel: float
) -> tuple[tuple[float, float], Box]:
    """The place around a dot that covers least, the first of those alike."""
    tried: list[tuple[int, int, tuple[float, float], Box]] = []
    for (right, up), distance in _try_places():
        x = at[0] + right * (distance * pixel + size[0] / 2)
        y = at[1] + up * (distance * pixel + size[1] / 2)
        box = (x - size[0] / 2, y - size[1] / 2, x + size[0] / 2, y + size[1] / 2)
        covered = sum(_overlap(box, other) for other in taken)
        covered += size[0] * size[1] - _overlap(box, inside)
        tried.append((round(covered), len(tried), (x, y), box))
    _, _, centre, box = min(tried)
    return centre, box


def _try_places() -> Iterator[tuple[tuple[int, int], float]]:
    for distance, direction in product(DISTANCES, DIRECTIONS):
        yield direction, distance


def _overlap(a: Box, b: Box) -> float:
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    return max(width, 0.0) * max(height, 0.0)
