"""What the history calls each step; a change of parameters says which one and to what."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from PySide6.QtCore import QCoreApplication

from app.core.phase import MODELS
from app.core.radiometry.profile import Profile
from app.core.units import to_mm
from app.model.operations import AnyOperation, SetParameters, describe_parameters
from app.model.parameters import Beam, Curve, Parameters
from app.services.beams import describe_beam
from widgets.common.channel_titles import title_corrections, title_footprint, title_formulas


def title_steps(steps: Iterable[AnyOperation]) -> list[str]:
    """Titles of steps, oldest first, which must begin with the first of the session."""
    before: dict[str, Parameters] = {}
    titles = []
    for step in steps:
        if isinstance(step, SetParameters):
            old = before.get(step.scan, Parameters())
            titles.append(title_parameters(old, step.parameters) or step.title)
            before[step.scan] = step.parameters
        else:
            titles.append(step.title)
    return titles


def title_parameters(old: Parameters, new: Parameters) -> str:
    """What changed between two sets of parameters; empty when nothing did."""
    changes = describe_parameters(old, new)
    return ", ".join(_title(name, *pair) for name, pair in changes.items())


def _title(name: str, old: Any, value: Any) -> str:
    match name:
        case "corrections":
            return title_corrections(old, value)
        case "formulas":
            return title_formulas(old, value)
        case "synthetic_footprint":
            return title_footprint(value)
        case _:
            return _title_angles(name, value)


def _title_angles(name: str, value: object) -> str:
    match name, value:
        case "curve", Curve():
            model = MODELS[value.model].title if value.model in MODELS else value.model
            return _tr("Use curve {model} ({origin})").format(model=model, origin=value.origin)
        case "curve", _:
            return _tr("Use no curve")
        case "ghost_threshold", float():
            return _tr("Set ghost threshold to {value}").format(value=f"{value:.2f}")
        case "radius", float():
            return _tr("Set neighbour radius to {value} mm").format(value=f"{to_mm(value):g}")
        case "plane_gate", float():
            return _tr("Set plane gate to {value} mm").format(value=f"{to_mm(value):g}")
        case "channel", _:
            return _tr("Use channel {value}").format(value=value or _tr("first"))
        case "estimator", _:
            return _tr("Find angles by estimator {value}").format(value=value)
        case "beam", _:
            beam = describe_beam(value) if isinstance(value, Beam) else _tr("unknown")
            return _tr("Set beam: {value}").format(value=beam)
        case _:
            return _title_radiometry(name, value)


def _title_radiometry(name: str, value: object) -> str:
    match name, value:
        case "profile", Profile():
            return _tr("Use profile {value}").format(value=value.name)
        case "profile", _:
            return _tr("Use no profile")
        case "powers", tuple():
            said = ", ".join(f"{power.value:.3g}" for power in value) or "1"
            return _tr("Set laser power to {value}").format(value=said)
        case "partial_hits", bool():
            return _tr("Use partial hits too") if value else _tr("Use full hits only")
        case _:
            return _tr("Set {name}").format(name=name)


def _tr(text: str) -> str:
    return QCoreApplication.translate("StepTitles", text)
