"""Pictures and LaTeX tables of an index: against the angle, against the footprint."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.core.errors import WrongUse
from app.formats.atomic import atomic_path
from app.services.bench.picture import COLOURS, DPI, INK, number_axis
from app.services.index_angle import IndexAngles
from app.services.leaves import Row
from app.services.synthetic_footprints import Spread

SIZE = (5.2, 3.6)
FORMATS = (".png", ".svg", ".pdf")
COLUMNS = (
    ("Leaf", "leaf", ""),
    ("Mean", "index_mean", ".3f"),
    ("$A$", "A", ".4f"),
    ("low", "A_low", ".4f"),
    ("high", "A_high", ".4f"),
    ("noise", "A_from_noise", ".4f"),
    ("min", "fitted_min", ".3f"),
    ("at $^\\circ$", "fitted_min_deg", ".0f"),
    ("max", "fitted_max", ".3f"),
    ("at $^\\circ$", "fitted_max_deg", ".0f"),
)
"""Title, key and format of each column of the LaTeX table."""


def draw_index_angles(found: IndexAngles, leaf: str, path: Path) -> None:
    """Draw the index of one leaf against the angle as PNG, SVG or PDF, by the file's ending."""
    figure, axes = _begin(path)
    rows = [row for row in found.curves if row.get("leaf") == leaf]
    x, y, error = _columns([row for row in rows if row["curve"] == "measured"])
    axes.errorbar(x, y, error, fmt="s", color=COLOURS[0], label="mean ± standard error per 5°")
    x, y, error = _columns([row for row in rows if row["curve"] == "fitted"])
    if len(x):
        axes.plot(x, y, color=INK, label="index of the fitted channels")
        axes.fill_between(x, y - error, y + error, color=INK, alpha=0.15, linewidth=0)
    axes.set_xlabel("angle of incidence ω, °", color=INK)
    axes.set_ylabel(found.index.name, color=INK)
    axes.set_title(leaf, fontsize=10, color=INK, loc="left")
    axes.legend(fontsize=8, frameon=False)
    _save(figure, path)


def draw_spread(found: Spread, error: float, reached_mm: float | None, path: Path) -> None:
    """Draw the spread of an index against the diameter as PNG, SVG or PDF."""
    figure, axes = _begin(path)
    rows = [row for row in found.rows if row["diameter_mm"] and row["sd"] is not None]
    x = np.array([row["diameter_mm"] for row in rows], dtype=np.float64)
    axes.plot(x, [row["sd"] for row in rows], "o-", color=COLOURS[0], label="footprints")
    single = found.rows[0]["sd"]
    if single is not None:
        axes.axhline(single, color=INK, linestyle=":", label="single points")
    axes.axhline(error, color=COLOURS[1], linestyle="--", label=f"error {error:g}")
    if reached_mm:
        axes.axvline(reached_mm, color=COLOURS[1], linewidth=1.0, label=f"{reached_mm:.3g} mm")
    axes.set_xscale("log")
    number_axis(axes.xaxis)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("diameter of the footprint, mm", color=INK)
    axes.set_ylabel(f"standard deviation of {found.index.name}", color=INK)
    axes.legend(fontsize=8, frameon=False)
    _save(figure, path)


def write_latex(found: IndexAngles, path: Path) -> None:
    """Write the leaves as a LaTeX table (booktabs): mean, amplitude, interval, range."""
    lines = [
        f"% {_escape(found.index.name)}: A with its 95 % interval, and what noise alone gives",
        f"\\begin{{tabular}}{{l{'r' * (len(COLUMNS) - 1)}}}",
        "\\toprule",
        " & ".join(title for title, _, _ in COLUMNS) + r" \\",
        "\\midrule",
        *(" & ".join(_cell(row, key, form) for _, key, form in COLUMNS) + r" \\"
          for row in found.rows),
        "\\bottomrule",
        "\\end{tabular}",
    ]  # fmt: skip
    with atomic_path(path, overwrite=True) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _cell(row: Row, key: str, form: str) -> str:
    value = row.get(key)
    if value is None:
        return "--"
    if not form:
        return _escape(str(value))
    return f"{value:{form}}".replace("-", "$-$")


def _escape(text: str) -> str:
    for sign in "\\&%$#_{}~^":
        text = text.replace(sign, {"\\": "/", "~": " ", "^": " "}.get(sign, f"\\{sign}"))
    return text


def _begin(path: Path) -> tuple[Any, Any]:
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if path.suffix.lower() not in FORMATS:
        raise WrongUse(f"A picture ends with {', '.join(FORMATS)}, not {path.suffix!r}.")
    figure = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.grid(True, color="#d9dcdf", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure, axes


def _save(figure: Any, path: Path) -> None:
    with atomic_path(path, overwrite=True) as temporary:
        figure.savefig(temporary, format=path.suffix[1:].lower())


def _columns(rows: Sequence[Row]) -> tuple[Any, Any, Any]:
    found = (
        np.array([np.nan if row[key] is None else row[key] for row in rows], dtype=np.float64)
        for key in ("angle_deg", "index", "sigma")
    )
    x, y, error = found
    return x, y, error
