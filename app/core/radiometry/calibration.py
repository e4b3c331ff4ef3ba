"""From a table of panels to the calibration of a channel: checks, start, joint fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.chain import AnyStep
from app.core.radiometry.drift import Power
from app.core.radiometry.joint import JointFit, fit_jointly
from app.core.radiometry.models import (
    LEAST_PANELS,
    LEAST_RANGES,
    RANGE_EFFECTS,
    CalibrationModel,
)
from app.core.radiometry.nodes import find_ranges
from app.core.radiometry.panels import PanelTable, check_panels, find_fixed_panels
from app.core.radiometry.profile import ChannelCalibration, Evidence, Matrix, Noise
from app.core.radiometry.staged import StagedFit, fit_stages
from app.core.radiometry.start import Ranging, guess_powers, guess_steps
from app.core.radiometry.unknowns import Unknowns

NO_EFFECT_WITHIN = 0.1
"""Share of the panels' range by which targets may stand nearer or farther, where no effect of
range was fitted."""
BELOW_NOISE = 0.01
"""Share of the largest DN below zero that noise may reach."""
SIGMAS_BELOW = 5.0
OTHER_FORM = {"analytic": "analytic-inner", "analytic-inner": "analytic"}


@dataclass(frozen=True, slots=True)
class Wishes:
    """What the user decides about a calibration; None and empty: by rule.

    Attributes
    ----------
    reference_range : float or None
        Metres; default: that of the fixed panels, else the middle one of the table.
    reference_scan : str or None
        Its power is 1; default: the first, for SALCA the one that straddles the knee.
    fixed_panels : tuple of str
        What drift is measured by; default: panels that every scan saw at one range.
    breaks : tuple of float
        Where the pieces of a polynomial or spline meet, metres.
    dark, saturated : float or None
        Rows with a DN at and below, at and above are left out.
    noise : Noise or None
        Of a row, where it is known.
    """

    reference_range: float | None = None
    reference_scan: str | None = None
    fixed_panels: tuple[str, ...] = ()
    breaks: tuple[float, ...] = ()
    dark: float | None = None
    saturated: float | None = None
    noise: Noise | None = None


BY_RULE = Wishes()


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A fitted channel.

    Attributes
    ----------
    model : CalibrationModel
    wishes : Wishes
    table : PanelTable
        The rows that were used.
    dark, saturated : int
        Rows that were left out.
    fixed_panels : tuple of str
    reference_range : float
    reference_scan : str
    fit : JointFit
    staged : StagedFit or None
        SALCA's stages, from which the joint fit began.
    """

    model: CalibrationModel
    wishes: Wishes
    table: PanelTable
    dark: int
    saturated: int
    fixed_panels: tuple[str, ...]
    reference_range: float
    reference_scan: str
    fit: JointFit
    staged: StagedFit | None


def calibrate(table: PanelTable, model: CalibrationModel, wishes: Wishes = BY_RULE) -> Calibration:
    """Fit a model to panels.

    Parameters
    ----------
    table : PanelTable
    model : CalibrationModel
    wishes : Wishes

    Raises
    ------
    BadInput
        The table cannot be used: one sentence says why.
    WrongUse
        A wish does not fit the table.
    Undetermined
        The table does not determine all parameters.
    """
    check_panels(table)
    kept, dark, saturated = leave_out(table, wishes)
    _check_model(kept, model)
    fixed = _choose_fixed(kept, wishes)
    reference = _choose_range(kept, fixed, model, wishes)
    starts, scan, staged = find_starts(kept, model, wishes, fixed, reference)
    fit = fit_jointly(kept, starts, wishes.noise)
    return Calibration(
        model, wishes, kept, dark, saturated, fixed, reference, scan, fit, staged
    )  # fmt: skip


