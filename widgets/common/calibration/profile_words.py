"""What there is to say about profiles, reflectances and their marks, in words."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QCoreApplication

from app.core.arrays import Bools
from app.core.radiometry.drift import Power
from app.core.radiometry.marks import WORDS
from app.core.radiometry.profile import ChannelCalibration
from app.model.fields import Values
from widgets.common.numbers import show_number

Counts = dict[str, int]


def count_marks(known: Values, alive: Bools) -> Counts:
    """How many points are good or not, by the words of their marks, most first."""
    marks = known.beside["mark"][known.have & alive]
    counts = np.bincount(marks.astype(np.int64), minlength=len(WORDS))
    found = {word: int(n) for word, n in zip(WORDS, counts, strict=True) if n}
    return dict(sorted(found.items(), key=lambda pair: -pair[1]))


def describe_channel(calibration: ChannelCalibration) -> str:
    """A calibrated channel in a few lines: its steps, where it holds, how well it was fitted."""
    steps = [step.title for step in calibration.steps if step.title and not is_power(step)]
    lines = [" · ".join(steps), describe_limits(calibration)]
    evidence = calibration.evidence
    if evidence is not None:
        fitted = _tr("RMSE {rmse} over {n} rows").format(
            rmse=show_share(evidence.rmse), n=evidence.rows
        )
        if evidence.left_out_rmse is not None:
            left_out = _tr("panels left out: {rmse}")
            fitted += ", " + left_out.format(rmse=show_share(evidence.left_out_rmse))
        lines.append(fitted)
    if knows_no_sigma(calibration):
        lines.append(_tr("its σ is not known"))
    return "\n".join(line for line in lines if line)


def describe_limits(calibration: ChannelCalibration) -> str:
    """Reflectances, ranges and numbers between which a calibration holds."""
    parts = []
    if calibration.reflectances is not None:
        low, high = (f"{100.0 * value:.3g}" for value in calibration.reflectances)
        parts.append(_tr("panels of {low} to {high} %").format(low=low, high=high))
    near, far = calibration.nearest, calibration.farthest
    if near is not None and far is not None:
        parts.append(f"{show_number(near, 2)} … {show_number(far, 2)} m")
    if calibration.saturated is not None:
        parts.append(_tr("saturated from {dn}").format(dn=f"{calibration.saturated:g} DN"))
    return ", ".join(parts)


def knows_no_sigma(calibration: ChannelCalibration) -> bool:
    """Whether a profile leaves a part of its errors untold, so that there is no σ."""
    told = calibration.fit_covariance and calibration.panel_covariance
    return calibration.noise is None or bool(calibration.free and not told)


def is_power(step: object) -> bool:
    """Whether a step is the laser's power, which each scan has for itself."""
    return isinstance(step, Power)


def show_share(value: float) -> str:
    """A reflectance, or a difference of two, in percent."""
    return f"{show_number(100.0 * value, 2 if abs(value) < 0.1 else 1)} %"


def title_channel(calibration: ChannelCalibration) -> str:
    """A calibrated channel in short."""
    nm = calibration.wavelength_nm
    return calibration.name if nm is None else f"{nm:g} nm"


def _tr(text: str) -> str:
    return QCoreApplication.translate("ProfileWords", text)
