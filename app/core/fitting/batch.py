"""Many groups fitted in one call: leaves × channels, trials of a bootstrap, profiles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from app.core.arrays import Bools, Floats, Ints
from app.core.chunks import count_processors
from app.core.errors import BadInput
from app.core.fitting.block import Block, arrange_blocks
from app.core.fitting.covariance import compute_covariance, stack_jacobians, take_deviations
from app.core.fitting.groups import Groups, read_groups
from app.core.fitting.intervals import LEVEL, SHOWN, Kind, find_quantile, span
from app.core.fitting.pairs import choose_pairs
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.fitting.single import require_enough
from app.core.fitting.solve import Solved, check_fixed, normalise_fixed, solve_block
from app.core.phase import PhaseModel, choose_model
from app.core.progress import QUIET, Progress


@dataclass(frozen=True, eq=False)
class FitBatch:
    """Fits of many groups. Numbers come as tables, words one group at a time.

    Attributes
    ----------
    model : PhaseModel
    names : tuple of str
        The p parameters, in the order of the tables.
    values : (g, p) array
        NaN for what is undetermined or fixed by nobody, and for groups that cannot be fitted.
    rss : (g,) array
        (Weighted) sums of squared residuals.
    n : (g,) array
        Pairs used.
    at_bound : (g, p) array of bool
    """

    model: PhaseModel
    names: tuple[str, ...]
    values: Floats
    rss: Floats
    n: Ints
    at_bound: Bools
    _groups: Groups = field(repr=False)
    _fixed: Mapping[str, Any] = field(repr=False)
    _parts: list[tuple[Block, Solved]] = field(repr=False)

    def __len__(self) -> int:
        return len(self.values)

    @property
    def fitted(self) -> tuple[str, ...]:
        """Names of the parameters that were not fixed."""
        return tuple(name for name in self.names if name not in self._fixed)

    @property
    def refused(self) -> Bools:
        """Groups that cannot be fitted, (g,); `words` tells why."""
        return np.isnan(self.rss)

    @cached_property
    def covariance(self) -> Floats:
        """Covariances, (g, p, p); NaN for what has none: fixed, at a bound, undetermined."""
        result = np.full((*self.values.shape, len(self.names)), np.nan)
        for block, solved in self._parts:
            result[block.rows] = self._covary(block, solved)
        return result

    @cached_property
    def sd(self) -> Floats:
        """Standard deviations, (g, p)."""
        return take_deviations(self.covariance)

    def column(self, name: str) -> Floats:
        """Values of one parameter, (g,)."""
        return self.values[:, self.names.index(name)]

    def intervals(self, level: float = LEVEL, kind: Kind = SHOWN) -> Floats:
        """Ends of the intervals that `FitResult.interval` gives, (g, p, 2); NaN without one."""
        spare = np.maximum(self.n - len(self.fitted), 1)
        reach = find_quantile(level, spare)
        ends = [
            np.stack(span(p, self.values[:, i], self.sd[:, i], reach, kind), axis=-1)
            for i, p in enumerate(self.model.parameters)
        ]
        return np.stack(ends, axis=1)

    def result(self, group: int) -> FitResult:
        """The fit of one group, as `fit` gives it.

        Raises
        ------
        BadInput
            The group cannot be fitted.
        """
        pairs = choose_pairs(self.model, *self._groups.pick(group))
        require_enough(self.model, pairs, len(self.fitted))
        row, scale = np.array([group]), np.array([pairs.scale])
        fixed = normalise_fixed(self.model, self._fixed, row, scale)
        values = {
            p.name: float(value) / (pairs.scale if p.scales else 1.0)
            for p, value in zip(self.model.parameters, self.values[group], strict=True)
        }
        return report_fit(self.model, pairs, values, {k: float(v[0]) for k, v in fixed.items()})

    def words(self, group: int) -> tuple[str, ...]:
        """Warnings of one group, or why it cannot be fitted."""
        try:
            return self.result(group).warnings
        except BadInput as error:
            return (str(error),)

    def _covary(self, block: Block, solved: Solved) -> Floats:
        model, fitted = self.model, self.fitted
        known = np.isfinite(self.values[block.rows]) & ~self.at_bound[block.rows]
        known &= np.isin(self.names, fitted)
        values = {
            p.name: np.where(np.isfinite(solved.values[p.name]), solved.values[p.name], p.start)
            for p in model.parameters
        }
        jacobian = stack_jacobians(model, block.angle, values, self.names)
        jacobian = jacobian * np.sqrt(block.weight)[..., None] * known[:, None, :]
        noise = np.sqrt(solved.rss / (block.count - len(fitted)))
        size = np.where([p.scales for p in model.parameters], block.scale[:, None], 1.0)
        return compute_covariance(jacobian, noise) * size[:, :, None] * size[:, None, :]


def fit_many(
    model: PhaseModel | str,
    angle: npt.ArrayLike,
    value: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
    *,
    offsets: npt.ArrayLike | None = None,
    fixed: Mapping[str, npt.ArrayLike] | None = None,
    progress: Progress = QUIET,
) -> FitBatch:
    """Fit one model to each of many groups, with the numbers that `fit` gives one by one.

    Parameters
    ----------
    model : PhaseModel or str
    angle : (n,) or (g, n) array, or (N,) with `offsets`
        Radians; (n,) are shared by all groups, which is fastest.
    value : (g, n) array, or (N,) with `offsets`
        Pairs that are not finite or outside the model's angles are left out.
    weights : array like `angle` or `value`, optional
    offsets : (g + 1,) array of int, optional
        Group i holds the pairs offsets[i] to offsets[i + 1].
    fixed : mapping of str to float or (g,) array, optional
        Parameters that are not fitted, for all groups or for each.
    progress : Progress

    Returns
    -------
    FitBatch
        A group that cannot be fitted has NaN and words; it does not stop the others.

    Raises
    ------
    WrongUse
        Unknown model or parameter.
    BadInput
        The arrays do not fit together, or a weight is negative.
    Cancelled
    """
    model = choose_model(model)
    groups = read_groups(angle, value, weights, offsets)
    fixed = check_fixed(model, dict(fixed or {}))
    for name, one in fixed.items():
        if np.shape(one) not in ((), (len(groups),)):
            raise BadInput(f"Fixed values of {name} must be one number, or one for each group.")
    free = len(model.parameters) - len(fixed)
    blocks = [_keep_enough(block, free) for block in arrange_blocks(model, groups)]
    blocks = [block for block in blocks if len(block)]
    parts = _solve_all(model, blocks, fixed, progress)
    return _gather(model, groups, fixed, parts)


def _gather(
    model: PhaseModel, groups: Groups, fixed: Mapping[str, Any], parts: list[tuple[Block, Solved]]
) -> FitBatch:
    """The tables of all blocks, in the units of the data."""
    names = tuple(p.name for p in model.parameters)
    values = np.full((len(groups), len(names)), np.nan)
    at_bound = np.zeros(values.shape, np.bool_)
    rss, n = np.full(len(groups), np.nan), np.zeros(len(groups), np.int64)
    for block, solved in parts:
        rss[block.rows] = solved.rss * block.scale**2 * block.weight_scale
        n[block.rows] = block.count
        for column, p in enumerate(model.parameters):
            one = solved.values[p.name]
            values[block.rows, column] = one * block.scale if p.scales else one
            at_bound[block.rows, column] = p.touches_bound(one) & (p.name not in fixed)
    return FitBatch(model, names, values, rss, n, at_bound, groups, fixed, parts)


def _keep_enough(block: Block, free: int) -> Block:
    """Only the groups that `require_enough` lets pass."""
    enough = block.count > free
    if enough.any():
        enough &= block.count_angles(max(free, 2)) >= max(free, 2)
    return block if enough.all() else block.take(enough)


def _solve_all(
    model: PhaseModel, blocks: list[Block], fixed: Mapping[str, Any], progress: Progress
) -> list[tuple[Block, Solved]]:
    from concurrent.futures import ThreadPoolExecutor

    def solve(block: Block) -> tuple[Block, Solved]:
        normal = normalise_fixed(model, fixed, block.rows, block.scale)
        return block, solve_block(model, block, normal)

    parts = []
    text = f"Fitting {model.title}"
    progress.report(0.0, text)
    with ThreadPoolExecutor(max(1, min(count_processors(), len(blocks)))) as pool:
        try:
            for done in pool.map(solve, blocks):
                parts.append(done)
                progress.report(len(parts) / len(blocks), text)
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return parts
