"""Fields that rest on the angular curve in use: the angle from intensity, and what it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.core.arrays import Ints
from app.core.errors import BadInput
from app.core.units import to_degrees, to_radians
from app.model.fields import Computed, Evaluation, FieldSpec
from app.model.parameters import Curve
from app.model.scan import Channel


def curve_fields(
    curve: Curve | None, channels: Sequence[Channel], units: dict[str, str]
) -> list[FieldSpec]:
    """The angle from intensity and the residual, for the channel of the curve in use.

    Parameters
    ----------
    curve : Curve or None
    channels : sequence of Channel
        All that the scan has, calibrated and corrected ones too.
    units : dict of str to str
        Unit of each kind of channel.
    """
    kinds = {channel.name: channel.kind for channel in channels}
    if curve is None or curve.channel not in kinds:
        return [ANGLE, RESIDUAL]
    return [
        replace(ANGLE, inputs=(curve.channel,)),
        replace(
            RESIDUAL,
            title=f"Residual of the curve, {curve.channel}",
            unit=units[kinds[curve.channel]],
            inputs=(*RESIDUAL.inputs, curve.channel),
        ),
    ]


def compute_incidence_from_intensity(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Angle whose intensity on the fitted curve is the point's, degrees; NaN where none is."""
    curve = _curve_in_use(evaluation, "the angle from intensity")
    intensity = evaluation.read(curve.channel, points)
    angles = curve.angular_model.inverse(intensity, curve.values, curve.within)
    return Computed(to_degrees(angles), {"curve": curve.model, "origin": curve.origin})


def compute_residual(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Value less the curve at the point's angle; NaN without either, and beyond the curve."""
    curve = _curve_in_use(evaluation, "the residual of a curve")
    value = evaluation.read(curve.channel, points)
    angle = to_radians(evaluation.read("incidence", points))
    model, (low, high) = curve.angular_model, curve.within
    with np.errstate(invalid="ignore"):
        inside = model.accepts(angle) & (angle >= low) & (angle <= high)
    residual = np.full(len(value), np.nan)
    residual[inside] = value[inside] - model.evaluate(angle[inside], curve.values)
    known = residual[np.isfinite(residual)]
    notes: dict[str, object] = {"curve": curve.model, "origin": curve.origin}
    notes["rms"] = float(np.sqrt((known**2).mean())) if len(known) else None
    notes["undefined"] = len(residual) - len(known)
    return Computed(residual, notes)


def _curve_in_use(evaluation: Evaluation, needed_for: str) -> Curve:
    state = evaluation.subject.state
    state.channel_in_use(needed_for)
    curve = state.parameters.curve
    if curve is None:
        raise BadInput(
            f"No angular curve is in use, and {needed_for} needs one.",
            "Fit a leaf in the phase lab and press 'Use this curve'.",
        )
    state.channel(curve.channel)
    return curve


ANGLE = FieldSpec(
    "incidence_from_intensity",
    "Angle from intensity",
    "°",
    "angle",
    compute_incidence_from_intensity,
    parameters=("curve", "channel"),
    needs=("channels",),
)
RESIDUAL = FieldSpec(
    "residual",
    "Residual of the curve",
    "",
    "signed",
    compute_residual,
    ("incidence",),
    ("curve",),
    ("pose", "channels"),
)
