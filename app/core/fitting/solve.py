"""From a block of groups to the parameters of each, in the units of the normalised values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.core.fitting.block import Block
from app.core.fitting.pairs import Pairs, condense
from app.core.fitting.projection import Projection
from app.core.fitting.search import find_minima, polish
from app.core.phase import PhaseModel
from app.core.phase.angular import AngularModel
from app.core.phase.model import Freedom

# Pairs up to which all of them are searched; of more the means per bin are.
MOST_SEARCHED, SEARCH_BINS = 512, 192
# Dips of the condensed data that differ by less may be in another order in all of the data.
CLOSE = 1.05
ROUGH = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """The best curves of a block.

    Attributes
    ----------
    values : dict of str to (b,) array
        For the normalised values; NaN for an undetermined parameter.
    rss : (b,) array
        Of the normalised values.
    """

    values: dict[str, Floats]
    rss: Floats


def solve_block(model: PhaseModel, block: Block, fixed: Mapping[str, Floats]) -> Solved:
    """The parameters with the least sum of squares of each group.

    Parameters
    ----------
    model : PhaseModel
    block : Block
    fixed : mapping of str to (b,) array
        Parameters that are not fitted, for the normalised values.
    """
    freedom = make_freedom(model, fixed, len(block))
    projection = Projection(model, block.angle, block.value, np.sqrt(block.weight), freedom)
    if not model.shape or model.shape in fixed:
        shape = np.broadcast_to(fixed.get(model.shape, np.nan), len(block)).astype(np.float64)
    elif block.value.shape[1] <= MOST_SEARCHED:
        shape = find_minima(projection).choose_best()
    else:
        shape = np.array([_search_large(projection, row) for row in range(len(block))])
    coefficients, residual = projection.solve(shape)
    values = model.name_values(coefficients, shape, fixed)
    full = {name: np.broadcast_to(value, len(block)) for name, value in values.items()}
    return Solved(full, np.einsum("gn,gn->g", residual, residual))


def normalise_fixed(
    model: PhaseModel, fixed: Mapping[str, Any], rows: Ints, scale: Floats
) -> dict[str, Floats]:
    """Fixed parameters of some groups for their normalised values; each (b,)."""
    normal = {}
    for p in model.parameters:
        if p.name in fixed:
            value = np.asarray(fixed[p.name], np.float64)
            value = value[rows] if value.ndim else np.full(len(rows), value)
            normal[p.name] = value / scale if p.scales else value
    return normal


def check_fixed(model: AngularModel, fixed: Mapping[str, Any]) -> dict[str, Any]:
    """Raise `WrongUse` for a fixed parameter that does not exist or lies outside its bounds."""
    known = {p.name: p for p in model.parameters}
    for name, value in fixed.items():
        if name not in known:
            names = ", ".join(known)
            raise WrongUse(f"{model.name} has no parameter {name!r}.", f"Parameters: {names}.")
        low, high = known[name].lower, known[name].upper
        for one in np.ravel(value):
            if not (np.isfinite(one) and low <= one <= high):
                raise WrongUse(f"{name} = {one:g} is outside its bounds, {low:g} to {high:g}.")
    return dict(fixed)


def make_freedom(model: PhaseModel, fixed: Mapping[str, Floats], groups: int) -> Freedom:
    """The freedom of each group, or of all where they have the same fixed parameters."""
    same = all(np.ptp(value) == 0.0 for value in fixed.values())
    each = [
        model.free({name: float(value[row]) for name, value in fixed.items()})
        for row in range(1 if same else groups)
    ]
    return Freedom(
        *(np.stack([getattr(one, name) for one in each])
          for name in ("offset", "directions", "lower", "upper"))
    )  # fmt: skip


def _search_large(projection: Projection, row: int) -> float:
    """The best shape of a group of many pairs: sought in condensed pairs, polished in all."""
    full = projection.take(np.array([row]))
    kept = full.root[0] > 0
    angle, value, weight = full.angle[0][kept], full.value[0][kept], full.root[0][kept] ** 2
    few = condense(Pairs(angle, value, weight, 1.0, 1.0), SEARCH_BINS)
    rough = Projection(
        full.model, few.angle[None], few.value[None], np.sqrt(few.weight)[None], full.freedom
    )
    found = find_minima(rough, ROUGH)
    close = np.unique(found.shape[found.rss <= CLOSE * found.rss.min()])
    scan = full.model.search(full.angle)[0]
    limits = float(scan[0]), float(scan[-1])
    shapes = np.array([polish(full, rough, float(shape), limits) for shape in close])
    if len(shapes) == 1:
        return float(shapes[0])
    rss = [float(full.rss(shape[None])[0]) for shape in shapes]
    return float(shapes[np.argmin(rss)])
