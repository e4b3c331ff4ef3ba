"""From a table of panels to the calibration of a channel: checks, start, joint fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.chain import AnyStep
from app.core.radiometry.checks import (
    divide_at_one_range,
    refuse_model,
    refuse_plateau,
    refuse_powers,
    refuse_wishes,
)
from app.core.radiometry.drift import Power
from app.core.radiometry.joint import (
    NORMAL_95,
    JointFit,
    find_reach,
    fit_jointly,
)
from app.core.radiometry.models import (
    RANGE_EFFECTS,
    CalibrationModel,
)
from app.core.radiometry.nodes import find_ranges
from app.core.radiometry.panels import PanelTable, check_panels, find_fixed_panels
from app.core.radiometry.profile import ChannelCalibration, Evidence, Matrix, Noise
from app.core.radiometry.range_alone import fit_alone, keep_curve, relabel
from app.core.radiometry.staged import StagedFit, fit_stages
from app.core.radiometry.start import Ranging, guess_powers, guess_steps
from app.core.radiometry.step import Step
from app.core.radiometry.unknowns import Unknowns

NO_EFFECT_WITHIN = 0.1
"""Share of the panels' range by which targets may stand nearer or farther, where no effect of
range was fitted."""
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
    same_power : bool
        The laser's power did not change between scans: none is sought.
    """

    reference_range: float | None = None
    reference_scan: str | None = None
    fixed_panels: tuple[str, ...] = ()
    breaks: tuple[float, ...] = ()
    dark: float | None = None
    saturated: float | None = None
    noise: Noise | None = None
    same_power: bool = False


BY_RULE = Wishes()


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A fitted channel.

    Attributes
    ----------
    model : CalibrationModel
        That of the fit: without a curve over range where panels divide at their own range.
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

    @property
    def rows_fitted(self) -> PanelTable:
        """The rows as the fit saw them."""
        return relabel(self.table) if self.model.range_alone else self.table


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
    refuse_plateau(kept, wishes)
    refuse_wishes(model, wishes)
    model = divide_at_one_range(kept, model)
    refuse_model(kept, model)
    fixed = () if model.range_alone else _choose_fixed(kept, wishes)
    reference = _choose_range(kept, fixed, model, wishes)
    if model.range_alone:
        fit = fit_alone(kept, model, Ranging(reference, wishes.breaks), wishes.noise)
        return Calibration(
            model, wishes, kept, dark, saturated, (), reference, kept.scans[0], fit, None
        )  # fmt: skip
    refuse_powers(kept, model, fixed, wishes)
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
            f"{_name_all(len(table))} saturated, at {wishes.saturated:g} DN or above.",
            "Scan darker panels or farther away, or correct --saturated.",
        )
    if (dark | saturated).all():
        raise BadInput(
            f"{_name_all(len(table))} dark or saturated.",
            "Correct --dark and --saturated.",
        )
    return table.pick(~(dark | saturated)), int((dark & ~saturated).sum()), int(saturated.sum())


def _name_all(count: int) -> str:
    return "The only panel is" if count == 1 else f"All {count} panels are"


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
    effect a little beyond (`NO_EFFECT_WITHIN`), for nobody knows what range does there. A range
    effect alone has no power before it: it takes numbers to numbers.
    """
    table, fit, wishes = calibration.table, calibration.fit, calibration.wishes
    nearest, farthest = _choose_limits(calibration)
    steps, noise_part, panel_part = _choose_steps(calibration)
    return ChannelCalibration(
        channel=table.channel,
        steps=cast(tuple[AnyStep, ...], steps),
        wavelength_nm=table.wavelength_nm,
        dark=wishes.dark,
        saturated=wishes.saturated,
        nearest=nearest,
        farthest=farthest,
        reflectances=(float(table.reflectance.min()), float(table.reflectance.max())),
        noise=fit.noise,
        fit_covariance=() if fit.noise is None else _make_matrix(_widen(fit) * noise_part),
        panel_covariance=_make_matrix(panel_part),
        evidence=evidence,
    )


def _choose_steps(calibration: Calibration) -> tuple[tuple[Step, ...], Floats, Floats]:
    """Steps of the profile, and the covariances of their parameters."""
    fit = calibration.fit
    if calibration.model.range_alone:
        curve, covariance = keep_curve(fit)
        return (curve,), covariance, np.zeros_like(covariance)
    count, border = len(fit.found.step_names), ((1, 0), (1, 0))  # the power is sure
    noise_part = np.pad(fit.noise_covariance[:count, :count], border)
    panel_part = np.pad(fit.panel_covariance[:count, :count], border)
    return (Power(1.0), *fit.found.steps), noise_part, panel_part


def _widen(fit: JointFit) -> float:
    """What a covariance is multiplied by for the few residuals that its size was told by.

    A budget is read as that of a normal error. Few residuals are often small by chance, and a σ
    from them then is: with Student's t over its normal value, 1.96 σ of the profile is the
    95 % interval of the report.
    """
    if fit.scale == 1.0:  # a noise that was given, and that the residuals keep to: it is known
        return 1.0
    return (find_reach(fit.spare) / NORMAL_95) ** 2


def _choose_limits(calibration: Calibration) -> tuple[float | None, float | None]:
    distance = calibration.table.distance
    nearest, farthest = float(distance.min()), float(distance.max())
    if calibration.model.range_effect is None:
        return nearest * (1.0 - NO_EFFECT_WITHIN), farthest * (1.0 + NO_EFFECT_WITHIN)
    one = len(find_ranges(distance)) == 1  # a law of nature was chosen to leave that range
    return (None, None) if one else (nearest, farthest)


def _make_matrix(covariance: Floats) -> Matrix:
    """A covariance as plain numbers."""
    return tuple(tuple(map(float, row)) for row in covariance)


def _choose_fixed(table: PanelTable, wishes: Wishes) -> tuple[str, ...]:
    if wishes.same_power:
        return ()
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
