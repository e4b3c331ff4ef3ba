"""One weighted fit of all numbers of a calibration together, and how sure they are.

The residuals are weighted by the noise of the *fitted* numbers: weights from the measured ones
would favour rows that came out low. Two covariances are kept apart: that of noise, which more
scans make smaller, and that of the panels' reflectances, which all rows of a panel share.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.noise import estimate_noise
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.profile import Noise
from app.core.radiometry.unknowns import Unknowns

ROUNDS = 8
SETTLED = 1e-3
STEPS = 500
SINGULAR = 1e-8
"""Share of the largest singular value below which a direction is not determined."""
FIRST_SHARE = 0.01
"""Noise of the first round, of a number and a tenth of the largest one."""
TINY = 1e-100
VAGUE = 10.0
"""σ of a logarithm above which nothing is known of a number."""
TAKES_PART = 0.1
NORMAL_95 = 1.959963984540054


class Undetermined(BadInput):
    """The data do not determine all parameters of a calibration.

    Parameters
    ----------
    names : tuple of str
        Those that can change together and leave every number as it is.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        listed = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        powers = any(name.startswith("power of") for name in names)
        hint = (
            "Fix the power of one scan (--reference-scan), or scan a fixed panel in every scan."
            if powers
            else "Add panels of other reflectances or ranges, or choose a simpler model."
        )
        super().__init__(f"The table does not determine {listed}.", hint)
        self.names = names


@dataclass(frozen=True, slots=True, eq=False)
class JointFit:
    """What a joint fit found.

    Attributes
    ----------
    found : Unknowns
        Steps and powers with the values found.
    noise_covariance, panel_covariance : (p, p) arrays
        Of the parameters as they are (no logarithms), in the order of ``found.names``.
        Noise: NaN where nothing tells it, with as many parameters as rows and no known noise.
    low, high : (p,) arrays
        95 % intervals: noise (Student's t) and panels together; NaN where noise is not known.
    noise : Noise or None
        Of a number; None: not known.
    scale : float
        Size of the residuals over the noise that was taken: 1 where it was estimated, and not
        less where it was given, for a few residuals may be small by chance.
    freedom : int
        Rows less parameters.
    spare : int
        Rows less the directions that parameters and unsure panels took: what noise is judged by.
    fitted, residual, sigma : (n,) arrays
        DN: of the fit, measured less fitted, and σ of a row.
    singular : (p,) array
        Singular values of the Jacobian with columns of length 1, falling.
    """

    found: Unknowns
    noise_covariance: Floats
    panel_covariance: Floats
    low: Floats
    high: Floats
    noise: Noise | None
    scale: float
    freedom: int
    spare: int
    fitted: Floats
    residual: Floats
    sigma: Floats
    singular: Floats

    @property
    def deviations(self) -> Floats:
        """σ of each parameter, noise and panels together, (p,)."""
        return np.sqrt(np.diag(self.noise_covariance) + np.diag(self.panel_covariance))

    @property
    def chi_square(self) -> float:
        """Sum of the squared residuals over σ²."""
        return float(np.sum((self.residual / self.sigma) ** 2))

    def powers(self) -> Mapping[str, float]:
        """Power of each scan."""
        return dict(zip(self.found.scans, self.found.powers.tolist(), strict=True))

    def power_sigma(self) -> Mapping[str, float]:
        """σ of the power of each scan; 0 for one that was fixed."""
        sigma = np.zeros(len(self.found.scans))
        open_ = int(self.found.sought.sum())
        sigma[self.found.sought] = self.deviations[len(self.deviations) - open_ :]
        return dict(zip(self.found.scans, sigma.tolist(), strict=True))


def predict(unknowns: Unknowns, table: PanelTable) -> tuple[Floats, Floats, Floats]:
    """What the instrument gives for each row.

    Returns
    -------
    value : (n,) array
        DN.
    jacobian : (n, p) array
        Derivative by ``unknowns.vector()``.
    slope : (n,) array
        Derivative by the panel's reflectance.
    """
    place = table.index_scans()
    power = unknowns.powers[place]
    light = table.reflectance * power
    each = chains.linearise(unknowns.steps, light, table.distance)
    steps = len(each.gradient)
    jacobian = np.zeros((len(table), len(unknowns)))
    jacobian[:, :steps] = each.gradient.T
    column = np.cumsum(unknowns.sought) - 1 + steps
    open_ = np.flatnonzero(unknowns.sought[place])
    jacobian[open_, column[place[open_]]] = (each.slope * table.reflectance)[open_]
    # A number that ran away changes nothing any more; its derivative is inf / inf on the way there.
    told = np.nan_to_num(jacobian * unknowns.stretch(), nan=0.0, posinf=0.0, neginf=0.0)
    return each.value, told, each.slope * power


