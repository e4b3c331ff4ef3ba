"""A map of right, missed and false calls: a part of one crown as the scanner sees it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.services.bench.ghosts.measures import judge_calls
from app.services.bench.ghosts.truth import Scene
from app.services.bench.picture import DPI, INK

MAPPED = "crown, 4 m"
SIDE = 260
"""Cells on a side of the part that is shown: the one with most ghosts."""
RIGHT, MISSED, FALSE = 1, 2, 3
KINDS = {
    RIGHT: ("found", "#2b6f5c"),
    MISSED: ("missed", "#d1495b"),
    FALSE: ("on a surface, called", "#e0a020"),
}


@dataclass(frozen=True, slots=True, eq=False)
class Map:
    """A part of a scan, and how many calls of each kind there are in all of it.

    Attributes
    ----------
    title : str
    ranges : (rows, columns) metres
        NaN where nothing came back.
    kinds : (rows, columns)
        0 or one of `KINDS`.
    counts : dict of int to int
    """

    title: str
    ranges: Floats
    kinds: Ints
    counts: dict[int, int]


def make_map(scene: Scene, called: Bools) -> Map:
    """The part of a scan with most ghosts."""
    kind = classify(scene, called)
    kinds = _lay(scene, kind, 0)
    part = find_part(np.isin(kinds, (RIGHT, MISSED)))
    f1 = judge_calls(scene, called).f1
    return Map(
        f"{scene.title}: {scene.ghost.mean():.1%} ghosts, F1 {f1:.3f}",
        _lay(scene, scene.own, np.nan)[part].copy(),
        kinds[part].copy(),
        {code: int(np.sum(kind == code)) for code in KINDS},
    )


def classify(scene: Scene, called: Bools) -> Ints:
    """0 where there is nothing to show, or one of `KINDS`, (n,)."""
    return np.select(
        [scene.ghost & called, scene.ghost & ~called, scene.good & called],
        [RIGHT, MISSED, FALSE],
    )


def draw_map(made: Map, path: Path) -> None:
    """Draw the range as grey, and the calls in colours above."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import to_rgb
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    picture = _shade(made.ranges)
    for code, (_, colour) in KINDS.items():
        picture[made.kinds == code] = to_rgb(colour)
    figure = Figure(figsize=(8.2, 8.6), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.imshow(picture, interpolation="nearest")
    axes.set_axis_off()
    axes.set_title(made.title, fontsize=10.5, color=INK, loc="left")
    patches = [
        Patch(color=colour, label=f"{words} ({made.counts[code]} in all)")
        for code, (words, colour) in KINDS.items()
    ]
    figure.legend(
        handles=patches, loc="outside lower center", ncols=3, fontsize=8.5, frameon=False,
        labelcolor=INK,
    )  # fmt: skip
    figure.savefig(path, format="png", metadata={"Software": None})


def find_part(shown: AnyArray, side: int = SIDE) -> tuple[slice, slice]:
    """Rows and columns of the square with most cells in `shown`, (rows, columns)."""
    sums = np.pad(np.cumsum(np.cumsum(shown.astype(np.int64), 0), 1), ((1, 0), (1, 0)))
    high, wide = min(side, shown.shape[0]), min(side, shown.shape[1])
    inside = sums[high:, wide:] - sums[:-high, wide:] - sums[high:, :-wide] + sums[:-high, :-wide]
    top, left = np.unravel_index(int(np.argmax(inside)), inside.shape)
    return slice(int(top), int(top) + high), slice(int(left), int(left) + wide)


def _lay(scene: Scene, values: AnyArray, empty: float) -> AnyArray:
    grid = scene.grid
    image = np.full((grid.rows, grid.columns), empty, values.dtype)
    image[grid.row, grid.column] = values
    return image


def _shade(ranges: Floats) -> Floats:
    """Greys, near is bright; white where nothing came back, (rows, columns, 3)."""
    low, high = np.nanpercentile(ranges, [2.0, 98.0]) if np.isfinite(ranges).any() else (0.0, 1.0)
    share = np.clip((ranges - low) / max(high - low, 1e-9), 0.0, 1.0)
    grey = np.where(np.isnan(ranges), 1.0, 0.9 - 0.45 * share)
    return np.repeat(grey[:, :, None], 3, axis=2)
