"""``leafscope bench planes``: planes of whole leaves, method against method."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.picture import draw_panels
from app.services.bench.planes.goniometer import check_goniometer
from app.services.bench.planes.table import draw_leaves, measure_leaves
from app.services.bench.results import Bench, list_targets

NAME = "planes"
TABLES = ("leaf_planes", "goniometer")


def bench_planes(quick: bool = False, progress: Progress = QUIET) -> Bench:
    """Angles of leaves' planes by regression, total least squares, robust and inverse range.

    Parameters
    ----------
    quick : bool
        Few leaves and angles: to see that it works, not to judge by.
    progress : Progress

    Raises
    ------
    Cancelled
    """
    leaves = measure_leaves(quick, progress.part(0.0, 0.6))
    goniometer = check_goniometer(quick, progress.part(0.6, 1.0))
    picture = partial(draw_panels, draw_leaves(leaves))
    return Bench(NAME, (leaves, goniometer), {NAME: picture})


def refuse_bench_planes(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    refuse_targets(list_targets(out, NAME, list(TABLES), [NAME]), overwrite, folder_follows=True)
