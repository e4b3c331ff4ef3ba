"""Published curves of species, by name and wavelength."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from app.core.errors import WrongUse
from app.core.phase import get_model

KAASALAINEN_NM = (564.3, 610.8, 659.9, 720.3, 764.8, 818.0, 878.6, 979.2)
"""Centres of channels 1 to 8."""
ROSES_NM = (555.0, 624.0, 691.0, 726.0, 760.0, 795.0, 899.0, 1000.0)
ROSES = ("China rose", "ZGem", "rose")
NEAR_NM = 60.0
"""A curve farther away than this is said to be of another wavelength."""
MODEL = "lambert-beckmann"


@dataclass(frozen=True, slots=True)
class SpeciesCurve:
    """The shape of a published curve; its height is no part of what is printed.

    Attributes
    ----------
    species : str
    wavelength_nm : float
    values : mapping of str to float
        k_d and m of Lambert–Beckmann.
    source : str
    """

    species: str
    wavelength_nm: float
    values: Mapping[str, float]
    source: str

    @property
    def title(self) -> str:
        """Species, wavelength and paper, in a line."""
        return f"{self.species}, {self.wavelength_nm:g} nm ({self.source})"


def list_species_curves() -> tuple[SpeciesCurve, ...]:
    """All that is printed, in the order of the papers."""
    found = []
    for reference in get_model(MODEL).references:
        species, _, channel = reference.sample.partition(", ")
        if channel.startswith("channel "):
            row = ROSES_NM if species in ROSES else KAASALAINEN_NM
            nm = row[int(channel.split()[1]) - 1]
        else:
            nm = float(channel.split()[1])
        paper = reference.source.split(",")[0]
        found.append(SpeciesCurve(species, nm, reference.values, paper))
    return tuple(found)


def find_species_curve(species: str, wavelength_nm: float | None) -> SpeciesCurve:
    """The printed curve of a species whose wavelength is nearest.

    Raises
    ------
    WrongUse
        The species is not printed, the channel's wavelength is unknown or far from all of them.
    """
    curves = list_species_curves()
    of_it = [curve for curve in curves if curve.species.casefold() == species.casefold()]
    if not of_it:
        names = ", ".join(dict.fromkeys(curve.species for curve in curves))
        raise WrongUse(f"There is no published curve of {species!r}.", f"Species: {names}.")
    if wavelength_nm is None:
        raise WrongUse(
            f"The wavelength of the channel is unknown, and curves of {species} depend on it.",
            "Name it: --channel NAME=WAVELENGTH:KIND.",
        )
    nearest = min(of_it, key=lambda curve: abs(curve.wavelength_nm - wavelength_nm))
    if abs(nearest.wavelength_nm - wavelength_nm) > NEAR_NM:
        there = ", ".join(f"{curve.wavelength_nm:g}" for curve in of_it)
        raise WrongUse(
            f"Curves of {species} are printed for {there} nm, none within {NEAR_NM:g} nm of "
            f"{wavelength_nm:g} nm.",
            "Take a goniometer table, or the leaf itself.",
        )
    return nearest
