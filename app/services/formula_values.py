"""Try a formula before it is put to use: its values on some points, the channel of a wavelength."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Ints
from app.core.formula_wavelengths import Pick, resolve_formula
from app.core.progress import QUIET, Progress
from app.model.project import Project

LARGEST_NM = 9999.0


@dataclass(frozen=True, slots=True)
class FormulaValues:
    """Values of a formula; `undefined` counts points without one."""

    count: int
    undefined: int
    mean: float
    sd: float
    low: float
    high: float


def try_formula(
    project: Project, scan: str, text: str, points: Ints | None, progress: Progress = QUIET
) -> FormulaValues:
    """Evaluate a formula on points (None: all) that exist for the user.

    Raises
    ------
    WrongUse, MissingChannel
        See `app.core.formula_wavelengths.resolve_formula`.
    """
    state = project.state.scan(scan)
    found = resolve_formula(text, state.wavelengths, [c.name for c in state.channels])
    points = np.flatnonzero(state.alive) if points is None else points[state.alive[points]]
    values = {n: project.field(scan, n, points, progress) for n in found.reads.values()}
    result = found.evaluate(values, progress)
    known = result[np.isfinite(result)]
    if not len(known):
        return FormulaValues(0, len(result), np.nan, np.nan, np.nan, np.nan)
    sd = float(known.std(ddof=1)) if len(known) > 1 else np.nan
    ends = float(known.min()), float(known.max())
    return FormulaValues(len(known), len(result) - len(known), float(known.mean()), sd, *ends)


def nearest_channel(project: Project, scan: str, nm: float) -> Pick:
    """The channel that a formula would take for a wavelength, and how to write it.

    Raises
    ------
    MissingChannel
        No channel says its wavelength.
    """
    state = project.state.scan(scan)
    (pick,) = resolve_formula(write_symbol(nm), state.wavelengths).picks
    return pick


def write_symbol(nm: float) -> str:
    """A wavelength as a formula writes it: ``r1063``, or ``r564_3`` for 564.3 nm."""
    whole, _, tenth = f"{min(nm, LARGEST_NM):.1f}".partition(".")
    return f"r{whole}" if tenth == "0" else f"r{whole}_{tenth}"
