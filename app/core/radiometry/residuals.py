"""How well a calibration gives back its own panels, and panels that it did not see."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.calibration import Calibration
from app.core.radiometry.joint import fit_jointly
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.profile import Evidence
from app.core.radiometry.range_alone import predict_alone
from app.core.radiometry.start import Ranging
from app.core.radiometry.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class MaterialScore:
    """Errors of one panel, in reflectance unless they are called DN.

    Where the range effect was fitted alone all are DN: of the corrected number about the panel's
    own level, and for a panel that was left out about the mean of its corrected numbers.

    Attributes
    ----------
    panel : str
    reflectance : float
    rows : int
        Rows that gave a reflectance.
    rmse, bias : float
        Found less true.
    dn_rmse, dn_bias : float
        Measured less fitted.
    left_out_rmse, left_out_bias : float or None
        From a fit without this panel; None where the others do not determine the model.
    """

    panel: str
    reflectance: float
    rows: int
    rmse: float
    bias: float
    dn_rmse: float
    dn_bias: float
    left_out_rmse: float | None
    left_out_bias: float | None


def recover_reflectance(unknowns: Unknowns, table: PanelTable) -> Floats:
    """Reflectance of each row from its DN, range and scan, (n,); NaN where there is none."""
    light = chains.invert(unknowns.steps, table.dn, table.distance)
    known = {scan: power for scan, power in zip(unknowns.scans, unknowns.powers, strict=True)}
    power = np.array([known.get(scan, np.nan) for scan in table.scan.tolist()])
    return np.asarray(light / power)


def find_errors(calibration: Calibration) -> Floats:
    """Found less true of each row, reflectance or, without a response, DN, (n,)."""
    if calibration.model.range_alone:
        return calibration.fit.residual
    table = calibration.table
    return recover_reflectance(calibration.fit.found, table) - table.reflectance


def score_materials(calibration: Calibration) -> tuple[MaterialScore, ...]:
    """RMSE and bias of each panel, with and without it in the fit."""
    table, fit = calibration.table, calibration.fit
    error = find_errors(calibration)
    scores = []
    for panel in table.panels:
        mine = table.panel == panel
        away, without = error[mine], predict_left_out(calibration, panel)
        scores.append(
            MaterialScore(
                panel,
                float(table.reflectance[mine][0]),
                int(np.isfinite(away).sum()),
                root_mean_square(away),
                mean(away),
                root_mean_square(fit.residual[mine]),
                mean(fit.residual[mine]),
                None if without is None else root_mean_square(without),
                # About their own mean there is none.
                None if without is None or calibration.model.range_alone else mean(without),
            )
        )
    return tuple(scores)


def predict_left_out(calibration: Calibration, panel: str) -> Floats | None:
    """Errors of a panel's reflectances from a fit without it; None where there is no such fit."""
    table, fit = calibration.table, calibration.fit
    if calibration.model.range_alone:
        ranging = Ranging(calibration.reference_range, calibration.wishes.breaks)
        return predict_alone(table, panel, calibration.model, ranging, fit.noise)
    mine = table.panel == panel
    others = table.pick(~mine)
    if not len(others):
        return None
    try:
        found = fit_jointly(others, restrict_scans(fit.found, others), fit.noise).found
    except BadInput:
        return None
    error = recover_reflectance(found, table.pick(mine)) - table.reflectance[mine]
    return error if np.isfinite(error).any() else None


def restrict_scans(unknowns: Unknowns, table: PanelTable) -> Unknowns:
    """The same unknowns for a table with fewer scans."""
    places = [unknowns.scans.index(scan) for scan in table.scans]
    powers, sought = unknowns.powers[places], unknowns.sought[places]
    return replace(unknowns, scans=table.scans, powers=powers, sought=sought)


def gather_evidence(calibration: Calibration, scores: tuple[MaterialScore, ...]) -> Evidence:
    """What the profile tells about how the calibration was made."""
    table = calibration.table
    error = find_errors(calibration)
    outside = [score for score in scores if score.left_out_rmse is not None]
    squares = sum(score.rows * (score.left_out_rmse or 0.0) ** 2 for score in outside)
    rows = sum(score.rows for score in outside)
    return Evidence(
        rows=len(table),
        left_out=calibration.dark + calibration.saturated,
        panels=table.panels,
        rmse=root_mean_square(error),
        bias=mean(error),
        left_out_rmse=float(np.sqrt(squares / rows)) if rows else None,
    )


def root_mean_square(values: Floats) -> float:
    """Of the finite values; NaN if there are none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def mean(values: Floats) -> float:
    """Of the finite values; NaN if there are none."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")
