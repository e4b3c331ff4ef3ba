"""A user's own indices: formulas over channels or wavelengths, put to use on a scan."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from app.core.errors import WrongUse
from app.core.formula_wavelengths import Pick, resolve_formula
from app.model.operations import SetParameters
from app.model.parameters import Formula
from app.model.project import Project

EXAMPLE = "Write NAME=FORMULA, e.g. mine=(r1063 - r1545) / (r1063 + r1545)."


def use_formula_texts(project: Project, scan: str, texts: Sequence[str]) -> list[Pick]:
    """Put formulas, ``NAME=FORMULA``, to use as one step; give the channels that were picked.

    Raises
    ------
    WrongUse
        A text is no formula, or its name is a field already.
    MissingChannel
        A channel that it names is not there.
    """
    return use_formulas(project, scan, [_parse(text) for text in texts])


def use_formulas(project: Project, scan: str, formulas: Sequence[Formula]) -> list[Pick]:
    """Put formulas to use beside those in use, replacing those of the same name; one step."""
    parameters = project.state.scan(scan).parameters
    own = {formula.name for formula in parameters.formulas}
    picks: list[Pick] = []
    for formula in formulas:
        if formula.name not in own and formula.name in project.catalogue(scan):
            raise WrongUse(f"{formula.name} is a field already.", "Choose another name.")
        picks += pick_channels(project, scan, formula.text)
    new = {formula.name for formula in formulas}
    kept = tuple(formula for formula in parameters.formulas if formula.name not in new)
    project.do(SetParameters(scan, replace(parameters, formulas=(*kept, *formulas))))
    return picks


def pick_channels(project: Project, scan: str, text: str) -> tuple[Pick, ...]:
    """The channels that a formula's wavelengths stand for, with their distance in nm."""
    state = project.state.scan(scan)
    names = [channel.name for channel in state.channels]
    return resolve_formula(text, state.wavelengths, names).picks


def tell_picks(project: Project, scan: str, fields: Sequence[str]) -> list[str]:
    """Which channels the wavelengths of computed formulas stand for, in sentences."""
    formulas = project.state.scan(scan).parameters.formulas
    asked = [
        formula for formula in formulas if any(name.startswith(formula.name) for name in fields)
    ]
    return [
        f"{formula.name}: {pick.words}."
        for formula in asked
        for pick in pick_channels(project, scan, formula.text)
    ]


def _parse(text: str) -> Formula:
    name, equals, formula = text.partition("=")
    if not equals or not name.strip().isidentifier() or formula.startswith("="):
        raise WrongUse(f"{text!r} says no index.", EXAMPLE)
    return Formula(name.strip(), formula.strip())
