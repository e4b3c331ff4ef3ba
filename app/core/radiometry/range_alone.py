"""The range effect alone: panels whose reflectance nobody asks for, at many ranges.

The number of a panel is that of the first one, a shift of the panel's own, and the curve
(Balduzzi 2011, equation 7). So each panel is fitted as if it were a scan with a power of its
own behind a logarithm of fixed slope; only the curve is kept.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, cast

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.joint import JointFit, Undetermined, fit_jointly
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.models import CalibrationModel
from app.core.radiometry.nodes import Nodes, choose_nodes, take_every, take_nodes
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.profile import Noise
from app.core.radiometry.range_curve import PolynomialCurve, RangeCurve
from app.core.radiometry.start import Ranging, make_curve, orders_of, solve_linear
from app.core.radiometry.step import spread
from app.core.radiometry.unknowns import Unknowns


class Level(LogResponse, frozen=True):
    """The number of the first panel; its slope only carries the other panels' shifts."""

    free: ClassVar[tuple[str, ...]] = ("a1",)
    title: ClassVar[str] = "Level of a panel"

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        return np.ones((1, *spread(x, x, distance).shape))


def relabel(table: PanelTable) -> PanelTable:
    """Each panel as a scan of its own, of reflectance 1 and sure: its level is sought."""
    count = len(table)
    return replace(
        table, scan=table.panel, reflectance=np.ones(count), reflectance_sigma=np.zeros(count)
    )


def fit_alone(
    table: PanelTable, model: CalibrationModel, ranging: Ranging, noise: Noise | None = None
) -> JointFit:
    """Fit levels and curve.

    Raises
    ------
    BadInput
        The rows are too few, or panels share no range that would tie them together.
    WrongUse
        The reference range or a break lies outside the panels' ranges.
    """
    own = _mark_panels(table)
    curve = make_curve(_find_nodes(table, model, ranging, own), model, ranging.reference)
    found = solve_linear(np.vstack([curve.shares(table.distance), own]).T, table.dn)
    count = len(curve.ranges)
    shifts = np.array([0.0, *found[count:]])
    at = curve.ranges.index(ranging.reference)
    steep = float(np.ptp(table.dn)) or 1.0
    powers = 10.0 ** (shifts / steep)
    steps = (
        Level(steep, float(found[at])),
        curve.with_values(np.delete(found[:count] - found[at], at)),
    )
    sought = np.arange(len(powers)) > 0
    try:
        return fit_jointly(relabel(table), Unknowns(steps, table.panels, powers, sought), noise)
    except Undetermined as error:
        raise BadInput(
            "The panels do not tell the range effect everywhere.",
            "Scan at least one of them at all ranges.",
        ) from error


def keep_curve(fit: JointFit) -> tuple[RangeCurve, Floats]:
    """The curve of a fit, and the covariance of its levels from noise, (k, k)."""
    level, curve = fit.found.steps
    places = slice(len(level.names), len(level.names) + len(curve.names))
    return cast(RangeCurve, curve), fit.noise_covariance[places, places]


def predict_alone(
    table: PanelTable, panel: str, model: CalibrationModel, ranging: Ranging, noise: Noise | None
) -> Floats | None:
    """Corrected DN of a panel about their mean, with the curve of the others.

    None where the others tell no curve, or none at two rows of the panel.
    """
    mine = table.panel == panel
    if mine.all():
        return None
    try:
        curve = keep_curve(fit_alone(table.pick(~mine), model, ranging, noise))[0]
    except (BadInput, WrongUse):
        return None
    corrected = curve.invert(table.dn[mine], table.distance[mine])
    known = np.isfinite(corrected)
    return corrected - corrected[known].mean() if known.sum() > 1 else None


def _mark_panels(table: PanelTable) -> Floats:
    """Which rows are of each panel but the first, (panels - 1, n)."""
    return np.equal.outer(np.arange(1, len(table.panels)), table.index_panels()).astype(float)


def _find_nodes(table: PanelTable, model: CalibrationModel, ranging: Ranging, own: Floats) -> Nodes:
    """As in `start`; with one panel every range is a node, for the curve goes *through* it."""
    if ranging.breaks:
        return take_nodes(ranging.breaks, table.distance, ranging.reference)
    if not len(own):
        return take_every(table.distance, ranging.reference)
    size = float(np.sum((table.dn - table.dn.mean()) ** 2)) or 1.0

    def measure(curve: PolynomialCurve) -> float:
        columns = np.vstack([curve.shares(table.distance), own]).T
        return float(np.sum((columns @ solve_linear(columns, table.dn) - table.dn) ** 2)) / size

    return choose_nodes(
        table.distance, ranging.reference, "additive", measure, orders_of(model), len(own)
    )