def leave_out(table: PanelTable, wishes: Wishes) -> tuple[PanelTable, int, int]:
    """The rows that are neither dark nor saturated, and how many are.

    Raises
    ------
    BadInput
        None is left.
    """
    dark = table.dn <= (-np.inf if wishes.dark is None else wishes.dark)
    saturated = table.dn >= (np.inf if wishes.saturated is None else wishes.saturated)
    if saturated.all():
        raise BadInput(
            f"All {len(table)} panels are saturated, at {wishes.saturated:g} DN or above.",
            "Scan darker panels or farther away, or correct --saturated.",
        )
    if (dark | saturated).all():
        raise BadInput(
            f"All {len(table)} panels are dark or saturated.", "Correct --dark and --saturated."
        )
    return table.pick(~(dark | saturated)), int((dark & ~saturated).sum()), int(saturated.sum())


def find_starts(
    table: PanelTable,
    model: CalibrationModel,
    wishes: Wishes,
    fixed: tuple[str, ...],
    reference: float,
) -> tuple[list[Unknowns], str, StagedFit | None]:
    """Start values, the scan whose power is 1, and SALCA's stages where they were fitted."""
    ranging = Ranging(reference, wishes.breaks)
    scans, place = table.scans, table.index_scans()
    if wishes.reference_scan is not None and wishes.reference_scan not in scans:
        raise WrongUse(
            f"There is no scan {wishes.reference_scan} in the table.",
            f"Its scans: {', '.join(scans)}.",
        )
    if fixed and model.response.name == "salca":
        staged = fit_stages(table, model, ranging, fixed, wishes.reference_scan)
        sought = np.array([scan != staged.reference_scan for scan in scans])
        starts = [Unknowns(steps, scans, staged.powers, sought) for steps in staged.starts]
        return starts, staged.reference_scan, staged
    scan = wishes.reference_scan or scans[0]
    powers, sought = np.ones(len(scans)), np.zeros(len(scans), bool)
    if fixed:
        powers = guess_powers(table, fixed, model.response.name == "log")
        powers = powers / powers[scans.index(scan)]
        sought = np.array([each != scan for each in scans])
    steps = guess_steps(table, model, ranging, powers[place])
    return [Unknowns(steps, scans, powers, sought)], scan, None


def fit_other_form(calibration: Calibration) -> tuple[CalibrationModel, JointFit] | None:
    """The same fit with the other reading of Hancock's range effect, with the same noise.

    None for a model without that effect.
    """
    effect = calibration.model.range_effect
    if effect is None or effect.name not in OTHER_FORM:
        return None
    model = CalibrationModel(
        calibration.model.response, RANGE_EFFECTS[OTHER_FORM[effect.name]]
    )  # fmt: skip
    starts, _, _ = find_starts(
        calibration.table,
        model,
        calibration.wishes,
        calibration.fixed_panels,
        calibration.reference_range,
    )
    return model, fit_jointly(calibration.table, starts, calibration.fit.noise)


def make_channel(calibration: Calibration, evidence: Evidence | None = None) -> ChannelCalibration:
    """What a profile keeps of a calibration.

    The chain begins with the power of the scan, 1 and sure for the reference scan: another scan
    replaces it by its own. It holds between the ranges of the panels; a model without a range
    effect a little beyond (`NO_EFFECT_WITHIN`), for nobody knows what range does there.
    """
    table, fit, wishes = calibration.table, calibration.fit, calibration.wishes
    count = len(fit.found.step_names)
    nearest, farthest = _choose_limits(calibration)
    steps = cast(tuple[AnyStep, ...], (Power(1.0), *fit.found.steps))
    return ChannelCalibration(
        channel=table.channel,
        steps=steps,
        wavelength_nm=table.wavelength_nm,
        dark=wishes.dark,
        saturated=wishes.saturated,
        nearest=nearest,
        farthest=farthest,
        reflectances=(float(table.reflectance.min()), float(table.reflectance.max())),
        noise=fit.noise,
        fit_covariance=_make_matrix(fit.noise_covariance[:count, :count]),
        panel_covariance=_make_matrix(fit.panel_covariance[:count, :count]),
        evidence=evidence,
    )


