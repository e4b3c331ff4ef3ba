"""What is published about instruments, for calibrating and for the list of profiles."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.core.errors import WrongUse
from app.core.radiometry.calibration import Wishes
from app.services.panel_columns import TableOptions
from app.services.profiles import name_profiles
from app.simulate.detector import scale_of
from app.simulate.instrument import Instrument, list_instruments

MODELS = {
    "ls880": "balduzzi",
    "x330": "junttila-log",
    "hds6100": "junttila-linear",
    "salca": "hancock",
    "hsl": "kaasalainen",
}
"""How the papers calibrated their instruments."""
LEFT_OUT = ("two_colour", "pulsed", "ls880_filtered")
"""Made up for teaching; or the same instrument with a filter, which changes no intensity."""


@dataclass(frozen=True, slots=True)
class InstrumentFacts:
    """An instrument of the papers, as far as it is published.

    Attributes
    ----------
    name, title : str
    wavelengths_nm : tuple of float
    model : str
        How its paper calibrated it; see `app.core.radiometry.models`.
    dark, saturated : float or None
        The two ends of its scale, DN.
    profiles : tuple of str
        Names of published profiles that come with the program.
    notes : tuple of str
        What is published, in words.
    """

    name: str
    title: str
    wavelengths_nm: tuple[float, ...]
    model: str
    dark: float | None
    saturated: float | None
    profiles: tuple[str, ...]
    notes: tuple[str, ...]


def list_facts() -> tuple[InstrumentFacts, ...]:
    """Every instrument of the papers."""
    return tuple(_tell(tool) for tool in list_instruments() if tool.name not in LEFT_OUT)


def find_facts(name: str) -> InstrumentFacts | None:
    """The instrument of that name; None for one that no paper of ours used."""
    return next((facts for facts in list_facts() if facts.name == name.casefold()), None)


def warn_unknown(name: str) -> str:
    """What is to be said of an instrument that is named and not known; else nothing."""
    if not name or find_facts(name) is not None:
        return ""
    known = ", ".join(facts.name for facts in list_facts())
    return (
        f"Leafscope does not know an instrument {name}: no model, wavelength or scale was taken"
        f" from it. Known are {known}."
    )


def choose_calibration(
    instrument: str, model: str | None, options: TableOptions, wishes: Wishes
) -> tuple[str, TableOptions, Wishes]:
    """Fill in what an instrument's paper tells and the user did not: model, ends of the scale.

    Raises
    ------
    WrongUse
        Nobody says which model.
    """
    facts = find_facts(instrument) if instrument else None
    if facts is None:
        if model is None:
            raise WrongUse(
                "A calibration needs a model.",
                "Give --model, or --instrument with one of "
                f"{', '.join(known.name for known in list_facts())}.",
            )
        return model, options, wishes
    alone = facts.wavelengths_nm[0] if len(facts.wavelengths_nm) == 1 else None
    dark = facts.dark if wishes.dark is None else wishes.dark
    saturated = facts.saturated if wishes.saturated is None else wishes.saturated
    return (
        model or facts.model,
        replace(options, usual_nm=alone),
        replace(wishes, dark=dark, saturated=saturated),
    )


def _tell(tool: Instrument) -> InstrumentFacts:
    return InstrumentFacts(
        tool.name,
        tool.title,
        tool.wavelengths_nm,
        MODELS[tool.name],
        *scale_of(tool.detector),
        tuple(key for key, p in name_profiles().items() if p.instrument == tool.name),
        tuple(note for note in tool.notes if note.startswith("Published")),
    )
