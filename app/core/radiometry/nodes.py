"""Where the pieces of a range curve meet: as many nodes as the table's ranges can carry.

The rule: candidates are all distinct ranges of the table, every second of them, every third …,
each as straight pieces and as parabolas, always with both ends and the reference range. The one
with the least BIC (Schwarz 1978) is taken; it pays for a node only where the rows ask for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.models import RangeScale
from app.core.radiometry.range_curve import PolynomialCurve

TOGETHER = 0.01
"""Share of a range, and …"""
NEAR = 0.02
"""… metres within which ranges are one."""
ROUNDING = 1e-24

Order = Literal[1, 2]


@dataclass(frozen=True, slots=True)
class Nodes:
    """Ranges where the pieces of a curve meet, metres, and the order of the pieces."""

    ranges: tuple[float, ...]
    order: Order


def find_ranges(distance: Floats) -> Floats:
    """Distinct ranges, rising: means of those that are nearer together than panels stand.

    The first and the last are the outermost distances themselves.
    """
    rising = np.sort(distance)
    gaps = np.diff(rising) > np.maximum(NEAR, TOGETHER * rising[1:])
    groups = np.split(rising, np.flatnonzero(gaps) + 1)
    # The mean of equal numbers may be off by a bit, and would be another range.
    found = np.array([group[0] if group[0] == group[-1] else group.mean() for group in groups])
    found[0], found[-1] = rising[0], rising[-1]
    return found


def place_reference(ranges: Floats, reference: float) -> Floats:
    """The ranges with the nearest inner one, or an equal end, moved to the reference range.

    Raises
    ------
    WrongUse
        It lies outside.
    """
    if not ranges[0] <= reference <= ranges[-1]:
        raise WrongUse(
            f"The reference range of {reference:g} m is outside the panels' "
            f"{ranges[0]:g} to {ranges[-1]:g} m.",
            "Choose one between them (--reference-range).",
        )
    placed = ranges.copy()
    if reference in (ranges[0], ranges[-1]):
        return placed
    inner = placed[1:-1]
    if not len(inner):
        return np.array([ranges[0], reference, ranges[-1]])
    inner[np.argmin(np.abs(inner - reference))] = reference
    return placed


def take_nodes(breaks: Sequence[float], distance: Floats, reference: float) -> Nodes:
    """Nodes at breaks that the user gave, in straight pieces.

    Raises
    ------
    WrongUse
        A break lies outside the ranges of the table.
    """
    low, high = float(distance.min()), float(distance.max())
    for value in breaks:
        if not low <= value <= high:
            raise WrongUse(
                f"The break at {value:g} m is outside the panels' {low:g} to {high:g} m."
            )
    if not low <= reference <= high:
        place_reference(np.array([low, high]), reference)
    return Nodes(tuple(sorted({low, *map(float, breaks), reference, high})), 1)


def take_every(distance: Floats, reference: float) -> Nodes:
    """A node at every range: what a panel at the same range says is taken as it is."""
    ranges = place_reference(find_ranges(distance), reference)
    return Nodes(tuple(map(float, ranges)), 1)


def choose_nodes(
    distance: Floats,
    reference: float,
    scale: RangeScale,
    misfit: Callable[[PolynomialCurve], float],
    orders: Sequence[Order] = (1, 2),
    beside: int = 1,
) -> Nodes:
    """The nodes with the least BIC.

    Where the rows are just as many as the parameters, the simplest curve is taken.

    Parameters
    ----------
    distance : (n,) array
    reference : float
        Metres.
    scale : str
    misfit : callable
        Sum of squared residuals of the best fit with a curve's nodes, over that of no fit.
    orders : sequence of {1, 2}
    beside : int
        Parameters that `misfit` fits beside the levels.

    Raises
    ------
    BadInput
        Even the simplest curve has more parameters than there are rows.
    """
    count = len(distance)
    best: tuple[float, Nodes] | None = None
    exact: Nodes | None = None
    for nodes in _offer(place_reference(find_ranges(distance), reference), reference, orders):
        parameters = len(nodes.ranges) + beside
        if parameters >= count:
            exact = nodes if parameters == count else exact
            continue
        levels = (0.0 if scale == "additive" else 1.0,) * len(nodes.ranges)
        curve = PolynomialCurve(scale, nodes.ranges, levels, reference, nodes.order)
        rss = max(misfit(curve), ROUNDING)
        bic = count * np.log(rss / count) + parameters * np.log(count)
        if best is None or bic < best[0]:
            best = float(bic), nodes
    if best is not None:
        return best[1]
    if exact is not None:
        return exact
    rows = "1 row" if count == 1 else f"{count} rows"
    raise BadInput(f"{rows} cannot determine a curve over range.", "Add panels at other ranges.")


def _offer(ranges: Floats, reference: float, orders: Sequence[Order]) -> Iterator[Nodes]:
    at = int(np.flatnonzero(ranges == reference)[0])
    for step in range(1, len(ranges)):
        kept = {0, at, len(ranges) - 1, *range(at, len(ranges), step), *range(at, -1, -step)}
        chosen = tuple(float(ranges[k]) for k in sorted(kept))
        for order in orders:
            if (len(chosen) - 1) % order == 0:
                yield Nodes(chosen, order)
