"""What is said of a calibration: its parameters, and what the profile does not know."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from app.core.radiometry.calibration import NO_EFFECT_WITHIN, Calibration
from app.core.radiometry.nodes import find_ranges
from app.core.radiometry.profile import Evidence
from app.core.radiometry.residuals import find_errors, root_mean_square

FEW = 5
"""Degrees of freedom below which noise is hardly known."""
APART = 1.1
"""Ratio of the panels' ranges above which range has an effect of its own."""
GAP = 2.5
"""Ratio of neighbouring ranges above which a curve between them is a guess."""
LARGE, LARGE_SHARE = 0.1, 1 / 3
"""RMSE of the reflectance, and as a share of the mean one, above which the model is wrong."""
NOT_KNOWN = "as many numbers as rows: how sure it is, is not known"


class Parameter(NamedTuple):
    """A parameter of a fit; None where noise, and so its σ, is not known."""

    name: str
    value: float
    sd: float | None
    low: float | None
    high: float | None
    from_noise: float | None
    from_panels: float


def list_parameters(found: Calibration) -> list[Parameter]:
    """Every parameter that was fitted; of a range effect alone the curve's levels only."""
    fit = found.fit
    columns = (fit.deviations, fit.low, fit.high, np.sqrt(np.diag(fit.noise_covariance)))
    values, panels = fit.found.natural(), np.sqrt(np.diag(fit.panel_covariance))
    rows = []
    for k, name in enumerate(fit.found.names):
        sd, low, high, noise = (_know(column[k]) for column in columns)
        rows.append(Parameter(name, float(values[k]), sd, low, high, noise, float(panels[k])))
    names = fit.found.steps[-1].names
    return [row for row in rows if row.name in names] if found.model.range_alone else rows


def tell_noise(found: Calibration) -> str:
    """Noise of a row in words."""
    noise = found.fit.noise
    if noise is None:
        return f"not known ({NOT_KNOWN})"
    return f"{noise.constant:.3g} DN and {100 * noise.share:.3g} % of it"


def tell_error(found: Calibration, evidence: Evidence | None) -> str:
    """How well the panels come back, in words: reflectance, or DN of a range effect alone."""
    if evidence is None:
        return ""
    what, digits = ("corrected DN", ".3g") if found.model.range_alone else ("reflectance", ".4f")
    outside = evidence.left_out_rmse
    without = "" if outside is None else f", for panels left out of the fit {outside:{digits}}"
    return f"{what}: RMSE {evidence.rmse:{digits}}, bias {evidence.bias:+{digits}}{without}"


def _know(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def warn_of(found: Calibration, any_range: bool, point_noise: bool) -> Iterator[str]:
    """What a user must know beside the numbers."""
    yield from _warn_of_rows(found)
    yield from _warn_of_ranges(found, any_range)
    yield from _warn_of_misfit(found)
    if not point_noise and found.fit.noise is not None:
        yield (
            "The noise in the profile is that of the table's rows. Where they are means of many"
            " returns a point is noisier: give --point-noise."
        )
    if not found.model.range_alone and not found.table.reflectance_sigma.any():
        yield "The panels are taken as exactly known; otherwise give --panel-sigma."


def _warn_of_rows(found: Calibration) -> Iterator[str]:
    if found.saturated or found.dark:
        yield f"{found.saturated} saturated and {found.dark} dark rows were left out."
    several = len(found.table.scans) > 1 and not found.wishes.same_power
    if several and found.model.range_alone:
        yield "The laser's power is taken as the same in all scans."
    elif several and not found.fixed_panels:
        yield (
            "No panel is in all scans at one range: the laser's power is taken as the same in all."
        )
    if found.fit.noise is None:
        yield f"There are {NOT_KNOWN}. Add rows, or give their σ (a column dn_sigma)."
    elif found.fit.spare < FEW:
        spare = max(found.fit.spare, 0)
        yield (
            f"The noise was judged by {spare} degree{'' if spare == 1 else 's'} of freedom: it is"
            " hardly known, and σ is large for that. Add panels or scans."
        )


def _warn_of_ranges(found: Calibration, any_range: bool) -> Iterator[str]:
    ranges = find_ranges(found.table.distance)
    if found.model.range_effect is None and len(ranges) == 1:
        yield (
            f"All panels are at {ranges[0]:g} m: the profile knows no effect of range, and"
            f" holds there, give or take {100 * NO_EFFECT_WITHIN:g} %. If the instrument has taken"
            " the effect out, say --any-range."
        )
    elif found.model.range_effect is None and ranges[-1] > APART * ranges[0] and not any_range:
        yield (
            f"The panels are at {ranges[0]:g} to {ranges[-1]:g} m, and the model"
            f" {found.model.name} knows no effect of range. Choose one with a range effect, such"
            f" as {found.model.name}+polynomial, or say --any-range if the instrument has taken"
            " the effect out."
        )
    if found.model.fits_curve:
        for near, far in pairwise(ranges):
            if far > GAP * near:
                yield f"No panel between {near:g} and {far:g} m: the curve there is a guess."


def _warn_of_misfit(found: Calibration) -> Iterator[str]:
    if found.model.range_alone:
        return
    rmse = root_mean_square(find_errors(found))
    if rmse > min(LARGE, LARGE_SHARE * float(found.table.reflectance.mean())):
        yield (
            f"The panels come back with an RMSE of {rmse:.3f}: the model does not fit them. Check"
            " the columns, saturated panels (--saturated) and the model."
        )
