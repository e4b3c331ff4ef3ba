"""Numbers that sum up a scan of leaves before a wall: ghosts, borders, intensity against ω."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.units import to_radians
from app.services.bench.simulate.marks import Marks
from app.services.bench.simulate.other_scene import COLUMNS, GLOSS, ROWS, STEP
from app.simulate.beam import Bundle

QUANTILES = (0.25, 0.5, 0.75, 0.9)
BINS_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
KINDS = ("flat", "bent", "wrinkled")
FEWEST = 300
"""Points that a bin needs to have a mean."""


def summarise(marks: Marks) -> dict[str, float]:
    """All measures of a scan, by name."""
    return {**_count_ghosts(marks), **_place_ghosts(marks), **_width(marks), **_brightness(marks)}


def _count_ghosts(marks: Marks) -> dict[str, float]:
    border = count_borders(marks.image())
    split, ghost, unsure = (int(m.sum()) for m in (~marks.full, marks.ghost, marks.unsure))
    return {
        "borders between leaves, share of all": count_borders(marks.image(), False) / border,
        "split beams per cell of border": split / border,
        "ghosts per cell of border": ghost / border,
        "ghosts per split beam": ghost / split,
        "unsure per split beam": unsure / split,
    }


def count_borders(image: Ints, with_wall: bool = True) -> int:
    """Neighbours in a row or a column that lie on different surfaces, or different leaves."""
    lowest = -9 if with_wall else 0
    pairs = ((image[1:], image[:-1]), (image[:, 1:], image[:, :-1]))
    return int(sum(((a != b) & (np.minimum(a, b) >= lowest)).sum() for a, b in pairs))


def _place_ghosts(marks: Marks) -> dict[str, float]:
    ghost = marks.ghost
    found: dict[str, float] = {}
    for name, values, unit in (
        ("ghost to its nearest surface", marks.distance[ghost], "m"),
        ("ghost before the wall", marks.before_wall[ghost], "m"),
        ("ghost off its strongest surface", np.abs(marks.shift[ghost]), "m"),
        ("part of the strongest surface, ghosts", marks.strongest[ghost], ""),
        ("part of the strongest surface, split beams", marks.strongest[~marks.full], ""),
    ):
        for q in QUANTILES:
            found[f"{name}, {q:.0%} quantile{', ' + unit if unit else ''}"] = float(
                np.quantile(values, q)
            )
    return found


def _width(marks: Marks) -> dict[str, float]:
    """Split cells between a full leaf and the full wall beside it, in rows and columns."""
    widths = measure_widths(marks)
    return {
        f"border width, {q:.0%} quantile, beam diameters": float(np.quantile(widths, q))
        for q in QUANTILES
    }


def measure_widths(marks: Marks) -> Floats:
    """Width of each run of split cells between a leaf and the wall, in beam diameters.

    Runs along rows and down columns.
    """
    state = np.full(ROWS * COLUMNS, -9)
    state[marks.cell] = np.where(marks.full, np.minimum(marks.leaf, 0), 1)
    away = np.zeros(ROWS * COLUMNS)
    away[marks.cell] = marks.range
    states, ranges = state.reshape(ROWS, -1), away.reshape(ROWS, -1)
    found = []
    for row, distance in [
        *zip(states, ranges, strict=True),
        *zip(states.T, ranges.T, strict=True),
    ]:
        known = np.flatnonzero((row == 0) | (row == -1))
        crosses = row[known][1:] + row[known][:-1] == -1  # a leaf, 0, beside the wall, −1
        cells = (np.diff(known) - 1)[crosses]
        near = np.minimum(distance[known][1:], distance[known][:-1])[crosses]
        diameter = 2 * (Bundle().radius(0.0) + near * np.tan(Bundle().half_divergence))
        found.append(cells * STEP * near / diameter)
    return np.concatenate(found)


def _brightness(marks: Marks) -> dict[str, float]:
    """Full hits by angle: reflectance over the phase function, which is the leaf's at ω = 0."""
    leaf = marks.full & (marks.leaf >= 0)
    found: dict[str, float] = {}
    for k, nm in enumerate((1063, 1545)):
        flat = marks.rho[:, k] / lambert_beckmann(marks.incidence, *GLOSS[k])
        found |= _bin_means(f"ρ at {nm} nm from all leaves", marks, leaf, flat)
    for kind, name in enumerate(KINDS):
        found[f"ρ at 1545 nm from {name}"] = _mean(flat[leaf & (marks.kind == kind)])
    wall = marks.full & (marks.leaf < 0)
    matt = marks.rho[:, 1] / np.cos(to_radians(marks.incidence))
    found["ρ at 1545 nm from the wall"] = _mean(matt[wall])
    return found


def lambert_beckmann(incidence_deg: Floats, k_d: float, m: float) -> Floats:
    """Science, section 3; 1 at 0°."""
    omega = to_radians(incidence_deg)
    gloss = np.exp(-(np.tan(omega) ** 2) / m**2) / np.cos(omega) ** 5
    return np.asarray(k_d * np.cos(omega) + (1 - k_d) * gloss)


def _bin_means(name: str, marks: Marks, chosen: Bools, values: Floats) -> dict[str, float]:
    found: dict[str, float] = {}
    for low, high in pairwise(BINS_DEG):
        some = chosen & (marks.incidence >= low) & (marks.incidence < high)
        found[f"{name}, {low:.0f}–{high:.0f}°"] = _mean(values[some])
    return found


def _mean(values: Floats) -> float:
    return float(values.mean()) if len(values) >= FEWEST else np.nan
