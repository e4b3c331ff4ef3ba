"""The beam of a scanner: of an instrument that we know, as a scan says, or typed in."""

from __future__ import annotations

from app.core.errors import WrongUse
from app.core.units import MM_PER_M, to_degrees, to_mm, to_radians
from app.model.parameters import Beam
from app.model.scan import Scan
from app.simulate.instrument import Instrument, list_instruments
from app.simulate.virtual_scan import find_instrument

TYPED = "typed in"
SAID_IN = (("instrument",), ("sensorVendor", "sensorModel"), ("system",))
"""Facts of a scan that may name its instrument."""


def beam_of_instrument(name: str) -> Beam:
    """The beam of a preset, or of an instrument that a TOML file describes.

    Raises
    ------
    WrongUse
        There is no such instrument; the hint has the names there are.
    BadInput
        The file cannot be understood.
    """
    return _beam_of(find_instrument(name), f"instrument {name}")


def typed_beam(exit_diameter_mm: float, half_divergence_deg: float) -> Beam:
    """A beam from the two numbers of its data sheet; the divergence is HALF the full one."""
    radius, half = exit_diameter_mm / (2.0 * MM_PER_M), float(to_radians(half_divergence_deg))
    return Beam(radius, half, TYPED)


def choose_beam(
    instrument: str | None, exit_diameter_mm: float | None, half_divergence_deg: float | None
) -> Beam | None:
    """The beam that a command was told of: an instrument, or both numbers; None for neither."""
    numbers = (exit_diameter_mm, half_divergence_deg)
    if instrument is not None:
        if numbers != (None, None):
            raise WrongUse(
                "A beam is given by --instrument, or by --exit-diameter and --half-divergence, "
                "not by both."
            )
        return beam_of_instrument(instrument)
    if exit_diameter_mm is None and half_divergence_deg is None:
        return None
    if exit_diameter_mm is None or half_divergence_deg is None:
        raise WrongUse(
            "A beam needs both --exit-diameter (mm) and --half-divergence (degrees).",
            "Give the other one too, or --instrument NAME.",
        )
    return typed_beam(exit_diameter_mm, half_divergence_deg)


def propose_beam(scan: Scan) -> Beam | None:
    """The beam of the instrument that a scan names, if it is one of the presets."""
    tool = name_instrument(scan)
    return _beam_of(tool, f"instrument {tool.name}, as the scan says") if tool else None


def name_instrument(scan: Scan) -> Instrument | None:
    """The preset of the instrument that a scan names; None where it names none of them.

    An instrument is named when all words of its title are in the text; of two, that with more
    words is meant (the LS880 with its filter, not the one without).
    """
    for keys in SAID_IN:
        said = _words(" ".join(scan.metadata.get(key, "") for key in keys))
        named = [tool for tool in list_instruments() if said and _words(tool.title) <= said]
        if named:
            return max(named, key=lambda tool: len(_words(tool.title)))
    return None


def list_beams() -> list[tuple[str, Beam]]:
    """Titles and beams of the presets."""
    return [(tool.title, _beam_of(tool, f"instrument {tool.name}")) for tool in list_instruments()]


def describe_beam(beam: Beam) -> str:
    """A beam in a line: its numbers, and where they come from."""
    half = to_degrees(beam.half_divergence)
    return f"{to_mm(2.0 * beam.radius):.4g} mm at exit, half divergence {half:.4g}° ({beam.origin})"


def _beam_of(tool: Instrument, origin: str) -> Beam:
    return Beam(tool.bundle.exit_diameter / 2.0, tool.bundle.half_divergence, origin)


def _words(text: str) -> set[str]:
    return set(text.casefold().replace(",", " ").replace(":", " ").split())