def _choose_limits(calibration: Calibration) -> tuple[float | None, float | None]:
    distance = calibration.table.distance
    nearest, farthest = float(distance.min()), float(distance.max())
    if calibration.model.range_effect is None:
        return nearest * (1.0 - NO_EFFECT_WITHIN), farthest * (1.0 + NO_EFFECT_WITHIN)
    one = len(find_ranges(distance)) == 1  # a law of nature was chosen to leave that range
    return (None, None) if one else (nearest, farthest)


def _make_matrix(covariance: Floats) -> Matrix:
    """A covariance with a row of zeros for the power, as plain numbers."""
    whole = np.pad(covariance, ((1, 0), (1, 0)))
    return tuple(tuple(map(float, row)) for row in whole)


def _check_model(table: PanelTable, model: CalibrationModel) -> None:
    """Refuse a table that has too little for the model, or numbers that it cannot give."""
    shades = len(np.unique(table.reflectance))
    least = LEAST_PANELS[model.response.name]
    if shades < least:
        raise BadInput(
            f"{model.response.title} needs panels of {least} reflectances; the table has {shades}"
            " that can be used.",
            "Add panels, or choose a simpler model.",
        )
    if model.range_effect is not None and model.fits_range:
        places, least = len(find_ranges(table.distance)), LEAST_RANGES[model.range_effect.name]
        if places == 1:
            raise BadInput(
                f"All panels are at {table.distance[0]:g} m, so that the table says nothing about"
                " the range.",
                f"Choose a model without range: --model {model.response.name}.",
            )
        if places < least:
            raise BadInput(
                f"{model.range_effect.title} needs panels at {least} ranges; the table has"
                f" {places}.",
                "Add ranges, or choose another range effect.",
            )
    if model.response.name in ("salca", "proportional"):
        _check_negative(table, model)


def _check_negative(table: PanelTable, model: CalibrationModel) -> None:
    reach = np.full(len(table), BELOW_NOISE * float(np.abs(table.dn).max()))
    if table.dn_sigma is not None:
        reach = SIGMAS_BELOW * table.dn_sigma
    below = table.dn < -reach
    if below.any():
        first = int(np.argmax(below))
        raise BadInput(
            f"Row {table.lines[first]} has {table.dn[first]:g} DN, and {model.response.title} gives"
            " none below 0.",
            "Choose another model (log and linear may be negative), or leave it out (--dark DN).",
        )


def _choose_fixed(table: PanelTable, wishes: Wishes) -> tuple[str, ...]:
    if not wishes.fixed_panels:
        return find_fixed_panels(table)
    unknown = [name for name in wishes.fixed_panels if name not in table.panels]
    if unknown:
        raise WrongUse(
            f"There is no panel {unknown[0]} that can be used in the table.",
            f"Its panels: {', '.join(table.panels)}.",
        )
    seen = table.pick(np.isin(table.panel, wishes.fixed_panels)).scans
    missing = [scan for scan in table.scans if scan not in seen]
    if missing:
        raise BadInput(
            f"Scan {missing[0]} has no fixed panel that can be used, so that its power is unknown.",
            "Leave the scan out, or name its fixed panel with --fixed-panel.",
        )
    return wishes.fixed_panels if len(table.scans) > 1 else ()


def _choose_range(
    table: PanelTable, fixed: tuple[str, ...], model: CalibrationModel, wishes: Wishes
) -> float:
    ranges = find_ranges(table.distance)
    still = table.distance[np.isin(table.panel, fixed)]
    if len(still) and float(np.ptp(still)) == 0:
        own = float(still[0])
    elif len(still):
        own = float(ranges[np.argmin(np.abs(ranges - still.mean()))])
    else:
        own = float(ranges[len(ranges) // 2])
    wanted = wishes.reference_range
    if wanted is None:
        return own
    if not 0 < wanted < np.inf:
        raise WrongUse(f"A reference range of {wanted:g} m is impossible.", "Give metres.")
    if fixed and model.response.name == "salca" and abs(wanted - own) > 0.05:
        raise WrongUse(
            f"The reference range of SALCA is that of its fixed panels, {own:g} m.",
            "Leave --reference-range out.",
        )
    return own if fixed and model.response.name == "salca" else wanted
