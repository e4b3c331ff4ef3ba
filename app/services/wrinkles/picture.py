"""Leaves in Δω as Balduzzi's figure 9 shows them: scanner view, side view, distribution."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput, WrongUse
from app.core.units import to_degrees, to_mm
from app.core.wrinkles import SIGN_OF_DELTA
from app.core.wrinkling.leaf import JudgedLeaf, LeafPoints
from app.formats.atomic import atomic_path
from app.render.palettes import colour_table
from app.services.bench.picture import DPI, INK
from app.services.wrinkles.measure import LeafWrinkles

MOST_LEAVES = 6
SIZE = (11.0, 2.7)
"""Inches of the row of one leaf."""
MARGIN = 1.1
FORMATS = (".png", ".svg", ".pdf")
FAINT = "#c9ced3"
WIDEST, NARROWEST = 60.0, 5.0
"""Degrees of Δω at the ends of the colours."""
NEAR = 0.03
"""Metres from its plane within which a leaf bends; ghosts lie beyond."""


def picture_kind(path: Path) -> str:
    """Format of a picture by the ending of its file; raises `WrongUse` for another."""
    if path.suffix.lower() not in FORMATS:
        raise WrongUse(f"A picture ends with {', '.join(FORMATS)}, not {path.suffix!r}.")
    return path.suffix[1:].lower()


def draw_leaves(leaves: Sequence[LeafWrinkles], path: Path, overwrite: bool = False) -> None:
    """Draw the leaves with most valid points, a row each, six at most.

    Points without a valid angle are grey.

    Raises
    ------
    BadInput
        No leaf has a valid angle, or the file cannot be written.
    """
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    kind = picture_kind(path)
    chosen = choose_leaves(leaves)
    if not chosen:
        raise BadInput("No leaf has a valid angle from intensity: there is nothing to draw.")
    size = (SIZE[0], SIZE[1] * len(chosen) + MARGIN)
    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    limit = find_limit([judged for _, judged in chosen])
    grid = figure.subplots(len(chosen), 3, squeeze=False, width_ratios=(1.0, 1.0, 1.9))
    for row, (leaf, judged) in zip(grid, chosen, strict=True):
        _draw_row(row, leaf, judged, limit)
    _explain(figure, grid, chosen[0][0], limit)
    with atomic_path(path, overwrite) as temporary:
        figure.savefig(temporary, format=kind)


def choose_leaves(leaves: Sequence[LeafWrinkles]) -> list[tuple[LeafWrinkles, JudgedLeaf]]:
    """Those with most valid points, in the order of the scan."""
    known = [(leaf, leaf.judged) for leaf in leaves if leaf.judged and leaf.judged.spread]
    largest = sorted(known, key=_count_valid, reverse=True)[:MOST_LEAVES]
    kept = {leaf.leaf.key for leaf, _ in largest}
    return [pair for pair in known if pair[0].leaf.key in kept][:MOST_LEAVES]


def _count_valid(pair: tuple[LeafWrinkles, JudgedLeaf]) -> int:
    return int(pair[1].angles.valid.sum())


def find_limit(leaves: Sequence[JudgedLeaf]) -> float:
    """Δω at the ends of the colours, degrees: 98 % of the valid points lie within."""
    values = np.concatenate([np.abs(leaf.delta[leaf.angles.valid]) for leaf in leaves])
    wide = float(to_degrees(np.quantile(values, 0.98)))
    return float(np.clip(np.ceil(wide / 5.0) * 5.0, NARROWEST, WIDEST))


def _draw_row(axes: Any, found: LeafWrinkles, judged: JudgedLeaf, limit: float) -> None:
    measured = found.measured
    size = float(np.clip(9000.0 / max(len(found.points), 1), 1.0, 16.0))
    for place, (x, y), names in (
        (axes[0], see_from_scanner(measured), ("mm to the right", "mm up")),
        (axes[1], see_from_side(measured, judged), ("mm along the beam", "mm along the tilt")),
    ):
        valid = judged.angles.valid
        place.scatter(x[~valid], y[~valid], s=size, color=FAINT, linewidths=0, rasterized=True)
        place.scatter(
            x[valid], y[valid], c=to_degrees(judged.delta[valid]), s=size, linewidths=0,
            vmin=-limit, vmax=limit, cmap=_colours(), rasterized=True,
        )  # fmt: skip
        framed = choose_framed(measured, judged)
        _frame(place, x[framed], y[framed])
        _label(place, *names)
    _draw_plane(axes[1], measured, judged)
    axes[0].set_title(
        f"{found.leaf.name}, ω of the plane {to_degrees(judged.plane.incidence):.1f}°",
        fontsize=9, color=INK, loc="left",
    )  # fmt: skip
    axes[1].set_title("from the side; line: plane", fontsize=9, color=INK, loc="left")
    _draw_spread(axes[2], judged, limit)


def _frame(axes: Any, x: Floats, y: Floats) -> None:
    left, low, side = frame_leaf(x, y)
    axes.set_xlim(left, left + side)
    axes.set_ylim(low, low + side)
    axes.set_aspect("equal", adjustable="box")


def choose_framed(measured: LeafPoints, judged: JudgedLeaf) -> Bools:
    """Points that a picture is made to hold: valid ones that are near the plane, or those near."""
    away = np.abs((measured.xyz - judged.plane.point) @ judged.plane.normal)
    near: Bools = away <= max(NEAR, float(np.nanmin(away)))
    chosen = near & judged.angles.valid
    return chosen if chosen.any() else near


def frame_leaf(x: Floats, y: Floats) -> tuple[float, float, float]:
    """A square about a leaf, mm: left, low and side; a few ghosts far off fall outside."""
    ends = [np.quantile(values, (0.02, 0.98)) for values in (x, y)]
    half = 0.62 * max(float(high - low) for low, high in ends) + 1.0
    return float(ends[0].mean()) - half, float(ends[1].mean()) - half, 2.0 * half


def _draw_spread(axes: Any, judged: JudgedLeaf, limit: float) -> None:
    spread = judged.spread
    if spread is None:
        return
    edges = to_degrees(spread.edges)
    middles = (edges[:-1] + edges[1:]) / 2
    shade = _colours()(np.clip((middles + limit) / (2 * limit), 0.0, 1.0))
    axes.bar(middles, 100 * spread.fraction, width=1.0, color=shade)
    axes.plot(middles, 100 * spread.smooth, color=INK, linewidth=1.2)
    axes.axvline(0.0, color=INK, linewidth=0.6, linestyle=":")
    axes.set_xlim(-1.3 * limit, 1.3 * limit)
    _label(axes, "Δω, °", "% of points per °")
    axes.set_title(tell_index(judged), fontsize=9, color=INK, loc="left")


def tell_index(judged: JudgedLeaf) -> str:
    """Shape and wrinkle index of a leaf, in a line."""
    index = judged.index
    if index is None:
        return judged.shape
    value, low, high = (to_degrees(angle) for angle in (index.value, index.low, index.high))
    return f"{judged.shape}; wrinkle index {value:.1f}° ({low:.1f} to {high:.1f})"


def _explain(figure: Any, grid: Any, first: LeafWrinkles, limit: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    colours = ScalarMappable(Normalize(-limit, limit), _colours())
    bar = figure.colorbar(
        colours, ax=list(grid.ravel()), location="bottom", aspect=60, fraction=0.03, pad=0.01
    )
    bar.ax.tick_params(labelsize=8, colors=INK)
    bar.set_label("Δω, °", fontsize=8, color=INK)
    claim = first.calibration.sentence if first.calibration else ""
    figure.supxlabel(
        f"{SIGN_OF_DELTA} Grey: not valid.\n{claim}", fontsize=7.5, color=INK, wrap=True
    )


def _colours() -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(colour_table("delta-omega") / 255.0)


def _label(axes: Any, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=8, color=INK)
    axes.set_ylabel(y, fontsize=8, color=INK)
    axes.tick_params(labelsize=7, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def see_from_scanner(measured: LeafPoints) -> tuple[Floats, Floats]:
    """Places across the beam, mm to the right and up about the leaf's middle."""
    right, up, _ = _axes_of_view(measured)
    around = measured.xyz - np.nanmean(measured.xyz, axis=0)
    return to_mm(around @ right), to_mm(around @ up)


