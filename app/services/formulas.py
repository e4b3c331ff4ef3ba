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


def put_formula(project: Project, scan: str, formula: Formula, instead_of: str = "") -> list[Pick]:
    """Put one formula to use, in the place of another one if it is renamed; one step.

    Raises
    ------
    WrongUse
        The name is none that a formula can name, or is taken.
    MissingChannel
        A channel that the formula names is not there.
    """
    parameters = project.state.scan(scan).parameters
    check_name(project, scan, formula.name, instead_of)
    picks = pick_channels(project, scan, formula.text)
    old = instead_of or formula.name
    if any(each.name == old for each in parameters.formulas):
        new = tuple(formula if each.name == old else each for each in parameters.formulas)
    else:
        new = (*parameters.formulas, formula)
    project.do(SetParameters(scan, replace(parameters, formulas=new)))
    return list(picks)


def check_name(project: Project, scan: str, name: str, own: str = "") -> None:
    """Refuse (`WrongUse`) a name for an index that is none or is taken; `own` is free."""
    if not (name.isidentifier() and name.isascii()):
        raise WrongUse(
            f"{name!r} is no name of an index." if name else "The index has no name.",
            "Letters, digits and _ make a name; a letter comes first.",
        )
    if name != own and name in project.catalogue(scan):
        raise WrongUse(f"{name} is a field already.", "Choose another name.")


def remove_formula(project: Project, scan: str, name: str) -> None:
    """Take a formula out of use, as one step."""
    parameters = project.state.scan(scan).parameters
    kept = tuple(formula for formula in parameters.formulas if formula.name != name)
    if len(kept) == len(parameters.formulas):
        raise WrongUse(f"There is no index {name} to remove.")
    project.do(SetParameters(scan, replace(parameters, formulas=kept)))


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
