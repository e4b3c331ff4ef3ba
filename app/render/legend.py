"""The colour bar of a picture: title, unit, round ticks, and how many points are drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.core.units import group_digits
from app.model.fields import FieldKind
from app.model.scene import ColourBar, Scene
from app.render.palettes import BACKGROUNDS, Background, Bytes, colour_table, is_categorical
from app.render.ticks import label_ticks, round_ticks

SHORT = ("good", "no signal", "dark", "saturated", "off ranges", "off response", "partial hit")
"""`app.core.radiometry.marks.WORDS` for a narrow legend."""
CORRECTED = (
    "good", "no value", "no angle", "off angles", "too steep", "negative", "none for it"
)  # fmt: skip
"""`app.core.workflows.marks.WORDS` for a narrow legend."""
INK: dict[Background, str] = {"light": "#25303a", "dark": "#dfe6ec"}
ANSWERS: dict[FieldKind, tuple[tuple[int, str], ...]] = {
    "flag": ((0, "no"), (255, "yes")),
    "verdict": ((0, "no"), (1, "yes"), (2, "unsure")),
    "mark": tuple(enumerate(SHORT)),
    "correction": tuple(enumerate(CORRECTED)),
}
"""Rows of the colour table that stand for an answer, in the order of the values."""
SIGN_NOTE = "negative: towards facing the beam · positive: towards edge-on"


def legend_height(size: tuple[int, int]) -> int:
    """Pixels at the bottom of a picture that the legend takes."""
    return round(100 * _scale(size))


def add_legend(
    image: Bytes, size: tuple[int, int], scene: Scene, drawn: int, background: Background
) -> Bytes:
    """Put a picture above a strip with colour bar and counts.

    Parameters
    ----------
    image : (height − legend_height, width, 3) uint8
    size : (width, height)
        Of the result.

    Returns
    -------
    (height, width, 3) uint8
    """
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = size
    paper = np.empty((height, width, 3), np.uint8)
    paper[:] = BACKGROUNDS[background][1]
    paper[: len(image)] = image
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    figure.figimage(paper, resize=False)
    scale = _scale(size)
    style: dict[str, Any] = {
        "color": INK[background],
        "fontsize": 12.5 * scale,
        "fontfamily": "DejaVu Sans",
    }
    left = 24 * scale / width
    figure.text(left, 26 * scale / height, count_points(drawn, scene.total), **style)
    bars = [cloud.bar for cloud in scene.clouds if cloud.bar is not None]
    if bars:
        _draw_bar(figure, bars[0], size, style)
    if any(bar.kind == "signed angle" for bar in bars):
        figure.text(left, 58 * scale / height, SIGN_NOTE, **style)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def count_points(shown: int, total: int) -> str:
    """``1 234 567 / 1 300 000 points``."""
    return f"{group_digits(shown)} / {group_digits(total)} points"


def title_of(bar: ColourBar) -> str:
    """Title and unit of a colour bar."""
    return f"{bar.title} [{bar.unit}]" if bar.unit else bar.title


def _scale(size: tuple[int, int]) -> float:
    return max(0.45, min(size[0] / 1600, size[1] / 1000))


def _draw_bar(figure: Any, bar: ColourBar, size: tuple[int, int], style: dict[str, Any]) -> None:
    (width, height), scale = size, _scale(size)
    long, thick, edge = 560 * scale / width, 15 * scale / height, 28 * scale / width
    axes = figure.add_axes((1 - edge - long, 38 * scale / height, long, thick), zorder=1)
    colours, limits, ticks, labels = _scale_of(bar)
    axes.imshow(colours[None], aspect="auto", extent=(*limits, 0.0, 1.0), interpolation="nearest")
    axes.set_xlim(*limits)
    axes.set_yticks([])
    axes.set_xticks(ticks, labels)
    ink = style["color"]
    axes.tick_params(
        colors=ink, labelsize=0.85 * style["fontsize"], length=4 * scale, width=scale, pad=4 * scale
    )
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_title(title_of(bar), loc="left", pad=9 * scale, **style)


def _scale_of(bar: ColourBar) -> tuple[Bytes, tuple[float, float], list[float], list[str]]:
    if bar.kind in ANSWERS:
        rows, texts = zip(*ANSWERS[bar.kind], strict=True)
        places = [float(place) for place in range(len(rows))]
        return colour_table(bar.map)[list(rows)], (-0.5, places[-1] + 0.5), places, list(texts)
    if is_categorical(bar.map):
        first, last = round(bar.low), min(round(bar.high), round(bar.low) + 23)
        numbers = list(range(first, last + 1))
        shown = [float(i) for i in numbers[:: max(1, len(numbers) // 8)]]
        colours = colour_table(bar.map)[[i % 256 for i in numbers]]
        return colours, (first - 0.5, last + 0.5), shown, [f"{i:.0f}" for i in shown]
    ticks = round_ticks(bar.low, bar.high)
    return colour_table(bar.map), (bar.low, bar.high), ticks, label_ticks(ticks)
