"""Instruments to scan with: the presets, and those that a user describes in a file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from pathlib import Path

from app.core.errors import BadInput, WrongUse
from app.simulate.beam import Bundle
from app.simulate.detector import Detector, Ideal, count_channels
from app.simulate.limits import check_positive
from app.simulate.range_effect import Hancock
from app.simulate.ranging import Ranging
from app.simulate.ready_files import find_ready, read_start
from app.simulate.receiver import Receiver

LARGEST_FILE = 100_000
"""Bytes; an instrument takes two thousand."""


@dataclass(frozen=True, slots=True)
class Instrument:
    """A scanner.

    Attributes
    ----------
    name : str
        By which it is asked for.
    title : str
        By which a reader knows it.
    wavelengths_nm : tuple of float
        One per channel.
    bundle : Bundle
    ranging : Ranging
    receiver : Receiver
    detector : Detector
    step_deg : float
        Step between beams, degrees.
    ranging_channel : int
        Channel whose laser measures the range.
    notes : tuple of str
        What about it is published, and what assumed.
    """

    name: str
    title: str
    wavelengths_nm: tuple[float, ...]
    bundle: Bundle
    ranging: Ranging
    receiver: Receiver
    detector: Detector
    step_deg: float
    ranging_channel: int = 0
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.wavelengths_nm:
            raise WrongUse(f"The instrument {self.name} has no wavelength.", "Give one or more.")
        for wavelength in self.wavelengths_nm:
            check_positive("A wavelength", wavelength)
        self._check_names()
        check_positive("The step between beams", self.step_deg)
        channels = len(self.wavelengths_nm)
        if not 0 <= self.ranging_channel < channels:
            raise WrongUse(
                f"The ranging channel of {self.name} cannot be {self.ranging_channel}.",
                f"Its channels are 0 to {channels - 1}.",
            )
        if count_channels(self.detector) not in (None, channels):
            raise WrongUse(
                f"The detector of {self.name} has {count_channels(self.detector)} channels, but "
                f"there are {channels} wavelengths.",
                "Describe the detector for each wavelength.",
            )
        self._check_range_effect()

    def _check_names(self) -> None:
        """Channels and attributes are named by whole nanometres."""
        whole = Counter(f"{wavelength:.0f}" for wavelength in self.wavelengths_nm)
        name, count = whole.most_common(1)[0]
        if count > 1:
            raise WrongUse(
                f"{count} wavelengths of {self.name} are {name} nm, to the nanometre by which "
                "channels are named.",
                "Give wavelengths that differ by more than a nanometre.",
            )

    def _check_range_effect(self) -> None:
        if isinstance(self.detector, Ideal) or not isinstance(self.detector.range_effect, Hancock):
            return
        effect = self.detector.range_effect
        if len(effect.a) != len(self.wavelengths_nm):
            raise WrongUse(
                f"The range effect of {self.name} has {len(effect.a)} channels, but there are "
                f"{len(self.wavelengths_nm)} wavelengths.",
                "Give one a, k2 and k3 for each wavelength.",
            )
        if self.receiver.nearest < effect.NEAREST or self.receiver.farthest > effect.FARTHEST:
            raise WrongUse(
                f"The range effect of {self.name} is known from {effect.NEAREST:g} to "
                f"{effect.FARTHEST:g} m only.",
                "Keep the receiver's nearest and farthest range within it.",
            )


def list_instruments() -> tuple[Instrument, ...]:
    """The presets, sorted by name."""
    presets = find_ready("instruments")
    return tuple(_read(presets[name]) for name in sorted(presets))


def get_instrument(name: str) -> Instrument:
    """The preset of that name; raises `WrongUse` with the names there are."""
    presets = find_ready("instruments")
    if name not in presets:
        known = ", ".join(sorted(presets))
        raise WrongUse(f"There is no instrument {name!r}.", f"Instruments: {known}.")
    return _read(presets[name])


def read_instrument(path: Path) -> Instrument:
    """Read an instrument from a TOML file like those of the presets.

    Raises
    ------
    BadInput
        The file cannot be read, or a key is missing, unknown or out of bounds.
    """
    return _read(path)


def _read(file: Traversable) -> Instrument:
    from app.simulate.instrument_file import decode_instrument

    content = read_start(file, LARGEST_FILE, "instrument")
    if len(content) > LARGEST_FILE:
        raise BadInput(f"{file.name} is too large for an instrument.", "Choose another file.")
    return decode_instrument(content, file.name)
