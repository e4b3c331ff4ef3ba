"""From what a scene file calls a material to reflectance and phase function per channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.simulate.material import Material, Sheen, matt
from app.simulate.prospect import Prospect, reflect
from app.simulate.spectra import Optics, optics_at, read_off

Rho = Annotated[float, Meta(ge=0, le=2)]
ByWavelength = float | dict[str, float]
"""One number for all wavelengths, or knots such as {"1063" = 0.48, "1545" = 0.27}."""


class Recipe(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A material written out in a scene file.

    Attributes
    ----------
    like : str
        A named material that gives what is not said here; empty: a matt surface.
    rho : float or mapping of wavelength to float, optional
        Reflectance factor at ω = 0 of a fresh leaf.
    model : str
        A phase function of `app.core.phase`; its `parameters` are then all to be given.
    parameters : mapping of str to (float or mapping of wavelength to float)
    prospect : Prospect, optional
        Gives rho; the phase function is that of `like`, or of a fresh leaf.
    """

    like: str = ""
    rho: Rho | dict[str, Rho] | None = None
    model: str = ""
    parameters: dict[str, ByWavelength] = {}
    prospect: Prospect | None = None


AnyMaterial = str | Rho | Recipe
"""A name, the reflectance of a matt surface, or a recipe."""


def material_at(
    material: AnyMaterial, wavelengths_nm: tuple[float, ...], water: float = 1.0
) -> Material:
    """A material at the wavelengths of an instrument.

    Parameters
    ----------
    material : str, float or Recipe
    wavelengths_nm : tuple of float
    water : float
        Share of a fresh leaf's water, 0 to 1.5; for materials that dry (see `optics_at`).

    Raises
    ------
    BadInput
        A name, model or parameter does not exist or is missing, or a wavelength lies outside
        what is known.
    """
    nm = np.array(wavelengths_nm, float)
    if isinstance(material, str):
        optics = optics_at(material, nm, water)
    elif isinstance(material, Recipe):
        optics = _follow(material, nm, water)
    else:
        return (matt(material),) * len(nm)
    names = tuple(optics.parameters)
    columns = zip(*optics.parameters.values(), strict=True) if names else [()] * len(nm)
    return tuple(
        Sheen(float(rho), optics.model, tuple(zip(names, map(float, values), strict=True)))
        for rho, values in zip(optics.rho, columns, strict=True)
    )


def brighten(material: Material, factor: float) -> Material:
    """The material with its reflectance multiplied in every channel."""
    return tuple(replace(sheen, rho=sheen.rho * factor) for sheen in material)


def _follow(recipe: Recipe, nm: Floats, water: float) -> Optics:
    optics = _begin(recipe, nm, water)
    if recipe.prospect is not None:
        optics = replace(optics, rho=reflect(recipe.prospect, nm, water))
    elif recipe.rho is not None:
        drying = optics.rho / _begin(recipe, nm, 1.0).rho
        optics = replace(optics, rho=_spread(recipe.rho, nm, "rho") * drying)
    elif not recipe.like:
        raise BadInput(
            "A material says neither `rho` nor `like` nor `prospect`.", "Give one of them."
        )
    if recipe.model and recipe.model != optics.model:
        optics = replace(optics, model=recipe.model, parameters={})
    if recipe.model or recipe.parameters:
        values = {key: _spread(value, nm, key) for key, value in recipe.parameters.items()}
        optics = replace(optics, parameters=optics.parameters | values)
        check_phase(optics.model, optics.parameters)
    return optics


def _begin(recipe: Recipe, nm: Floats, water: float) -> Optics:
    """What the recipe builds on."""
    if recipe.like or recipe.prospect is not None:
        return optics_at(recipe.like or "leaf", nm, water)
    return Optics(np.ones(len(nm)), "lambert", {})


def _spread(value: ByWavelength, nm: Floats, what: str) -> Floats:
    """A value at each wavelength."""
    if not isinstance(value, dict):
        return np.full(len(nm), value)
    try:
        knots = sorted((float(key), number) for key, number in value.items())
    except ValueError as error:
        raise BadInput(
            f"{what} has a wavelength that is no number.",
            'Write wavelengths in nm, such as {"1063" = 0.48, "1545" = 0.27}.',
        ) from error
    if not knots:
        raise BadInput(f"{what} names no wavelength.", 'Write such as {"1063" = 0.48}.')
    places, numbers = np.array(knots).T
    return read_off(places, numbers, nm, what)


def check_phase(name: str, parameters: Mapping[str, Floats]) -> None:
    """Refuse parameters that the phase function does not have, lacks or forbids.

    One that only scales the curve may be left out.

    Raises
    ------
    BadInput
        With the parameter's name.
    WrongUse
        There is no such phase function.
    """
    from app.core.phase import get_model

    model = get_model(name)
    known = {p.name: p for p in model.parameters}
    scales = [p.name for p in model.parameters if p.scales]
    spare = set(scales) if len(scales) == 1 else set()
    for key in parameters.keys() - known.keys():
        raise BadInput(f"{name} has no parameter {key!r}.", f"It has: {', '.join(known)}.")
    for key in sorted(known.keys() - parameters.keys() - spare):
        raise BadInput(f"{name} needs the parameter {key}: {known[key].meaning}.", "Give it.")
    for key, values in parameters.items():
        low, high = known[key].lower, known[key].upper
        if not ((values >= low) & (values <= high)).all():
            raise BadInput(
                f"{key} of {name} must lie between {low:g} and {high:g}.", known[key].meaning
            )