@np.errstate(over="ignore", invalid="ignore")
def fit_jointly(
    table: PanelTable, starts: Unknowns | Sequence[Unknowns], noise: Noise | None = None
) -> JointFit:
    """Fit all unknowns to all rows, by Levenberg–Marquardt in a trust region.

    Parameters
    ----------
    table : PanelTable
        Its scans are those of the starts. Rows with a σ of their own keep it.
    starts : Unknowns or several
        The fit goes on from the one that leads to the least squares.
    noise : Noise, optional
        Known noise, which is enlarged where the residuals are larger; without it, and
        without σ in the table, noise is estimated in turns with the fit.

    Raises
    ------
    BadInput
        There are fewer rows than parameters, or the model gives no number for a row.
    Undetermined
        Parameters can change together and leave every number as it is.
    """
    starts = (starts,) if isinstance(starts, Unknowns) else starts
    freedom = len(table) - len(starts[0])
    if freedom < 0:
        raise BadInput(
            f"{count_rows(len(table))} cannot determine {len(starts[0])} parameters.",
            "Add panels or scans, or choose a simpler model.",
        )
    found, fitted, sigma = _iterate(table, starts, noise)
    _, jacobian, slope = predict(found, table)
    weighted = jacobian / sigma[:, None]
    singular, turned, lengths = decompose(weighted, found.names)
    residual = table.dn - fitted
    rest, used = _leave_noise(table, found, sigma)
    spare = len(table) - used
    given = noise is not None or table.dn_sigma is not None
    scale = _find_scale(rest / sigma, spare, given)
    inverse = (turned.T / singular) / lengths[:, None]
    noise_part = scale**2 * inverse @ inverse.T
    pulls = inverse @ inverse.T @ (weighted.T / sigma) * slope
    panel_part = _gather_panels(pulls, table)
    vague = found.positive() & (np.sqrt(np.diag(noise_part)) > VAGUE)
    if vague.any():
        raise Undetermined(tuple(name for name, at in zip(found.names, vague, strict=True) if at))
    known = _describe_noise(table, fitted, sigma, scale, noise, (rest, used))
    if known is None:
        noise_part = np.full_like(noise_part, np.nan)
    stretch = np.outer(found.stretch(), found.stretch())
    low, high = _find_interval(found, noise_part, panel_part, spare)
    return JointFit(
        found, noise_part * stretch, panel_part * stretch, low, high,
        known, scale, freedom, spare, fitted, residual, sigma, singular,
    )  # fmt: skip


def count_rows(count: int) -> str:
    """``1 row``, ``2 rows``."""
    return f"{count} row" if count == 1 else f"{count} rows"


def find_reach(spare: int) -> float:
    """Half a 95 % interval in σ: Student's t, or normal where the residuals tell nothing."""
    from scipy.stats import t

    return float(t.ppf(0.975, spare)) if spare > 0 else NORMAL_95


def _find_scale(rest: Floats, spare: int, given: bool) -> float:
    """Size of what is left over, in σ."""
    if spare <= 0:
        return 1.0
    scale = float(np.sqrt(np.sum(rest**2) / spare))
    return max(scale, 1.0) if given else scale


def _leave_noise(table: PanelTable, found: Unknowns, sigma: Floats) -> tuple[Floats, int]:
    """What a fit leaves over but for errors of the panels, DN, and how many directions it took.

    A panel whose reflectance is unsure may be off in all of its rows alike. That error is in
    the covariance of the panels, and is not to be counted as noise once more.
    """
    value, jacobian, slope = predict(found, table)
    residual = (table.dn - value) / sigma
    unsure = {p: table.panel == p for p in table.panels if _is_unsure(table, p)}
    columns = np.column_stack([jacobian, *(np.where(mine, slope, 0.0) for mine in unsure.values())])
    columns = columns / sigma[:, None]
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), TINY)
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    left = left[:, singular > SINGULAR * singular[0]]
    if left.shape[1] >= len(table):  # as many panels as rows: nothing tells them apart
        return residual * sigma, len(found)
    return (residual - left @ (left.T @ residual)) * sigma, left.shape[1]


def _is_unsure(table: PanelTable, panel: str) -> bool:
    return bool(table.reflectance_sigma[table.panel == panel].any())


