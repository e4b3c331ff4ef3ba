"""What a calibration refuses before it fits: tables and wishes that do not go with a model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.core.errors import BadInput, WrongUse
from app.core.radiometry.models import LEAST_PANELS, LEAST_RANGES, CalibrationModel
from app.core.radiometry.nodes import find_ranges
from app.core.radiometry.panels import SAME_RANGE, PanelTable

if TYPE_CHECKING:
    from app.core.radiometry.calibration import Wishes

BELOW_NOISE = 0.01
"""Share of the largest DN below zero that noise may reach."""
SIGMAS_BELOW = 5.0


def refuse_plateau(table: PanelTable, wishes: Wishes) -> None:
    """Refuse numbers that stopped rising: an end of the scale that nobody told."""
    top = table.dn == table.dn.max()
    differ = float(np.ptp(table.reflectance)) > 0 or len(find_ranges(table.distance)) > 1
    if top.all() and len(table) > 1 and differ:
        raise BadInput(
            f"All {len(table)} rows have {table.dn[0]:g} DN, as if saturated.",
            "Check the column of the DN, and scan darker panels or farther away.",
        )
    if wishes.saturated is not None:
        return
    rows = table.pick(top)
    near = np.abs(np.subtract.outer(rows.distance, rows.distance)) <= SAME_RANGE
    same = near & np.equal.outer(rows.scan, rows.scan)
    alike = np.argwhere(same & np.not_equal.outer(rows.reflectance, rows.reflectance))
    if len(alike):
        one, other = rows.panel[alike[0]].tolist()
        raise BadInput(
            f"The panels {one} and {other} have the same highest DN, {rows.dn[0]:g}, as if"
            " saturated.",
            f"Leave such rows out with --saturated {rows.dn[0]:g}, or give a higher DN if they are"
            " not.",
        )


def refuse_wishes(model: CalibrationModel, wishes: Wishes) -> None:
    """Refuse options that a model has no use for."""
    if wishes.breaks and not model.fits_curve:
        raise WrongUse(
            f"The model {model.name} has no pieces that could meet.",
            "Leave --break-at out, or choose +polynomial or +spline.",
        )
    if wishes.reference_range is not None and model.range_effect is None:
        raise WrongUse(
            f"The model {model.name} has no range effect, and no reference range.",
            "Leave --reference-range out, or choose a model with a range effect.",
        )
    if model.range_alone and (wishes.fixed_panels or wishes.reference_scan is not None):
        raise WrongUse(
            f"The model {model.name} alone measures no power.",
            "Leave --fixed-panel and --reference-scan out.",
        )
    if wishes.same_power and wishes.fixed_panels:
        raise WrongUse(
            "Fixed panels measure a power that is said to be the same.",
            "Leave --fixed-panel or --same-power out.",
        )


def divide_at_one_range(table: PanelTable, model: CalibrationModel) -> CalibrationModel:
    """Without the curve where all panels are at one range, at which numbers are divided by them."""
    divides = model.response.name == "proportional" and model.fits_curve
    if divides and len(find_ranges(table.distance)) == 1:
        return CalibrationModel(model.response, None)
    return model


def refuse_powers(
    table: PanelTable, model: CalibrationModel, fixed: tuple[str, ...], wishes: Wishes
) -> None:
    """Refuse SALCA's response with powers that nothing tells: they look like its m and k."""
    if model.response.name != "salca" or wishes.same_power or fixed or len(table.scans) < 2:
        return
    raise BadInput(
        f"The table has {len(table.scans)} scans and no panel that all of them saw at one range:"
        " SALCA's response and the laser's power cannot be told apart.",
        "Scan a fixed panel in every scan, or say that the power did not change (--same-power).",
    )


def refuse_model(table: PanelTable, model: CalibrationModel) -> None:
    """Refuse a table that has too little for the model, or numbers that it cannot give."""
    shades = len(np.unique(table.reflectance))
    least = LEAST_PANELS[model.response.name]
    if shades < least:
        raise BadInput(
            f"{model.response.title} needs panels of {least} reflectances; the table has {shades}"
            " that can be used.",
            f"For the range effect alone: --model {model.range_effect.name}."
            if model.range_scale == "additive" and model.fits_curve and model.range_effect
            else "Add panels, or choose a simpler model.",
        )
    if model.range_effect is not None and model.fits_range:
        places, least = len(find_ranges(table.distance)), LEAST_RANGES[model.range_effect.name]
        if places == 1:
            raise BadInput(
                f"All panels are at {table.distance[0]:g} m, so that the table says nothing about"
                " the range.",
                "Scan it at other ranges."
                if model.range_alone
                else f"Choose a model without range: --model {model.response.name}.",
            )
        if places < least:
            raise BadInput(
                f"{model.range_effect.title} needs panels at {least} ranges; the table has"
                f" {places}.",
                "Add ranges, or choose another range effect.",
            )
    if model.response.name in ("salca", "proportional"):
        _refuse_negative(table, model)


def _refuse_negative(table: PanelTable, model: CalibrationModel) -> None:
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