def see_from_side(measured: LeafPoints, judged: JudgedLeaf) -> tuple[Floats, Floats]:
    """Places along the beam and along the tilt, mm: a flat leaf is a line."""
    ahead, tilt = _axes_of_side(measured, judged)
    around = measured.xyz - judged.plane.point
    return to_mm(around @ ahead), to_mm(around @ tilt)


def _draw_plane(axes: Any, measured: LeafPoints, judged: JudgedLeaf) -> None:
    axes.plot(*line_of_plane(measured, judged), color=INK, linewidth=0.9)


def line_of_plane(measured: LeafPoints, judged: JudgedLeaf) -> tuple[Floats, Floats]:
    """The plane of a leaf from the side, mm: two points; none where it is seen edge-on."""
    ahead, tilt = _axes_of_side(measured, judged)
    _, high = see_from_side(measured, judged)
    along = np.array([np.nanmin(high), np.nanmax(high)])
    depth, across = float(judged.plane.normal @ ahead), float(judged.plane.normal @ tilt)
    if abs(depth) <= 1e-6:
        return np.empty(0), np.empty(0)
    return -along * across / depth, along


def _axes_of_side(measured: LeafPoints, judged: JudgedLeaf) -> tuple[Floats, Floats]:
    _, up, ahead = _axes_of_view(measured)
    tilt = judged.plane.normal - (judged.plane.normal @ ahead) * ahead
    steep = float(np.linalg.norm(tilt))
    side = tilt / steep if steep > 1e-9 else up
    return ahead, side if side @ up >= 0.0 else -side


def _axes_of_view(measured: LeafPoints) -> tuple[Floats, Floats, Floats]:
    ahead = np.nanmean(measured.xyz, axis=0) - measured.scanner
    ahead = ahead / np.linalg.norm(ahead)
    upright = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = np.cross(ahead, upright)
    right /= np.linalg.norm(right)
    return right, np.cross(right, ahead), ahead