def decompose(weighted: Floats, names: tuple[str, ...]) -> tuple[Floats, Floats, Floats]:
    """Singular values (p,) of a Jacobian (n, p) with columns of length 1, its right vectors and
    the lengths; raises `Undetermined` where one is zero.
    """
    singular, turned, lengths = find_singular(weighted)
    lost = singular <= SINGULAR * singular[0]
    if lost.any() or not lengths.all():
        part = (np.abs(turned[lost]) > TAKES_PART).any(axis=0) | (lengths == 0)
        raise Undetermined(tuple(name for name, at in zip(names, part, strict=True) if at))
    return singular, turned, lengths


def find_singular(weighted: Floats) -> tuple[Floats, Floats, Floats]:
    """As `decompose`, whatever the singular values are."""
    lengths = np.linalg.norm(weighted, axis=0)
    unit = weighted / np.where(lengths > 0, lengths, 1.0)
    _, singular, turned = np.linalg.svd(unit, full_matrices=False)
    return singular, turned, lengths


def solve(table: PanelTable, start: Unknowns, sigma: Floats) -> Unknowns:
    """Least squares with given σ.

    Raises
    ------
    BadInput
        The model gives no number for a row even at the start.
    """
    from scipy.optimize import least_squares

    def residual(vector: Floats) -> Floats:
        return np.asarray((predict(start.at(vector), table)[0] - table.dn) / sigma)

    def slopes(vector: Floats) -> Floats:
        return np.asarray(predict(start.at(vector), table)[1] / sigma[:, None])

    first = residual(start.vector())
    if not np.isfinite(first).all():
        line = int(table.lines[np.argmin(np.isfinite(first))])
        raise BadInput(f"The model gives no number for row {line}.", "Correct it or leave it out.")
    best = least_squares(
        residual, start.vector(), slopes, method="trf", x_scale="jac",
        xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=STEPS,
    )  # fmt: skip
    return start.at(best.x)


def _iterate(
    table: PanelTable, starts: Sequence[Unknowns], noise: Noise | None
) -> tuple[Unknowns, Floats, Floats]:
    """Fit and noise in turns, until σ settles."""
    sigma = _first_sigma(table, noise)
    tried = [solve(table, start, sigma) for start in starts]

    def misfit(found: Unknowns) -> float:
        return float(np.sum(((predict(found, table)[0] - table.dn) / sigma) ** 2))

    found = min(tried, key=misfit)
    fitted = predict(found, table)[0]
    for _ in range(ROUNDS):
        found = solve(table, found, sigma)
        fitted = predict(found, table)[0]
        if table.dn_sigma is not None:
            break
        rest, used = _leave_noise(table, found, sigma)
        if noise is None and used >= len(table):
            break
        kept = noise or estimate_noise(rest, fitted, used)
        before, sigma = sigma, kept.sigma(fitted)
        if np.allclose(sigma, before, rtol=SETTLED):
            break
    return found, fitted, sigma


def _first_sigma(table: PanelTable, noise: Noise | None) -> Floats:
    if table.dn_sigma is not None:
        return table.dn_sigma
    if noise is not None:
        return noise.sigma(table.dn)
    size = np.abs(table.dn)
    return np.asarray(FIRST_SHARE * (size + 0.1 * max(float(size.max()), TINY)))


def _describe_noise(
    table: PanelTable, fitted: Floats, sigma: Floats, scale: float, noise: Noise | None,
    left: tuple[Floats, int],
) -> Noise | None:  # fmt: skip
    """The noise as the profile tells it."""
    if table.dn_sigma is None and noise is None:
        if left[1] >= len(table):
            return None
        return estimate_noise(left[0], fitted, left[1])
    if noise is not None and table.dn_sigma is None:
        return Noise(noise.constant * scale, noise.share * scale)
    return estimate_noise(scale * sigma, fitted, 0)


def _gather_panels(pulls: Floats, table: PanelTable) -> Floats:
    """Σ over panels of (dθ/dρ σ)(dθ/dρ σ)ᵀ: an error of a panel moves all of its rows."""
    moved = np.zeros((len(pulls), len(table.panels)))
    shifted = pulls * table.reflectance_sigma
    place: AnyArray = table.index_panels()
    np.add.at(moved.T, place, shifted.T)
    return np.asarray(moved @ moved.T)


def _find_interval(
    found: Unknowns, noise_part: Floats, panel_part: Floats, spare: int
) -> tuple[Floats, Floats]:
    reach = find_reach(spare) ** 2 * np.diag(noise_part) + NORMAL_95**2 * np.diag(panel_part)
    ends = []
    for sign in (-1.0, 1.0):
        end = found.vector() + sign * np.sqrt(reach)
        positive = found.positive()
        end[positive] = np.exp(end[positive])
        ends.append(end)
    return ends[0], ends[1]
