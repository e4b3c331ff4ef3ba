"""Write what the index panel shows: tables and pictures, by the kind that was asked for."""

from __future__ import annotations

from pathlib import Path

from app.services.index_angle import IndexAngles
from app.services.index_picture import draw_index_angles, draw_spread, write_latex
from app.services.leaves import write_table
from app.services.synthetic_footprints import Spread


def write_angles(found: IndexAngles, leaf: str, kind: str, path: Path) -> None:
    """Leaves or curves as CSV, leaves as LaTeX, or the picture of one leaf."""
    if kind == "rows.csv":
        write_table(found.rows, path, overwrite=True)
    elif kind == "curves.csv":
        write_table(found.curves, path, overwrite=True)
    elif kind == "table.tex":
        write_latex(found, path)
    else:
        draw_index_angles(found, leaf, path)


def write_spread(found: Spread, error: float, reached_mm: float | None, path: Path) -> None:
    """The spread as CSV, or its picture."""
    if path.suffix.lower() == ".csv":
        write_table(found.rows, path, overwrite=True)
    else:
        draw_spread(found, error, reached_mm, path)
