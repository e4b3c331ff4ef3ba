"""The mean of a panel in a scan, over its full hits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.model.hit_fields import find_missing
from app.model.project import Project

FEWEST = 10
"""Returns of a panel below which its mean says little."""


@dataclass(frozen=True, slots=True)
class PanelReading:
    """A panel in a scan, as one raw channel saw it.

    Attributes
    ----------
    channel : str
    range_m : float
        Mean of its returns.
    dn : float
        Mean of its full hits.
    sigma : float
        Standard error of that mean.
    n : int
        Full hits.
    partial : int
        Returns that were left out because the beam lay on the panel in part.
    partial_known : bool
        False where nobody could look for partial hits: without a beam or a grid.
    """

    channel: str
    range_m: float
    dn: float
    sigma: float
    n: int
    partial: int
    partial_known: bool


def measure_panel(
    project: Project, scan: str, points: Ints, channel: str, progress: Progress = QUIET
) -> PanelReading:
    """Mean of a raw channel over the full hits of a panel.

    Raises
    ------
    BadInput
        Too few points are left.
    """
    state = project.state.scan(scan)
    points = points[state.alive[points]]
    share = _read_share(project, scan, points, progress)
    full = np.ones(len(points), bool) if share is None else _is_full(share)
    values = project.field(scan, channel, points, progress)
    used = full & np.isfinite(values)
    if np.count_nonzero(used) < FEWEST:
        raise BadInput(
            f"Only {np.count_nonzero(used)} of {len(points)} points of the panel can be used, and "
            f"its mean needs {FEWEST}.",
            "Draw it larger, away from its border.",
        )
    chosen, number = values[used], int(used.sum())
    return PanelReading(
        channel,
        float(np.mean(project.field(scan, "range", points[used]))),
        float(np.mean(chosen)),
        float(np.std(chosen, ddof=1) / np.sqrt(number)),
        number,
        int(np.count_nonzero(~full)),
        share is not None,
    )


def _is_full(share: Floats) -> Bools:
    from app.core.radiometry.partial_hits import FULL_HIT

    return ~(share < FULL_HIT)


def _read_share(project: Project, scan: str, points: Ints, progress: Progress) -> Floats | None:
    if find_missing(project.state.scan(scan), progress):
        return None
    return project.field(scan, "hit_fraction", points, progress)
