"""Pictures: time against error, and precision against recall, scene by scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from app.services.bench.ghosts.compare import Outcome, Result
from app.services.bench.picture import COLOURS, DPI, INK, Dots, Scatter, draw_scatters
from app.services.bench.scatter import RIVALS

WIDTH, HEIGHT, LEGEND = 4.6, 3.7, 0.5
"""Inches of one panel, and of the legend below all."""
ACROSS = 3
LEAST = 1e-3
"""1 − F1 below which dots are not told apart."""
LOWEST = 0.4
"""Recall and precision from which they are drawn."""


def draw_costs(outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw 1 − F1 against seconds: ours at its default, peers at the best of all settings."""
    panels = [
        Scatter(
            _title(outcome),
            "seconds (peers at their best setting here)",
            "1 − F1",
            tuple(_list_dots(outcome)),
        )
        for outcome in outcomes
    ]
    draw_scatters(panels, path, ACROSS)


def _title(outcome: Outcome) -> str:
    facts = outcome.facts
    return f"{facts.title}, {facts.points / 1e6:.2g} million: {facts.ghosts:.1%} ghosts"


def _list_dots(outcome: Outcome) -> Iterator[Dots]:
    ours = outcome.ours
    yield Dots(ours.family, [ours.seconds], [_error(ours.usual.f1)], ["default"], [True])
    for family, results in groupby(outcome.rivals, lambda result: result.family):
        some = sorted(results, key=lambda result: result.seconds)
        yield Dots(
            family,
            [one.seconds for one in some],
            [_error(one.best.f1) for one in some],
            ["" for _ in some],
            [False for _ in some],
            rival=True,
        )


def _error(f1: float) -> float:
    return max(1.0 - f1, LEAST)


def draw_curves(outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw precision against recall; ours, and of each family of peers its best variant.

    Large dots are usual settings: what one gets without knowing the truth.
    """
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    down = -(-len(outcomes) // ACROSS)
    size = (WIDTH * ACROSS, HEIGHT * down + LEGEND)
    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    places = list(figure.subplots(down, ACROSS, squeeze=False).ravel())
    for axes, outcome in zip(places, outcomes, strict=False):
        _draw_panel(axes, outcome)
    for axes in places[len(outcomes) :]:
        axes.set_axis_off()
    handles, names = places[0].get_legend_handles_labels()
    figure.legend(
        handles, names, loc="outside lower center", ncols=len(names), fontsize=8.5, frameon=False,
        labelcolor=INK,
    )  # fmt: skip
    figure.savefig(path, format="png", metadata={"Software": None})


def _draw_panel(axes: Any, outcome: Outcome) -> None:
    _draw_levels(axes)
    for place, result in enumerate(_choose(outcome)):
        colour = COLOURS[0] if result.is_ours else RIVALS[(place - 1) % len(RIVALS)]
        axes.plot(
            result.curve.recall, result.curve.precision, color=colour, label=result.family,
            linewidth=2.2 if result.is_ours else 1.2, zorder=3 if result.is_ours else 2,
        )  # fmt: skip
        recall, precision = result.usual.recall, result.usual.precision
        if min(recall, precision) >= LOWEST:  # the others have no place in the picture
            axes.plot(
                recall, precision, marker="o" if result.is_ours else "s", color=colour,
                markersize=8 if result.is_ours else 6, clip_on=False, zorder=4,
            )  # fmt: skip
    axes.set_xlim(LOWEST, 1.0)
    axes.set_ylim(LOWEST, 1.0)
    axes.set_title(outcome.facts.title, fontsize=10, color=INK, loc="left")
    axes.set_xlabel("recall: ghosts found (dots: usual setting)", fontsize=9, color=INK)
    axes.set_ylabel("precision: calls that are right", fontsize=9, color=INK)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _draw_levels(axes: Any) -> None:
    """Lines of equal F1."""
    recall = np.linspace(LOWEST, 1.0, 200)
    for f1 in (0.6, 0.7, 0.8, 0.9, 0.95, 0.98):
        with np.errstate(divide="ignore"):
            precision = f1 * recall / (2.0 * recall - f1)
        shown = (precision > LOWEST) & (precision <= 1.0)
        axes.plot(recall[shown], precision[shown], color="#d9dcdf", linewidth=0.8, zorder=0)
        axes.text(
            1.0, f1 / (2.0 - f1), f" {f1:g}", fontsize=7, color="#8a9096", va="center",
            clip_on=False,
        )  # fmt: skip


def _choose(outcome: Outcome) -> Iterator[Result]:
    """Ours, and the best variant of each family at its best setting."""
    yield outcome.ours
    for _, results in groupby(outcome.rivals, lambda result: result.family):
        yield max(results, key=lambda result: result.best.f1)
