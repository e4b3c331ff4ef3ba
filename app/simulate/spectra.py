"""Named materials over wavelength: knots in resources/materials, straight lines between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import msgspec
import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.simulate.ready_files import find_ready

WETTEST = 1.5
"""Water of a leaf, as a share of a fresh leaf's, up to which its spectrum is believed."""


class Spectrum(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A material file.

    Attributes
    ----------
    title, source : str
    model : str
        A phase function of `app.core.phase`.
    wavelengths_nm : tuple of float
        The knots, rising.
    rho : tuple of float
        Reflectance factor at ω = 0, one per knot.
    parameters : mapping of str to tuple of float
        Those of the phase function, one value per knot.
    dry : str
        The material that it becomes without water; empty: water does not matter.
    """

    title: str
    source: str
    wavelengths_nm: tuple[float, ...]
    rho: tuple[float, ...]
    model: str = "lambert"
    parameters: dict[str, tuple[float, ...]] = {}
    dry: str = ""

    def __post_init__(self) -> None:
        if not self.wavelengths_nm or (np.diff(self.wavelengths_nm) <= 0).any():
            raise ValueError("`wavelengths_nm` must rise")
        for name, column in {"rho": self.rho, **self.parameters}.items():
            if len(column) != len(self.wavelengths_nm):
                raise ValueError(f"`{name}` needs one value for each of `wavelengths_nm`")


@dataclass(frozen=True, slots=True, eq=False)
class Optics:
    """A material at the wavelengths of an instrument: `rho` and each parameter (channels,)."""

    rho: Floats
    model: str
    parameters: dict[str, Floats]


def list_materials() -> tuple[str, ...]:
    """Names of the materials there are."""
    return tuple(sorted(find_ready("materials")))


@lru_cache(maxsize=64)
def get_spectrum(name: str) -> Spectrum:
    """The material of that name; raises `BadInput` with the names there are."""
    materials = find_ready("materials")
    if name not in materials:
        known = ", ".join(sorted(materials))
        raise BadInput(f"There is no material {name!r}.", f"Materials: {known}; or give a number.")
    return msgspec.toml.decode(materials[name].read_text("utf-8"), type=Spectrum)


def read_off(knots_nm: Floats, values: Floats, wavelengths_nm: Floats, what: str) -> Floats:
    """Values at other wavelengths, on straight lines between the knots.

    Raises
    ------
    BadInput
        A wavelength lies outside the knots.
    """
    outside = (wavelengths_nm < knots_nm[0]) | (wavelengths_nm > knots_nm[-1])
    if outside.any():
        nm = wavelengths_nm[outside][0]
        raise BadInput(
            f"{what} is known from {knots_nm[0]:g} to {knots_nm[-1]:g} nm, not at {nm:g} nm.",
            "Take another instrument, or give the reflectance at its wavelengths.",
        )
    return np.interp(wavelengths_nm, knots_nm, values)


def optics_at(name: str, wavelengths_nm: Floats, water: float = 1.0) -> Optics:
    """A named material at some wavelengths and with some of its water.

    Water absorbs, so that reflectance falls about exponentially with it: between the dry (0) and
    the fresh leaf (1) log ρ is taken as linear in water, and so are the parameters of the phase
    function. A leaf a little wetter than fresh lies on the same line.

    Parameters
    ----------
    name : str
    wavelengths_nm : (channels,) array
    water : float
        Share of a fresh leaf's water, 0 to 1.5.

    Raises
    ------
    BadInput
        The material is unknown, or not at these wavelengths.
    WrongUse
        `water` is out of range.
    """
    if not 0 <= water <= WETTEST:
        raise WrongUse(
            f"A leaf cannot have {water:g} of a fresh leaf's water.",
            f"Give a share from 0 to {WETTEST:g}.",
        )
    spectrum = get_spectrum(name)
    fresh = _interpolate(name, spectrum, wavelengths_nm)
    if not spectrum.dry or water == 1.0:
        return fresh
    dry = _interpolate(spectrum.dry, get_spectrum(spectrum.dry), wavelengths_nm)
    return replace(
        fresh,
        rho=fresh.rho**water * dry.rho ** (1 - water),
        parameters={
            key: np.clip(water * values + (1 - water) * dry.parameters[key], 1e-3, 1.0)
            for key, values in fresh.parameters.items()
        },
    )


def _interpolate(name: str, spectrum: Spectrum, wavelengths_nm: Floats) -> Optics:
    knots, what = np.array(spectrum.wavelengths_nm), f"The material {name}"
    return Optics(
        read_off(knots, np.array(spectrum.rho), wavelengths_nm, what),
        spectrum.model,
        {
            key: read_off(knots, np.array(values), wavelengths_nm, what)
            for key, values in spectrum.parameters.items()
        },
    )
