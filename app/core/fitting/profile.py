"""Profile-likelihood intervals: how far a parameter can go while the others follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.fitting.batch import fit_many
from app.core.fitting.intervals import LEVEL, find_quantile
from app.core.fitting.pairs import Pairs, choose_pairs, condense
from app.core.fitting.result import FitResult
from app.core.fitting.roots import find_roots
from app.core.fitting.single import fit_pairs, require_enough
from app.core.fitting.solve import MOST_SEARCHED, check_fixed
from app.core.phase import Parameter, PhaseModel, choose_model

# Steps away from the best value, in units of the plain interval: fine near it, then wide.
STEPS = np.concatenate((np.arange(0.25, 2.01, 0.25), np.geomspace(2.5, 1000.0, 16)))
# Of the range, where there is no standard deviation to step by.
FIRST_STEP = 1e-3
PARTNER_TRIALS, ZOOMS = 41, 4


@dataclass(frozen=True, slots=True)
class ProfileInterval:
    """Values of a parameter that the pairs do not contradict.

    Attributes
    ----------
    low, high : float
    low_open, high_open : bool
        The end is the parameter's bound, or infinite: the pairs do not limit this side.
    """

    low: float
    high: float
    low_open: bool
    high_open: bool


def profile_intervals(
    model: PhaseModel | str,
    angle: Floats,
    value: Floats,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
    level: float = LEVEL,
) -> dict[str, ProfileInterval]:
    """Intervals in which rss(θ) ≤ rss·(1 + t²/(n − p)), all other parameters fitted anew.

    Right for curved models and at bounds, where standard deviations are not; the work is
    bounded: 24 trials to each side, then a root. θ of which no value is known is sought from the
    middle of its bounds.

    Parameters
    ----------
    model, angle, value, weights, fixed
        See `fit`.
    level : float

    Raises
    ------
    WrongUse, BadInput
        As from `fit`.

    Notes
    -----
    Bates and Watts, Nonlinear Regression Analysis (1988), section 6.1.
    """
    model = choose_model(model)
    fixed = check_fixed(model, dict(fixed or {}))
    pairs = choose_pairs(model, angle, value, weights)
    free = [p for p in model.parameters if p.name not in fixed]
    require_enough(model, pairs, len(free))
    best = fit_pairs(model, pairs, fixed)
    reach = float(find_quantile(level, len(pairs) - len(free)))
    profile = _Profile(model, pairs, fixed, best, reach)
    return {p.name: profile.find(p) for p in free}


class _Profile:
    """The sum of squares as a function of one parameter, less what the interval allows."""

    def __init__(
        self,
        model: PhaseModel,
        pairs: Pairs,
        fixed: Mapping[str, float],
        best: FitResult,
        reach: float,
    ) -> None:
        self.model, self.fixed, self.best, self.reach = model, fixed, best, reach
        self.few = condense(pairs, MOST_SEARCHED)
        self.scale = pairs.scale
        spare = len(pairs) - (len(model.parameters) - len(fixed))
        # What condensing leaves out does not depend on the parameters.
        least = float(self._rss(dict(fixed), 1)[0])
        whole = best.rss / (pairs.scale**2 * pairs.weight_scale)
        self.limit = least + whole * reach**2 / spare

    def find(self, p: Parameter) -> ProfileInterval:
        """The interval of one parameter."""
        estimate = self.best.parameters[p.name]
        centre = self._centre(p) if estimate.value is None else estimate.value
        step = self.reach * estimate.sd if estimate.sd else FIRST_STEP * self._range(p, centre)
        low, low_open = self._find_side(p, centre, -step)
        high, high_open = self._find_side(p, centre, step)
        return ProfileInterval(low, high, low_open, high_open)

    def _centre(self, p: Parameter) -> float:
        """The best value on a grid, where the fit knows none."""
        trials = (
            np.linspace(p.lower, p.upper, 65) if np.isfinite(p.upper - p.lower) else np.zeros(1)
        )
        return float(trials[np.argmin(self._excess(p, trials))])

    def _range(self, p: Parameter, centre: float) -> float:
        if np.isfinite(p.upper - p.lower):
            return p.upper - p.lower
        return max(abs(centre), self.scale if p.scales else 1.0)

    def _find_side(self, p: Parameter, centre: float, step: float) -> tuple[float, bool]:
        bound = p.upper if step > 0 else p.lower
        trials = np.unique(np.clip(centre + step * STEPS, p.lower, p.upper))
        trials = trials[trials != centre]
        trials = trials if step > 0 else trials[::-1]
        excess = self._excess(p, trials)
        beyond = np.flatnonzero(excess > 0)
        if not len(beyond):
            return bound, True
        last = int(beyond[0])
        inside = (centre, -1.0) if last == 0 else (float(trials[last - 1]), float(excess[last - 1]))
        if inside[1] >= 0:
            return inside[0], False
        root = find_roots(
            lambda x, _: self._excess(p, x),
            np.array([inside[0]]),
            trials[last : last + 1],
            (
                np.array([inside[1] * self.limit if last == 0 else inside[1]]),
                excess[last : last + 1],
            ),
        )
        return float(root[0]), False

    def _excess(self, p: Parameter, trials: Floats) -> Floats:
        partner = self.model.fixed_with.get(p.name)
        if partner is None or partner in self.fixed:
            return self._rss({**self.fixed, p.name: trials}, len(trials)) - self.limit
        return np.array([self._zoom(p.name, trial, partner) for trial in trials]) - self.limit

    def _zoom(self, name: str, trial: float, partner: str) -> float:
        """Least sum of squares over a partner that must be fixed too."""
        bounds = next(p for p in self.model.parameters if p.name == partner)
        low, high = bounds.lower, bounds.upper
        for _ in range(ZOOMS):
            grid = np.linspace(low, high, PARTNER_TRIALS)
            rss = self._rss({**self.fixed, name: trial, partner: grid}, PARTNER_TRIALS)
            place = int(np.argmin(rss))
            step = grid[1] - grid[0]
            low, high = (float(np.clip(grid[place] + k * step, bounds.lower, bounds.upper))
                         for k in (-1, 1))  # fmt: skip
        return float(rss.min())

    def _rss(self, fixed: Mapping[str, float | Floats], count: int) -> Floats:
        """For normalised values, as `fixed` is not."""
        few = self.few
        value = np.broadcast_to(few.value * self.scale, (count, len(few)))
        batch = fit_many(self.model, few.angle, value, few.weight, fixed=fixed)
        return batch.rss / self.scale**2
