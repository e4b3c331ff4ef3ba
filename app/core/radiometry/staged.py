"""The staged fit of SALCA (Hancock et al. 2017, appendix C): each stage fixes the earlier ones.

Its intervals ignore that the earlier stages are unsure, and are far too narrow in the last one:
it is the start of the joint fit, and they are kept to be shown beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.radiometry.models import CalibrationModel
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.start import (
    Ranging,
    form_of,
    guess_front,
    guess_salca,
    offer_analytic,
)  # fmt: skip
from app.core.radiometry.step import Step
from app.core.radiometry.unknowns import FARTHEST

USUAL = (1.7, 0.3, 0.7)
"""Values a, k2 and k3 between those of the paper's two channels."""
KNEE = 350.0
"""DN of the knee that the paper saw."""
LEAST_POWER, MOST_POWER = 1e-3, 1e3


@dataclass(frozen=True, slots=True, eq=False)
class StagedFit:
    """What the three stages found.

    Attributes
    ----------
    steps : tuple of Step
        Range effect and response.
    powers : (s,) array
        Of each scan of the table.
    reference_scan : str
    intervals : dict of str to (low, high)
        95 % of m, c, k (first stage) and of a, k2, k3 (third), of each stage alone.
    """

    steps: tuple[Step, ...]
    powers: Floats
    reference_scan: str
    intervals: dict[str, tuple[float, float]]

    @property
    def starts(self) -> tuple[tuple[Step, ...], ...]:
        """Steps to begin a joint fit with: those found, and with a range effect of the paper's
        size, because the third stage may run away where the dim far panels say little.
        """
        first = self.steps[0]
        if not isinstance(first, AnalyticRange):
            return (self.steps,)
        usual = msgspec.structs.replace(first, a=USUAL[0], k2=USUAL[1], k3=USUAL[2])
        return (self.steps, (usual, *self.steps[1:]))


@np.errstate(over="ignore", invalid="ignore")
def fit_stages(
    table: PanelTable,
    model: CalibrationModel,
    ranging: Ranging,
    fixed: tuple[str, ...],
    reference_scan: str | None = None,
) -> StagedFit:
    """Fit m, c, k; then the power of each scan; then the range effect.

    Parameters
    ----------
    table : PanelTable
    model : CalibrationModel
        SALCA's response, with any range effect.
    ranging : Ranging
        Its reference is the range of the fixed panels.
    fixed : tuple of str
        Panels that stand still.
    reference_scan : str, optional
        Default: the scan whose fixed panels best straddle the knee.

    Raises
    ------
    BadInput
        There are too few fixed panels, or none in a scan.
    """
    still = table.pick(np.isin(table.panel, fixed))
    reference = reference_scan or find_reference_scan(still)
    response, intervals = _fit_response(still.pick(still.scan == reference))
    powers = np.array([_fit_power(still.pick(still.scan == s), s, response) for s in table.scans])
    powers[table.scans.index(reference)] = 1.0
    light = table.reflectance * powers[table.index_scans()]
    moved = ~np.isin(table.panel, fixed)
    effect = model.range_effect.name if model.range_effect else ""
    if model.fits_range and not moved.any():
        raise BadInput(
            "All panels stand still, and a range effect needs one at other ranges.",
            "Say which panels are fixed (--fixed-panel), or choose a model without range.",
        )
    if not effect.startswith("analytic"):
        front = _guess_effect(table, model, ranging, response, light)
        return StagedFit((*front, response), powers, reference, intervals)
    step, found = _fit_range(table.pick(moved), light[moved], response, effect, ranging.reference)
    return StagedFit((step, response), powers, reference, intervals | found)


def find_reference_scan(still: PanelTable) -> str:
    """The scan whose fixed panels straddle the knee with most on both sides, then most widely."""

    def rank(scan: str) -> tuple[int, float]:
        dn = still.dn[still.scan == scan]
        return min(int((dn < KNEE).sum()), int((dn > KNEE).sum())), float(np.ptp(dn))

    return max(still.scans, key=rank)


def _guess_effect(
    table: PanelTable,
    model: CalibrationModel,
    ranging: Ranging,
    response: SalcaResponse,
    light: Floats,
) -> tuple[Step, ...]:
    """A range effect other than the paper's own; a start only."""
    if model.range_effect is None:
        return ()
    if not model.fits_range:
        return (InverseSquare(ranging.reference),)
    return (guess_front(table, model, ranging, light, response),)


