"""Intervals from standard deviations: t quantiles, and coordinates that keep to the bounds."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from app.core.phase import Parameter

Kind = Literal["plain", "within bounds"]
LEVEL = 0.95
SHOWN: Kind = "plain"


def find_quantile(level: float, spare: Any) -> Any:
    """Student's t that a fraction `level` of values does not exceed in size.

    Parameters
    ----------
    level : float
    spare : int or (...) array
        Pairs less fitted parameters: the noise is estimated from them too.
    """
    from scipy.special import stdtrit

    return stdtrit(spare, (1 + level) / 2)


def span(p: Parameter, value: Any, sd: Any, reach: Any, kind: Kind) -> tuple[Any, Any]:
    """Ends of the interval of a parameter.

    Parameters
    ----------
    p : Parameter
    value, sd : float or (...) array
    reach : float or (...) array
        Standard deviations to each side.
    kind : str
        ``plain``: value ± reach·sd, cut off at the bounds, which costs no coverage.
        ``within bounds``: the same in a coordinate in which a bound is infinitely far (log of
        the distance from one bound, logit between two), turned back; never beyond a bound, and
        not symmetric. A parameter without bounds has only the first.
    """
    if kind == "plain" or p.wraps or not np.isfinite(p.lower):
        low, high = value - reach * sd, value + reach * sd
        return (low, high) if p.wraps else (np.maximum(low, p.lower), np.minimum(high, p.upper))
    above = value - p.lower
    with np.errstate(all="ignore"):
        if not np.isfinite(p.upper):
            factor = np.exp(reach * sd / above)
            return p.lower + above / factor, p.lower + above * factor
        below = p.upper - value
        width = p.upper - p.lower
        # d logit = width / (above·below) d value
        odds, factor = above / below, np.exp(reach * sd * width / (above * below))
        low, high = odds / factor, odds * factor
        return p.lower + width / (1 + 1 / low), p.lower + width / (1 + 1 / high)
