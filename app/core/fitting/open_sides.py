"""Sides on which the pairs do not limit a shape, whatever its standard deviation says."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.core.fitting.block import hold_pairs
from app.core.fitting.intervals import LEVEL, find_quantile
from app.core.fitting.pairs import Pairs, condense
from app.core.fitting.projection import Projection
from app.core.fitting.solve import MOST_SEARCHED, make_freedom
from app.core.phase import PhaseModel

# Share of the values' sum of squares that is rounding.
ROUNDING = 1e-28


def explain_open_sides(
    model: PhaseModel,
    pairs: Pairs,
    values: Mapping[str, float],
    rss: float,
    sd: float,
    fixed: Mapping[str, float],
) -> list[str]:
    """A sentence for a bound of the shape at which the curve fits within 95 % as well as the best.

    A standard deviation knows the sum of squares near its least value only. A peak that fell
    before the second angle may be as sharp as one likes: the sum of squares stays flat down to
    the bound, where value ± sd would claim the opposite, or a million.

    Parameters
    ----------
    model : PhaseModel
    pairs : Pairs
    values : mapping of str to float
        Best parameters for the normalised values.
    rss : float
        Of the best curve, for the normalised values.
    sd : float
        Of the shape; NaN where it has none.
    fixed : mapping of str to float
        For the normalised values.
    """
    shape = next((p for p in model.parameters if p.name == model.shape), None)
    if shape is None or shape.wraps or shape.name in fixed or not np.isfinite(sd):
        return []
    few = condense(pairs, MOST_SEARCHED)
    block = hold_pairs(few)
    held = {name: np.array([value]) for name, value in fixed.items()}
    projection = Projection(
        model, block.angle, block.value, np.sqrt(block.weight), make_freedom(model, held, 1)
    )
    best = values[shape.name]
    bounds = np.array([shape.lower, shape.upper])
    least, low, high = (float(projection.rss(np.array([at]))[0]) for at in (best, *bounds))
    spare = len(pairs) - (len(model.parameters) - len(fixed))
    reach = float(find_quantile(LEVEL, spare))
    # What condensing leaves out is the same for every shape.
    limit = least + rss * reach**2 / spare
    limit += ROUNDING * float((pairs.weight * pairs.value**2).sum())
    open_low, open_high = low <= limit, high <= limit
    if open_low and open_high:
        return [
            f"{shape.name} is hardly determined: with any value from {bounds[0]:g} to"
            f" {bounds[1]:g} the curve may fit as well within {LEVEL:.0%}."
        ]
    return [
        f"{shape.name} is not limited from {side}: with {bound:g} the curve fits as well within"
        f" {LEVEL:.0%}, so its standard deviation holds on the other side only."
        for side, bound, is_open in (
            ("below", bounds[0], open_low),
            ("above", bounds[1], open_high),
        )
        if is_open
    ]