def _fit_response(rows: PanelTable) -> tuple[SalcaResponse, dict[str, tuple[float, float]]]:
    if len(rows) < 4:
        raise BadInput(
            f"The reference scan has {len(rows)} fixed panels; m, c and k need four at least.",
            "Name the fixed panels with --fixed-panel, or add some.",
        )
    start = guess_salca(rows.reflectance, rows.dn)
    rho = rows.reflectance

    def evaluate(logs: Floats) -> tuple[Floats, Floats]:
        step = SalcaResponse(*np.exp(logs))
        return step.respond(rho, rows.distance), step.gradient(rho, rows.distance).T * np.exp(logs)

    found, deviations, reach = _minimise(evaluate, np.log(start.values()), rows.dn)
    ends = np.exp([found - reach * deviations, found + reach * deviations])
    return SalcaResponse(*np.exp(found).tolist()), _pair("mck", ends)


def _fit_power(rows: PanelTable, scan: str, response: SalcaResponse) -> float:
    from scipy.optimize import minimize_scalar

    if not len(rows):
        raise BadInput(
            f"Scan {scan} has no fixed panel that can be used, so that its power is unknown.",
            "Leave the scan out, or name its fixed panel with --fixed-panel.",
        )

    def misfit(log_power: float) -> float:
        away = response.respond(rows.reflectance * np.exp(log_power), rows.distance) - rows.dn
        return float(np.sum(away**2))

    # The light of each panel says where to look: the sum of squares has one minimum among them.
    light = response.invert(rows.dn, rows.distance) / rows.reflectance
    light = light[np.isfinite(light) & (light > LEAST_POWER) & (light < MOST_POWER)]
    if not len(light):
        raise BadInput(f"The fixed panels of scan {scan} do not fit the response.")
    ends = (float(np.log(light.min())) - 0.01, float(np.log(light.max())) + 0.01)
    best = minimize_scalar(misfit, bounds=ends, method="bounded", options={"xatol": 1e-12})
    return float(np.exp(best.x))


def _fit_range(
    rows: PanelTable, light: Floats, response: SalcaResponse, effect: str, reference: float
) -> tuple[AnalyticRange, dict[str, tuple[float, float]]]:
    def respond(step: AnalyticRange) -> tuple[Floats, Floats]:
        seen = step.respond(light, rows.distance)
        slope = response.slope(seen, rows.distance)
        return response.respond(seen, rows.distance), slope * step.gradient(light, rows.distance)

    offers = offer_analytic(form_of(effect), rows.distance, reference)
    start = min(offers, key=lambda step: float(np.sum((respond(step)[0] - rows.dn) ** 2)))

    def evaluate(vector: Floats) -> tuple[Floats, Floats]:
        values = np.array([vector[0], *np.exp(vector[1:])])
        value, gradient = respond(start.with_values(values))
        return value, gradient.T * np.array([1.0, *values[1:]])

    first = start.values()
    first[1:] = np.log(first[1:])
    found, deviations, reach = _minimise(evaluate, first, rows.dn)
    ends = np.array([found - reach * deviations, found + reach * deviations])
    ends[:, 1:] = np.exp(ends[:, 1:])
    found[1:] = np.exp(found[1:])
    return start.with_values(found), _pair(("a", "k2", "k3"), ends)


def _minimise(
    evaluate: Callable[[Floats], tuple[Floats, Floats]], start: Floats, dn: Floats
) -> tuple[Floats, Floats, float]:
    """MINPACK's Levenberg–Marquardt: values, their σ in this stage alone, and Student's t."""
    from scipy.optimize import least_squares
    from scipy.stats import t

    def near(vector: Floats) -> Floats:
        return np.clip(vector, start - FARTHEST, start + FARTHEST)

    def residual(vector: Floats) -> Floats:
        return np.nan_to_num(evaluate(near(vector))[0] - dn, nan=1e9)

    def slopes(vector: Floats) -> Floats:
        return np.nan_to_num(evaluate(near(vector))[1], nan=0.0, posinf=0.0, neginf=0.0)

    best = least_squares(residual, start, slopes, method="lm", x_scale="jac")
    freedom = max(len(dn) - len(start), 1)
    found = near(np.asarray(best.x, float))
    jacobian = slopes(found)
    inverse = np.linalg.pinv(jacobian.T @ jacobian)
    deviations = np.sqrt(np.diag(inverse) * 2 * best.cost / freedom)
    return found, deviations, float(t.ppf(0.975, freedom))


def _pair(names: str | tuple[str, ...], ends: Floats) -> dict[str, tuple[float, float]]:
    return {name: (float(low), float(high)) for name, low, high in zip(names, *ends, strict=True)}
