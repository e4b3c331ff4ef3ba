"""From the content of an instrument's TOML file to the instrument; faults are told in words."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TypeVar, get_args

import msgspec

from app.core.errors import BadInput, WrongUse
from app.simulate.detector import Detector
from app.simulate.instrument import Instrument
from app.simulate.instrument_tables import InstrumentTable
from app.simulate.ranging import Pick, Ranging
from app.simulate.receiver import Correlation

Made = TypeVar("Made")

CHOICES = {
    "ranging.kind": ("phase-shift", "pulsed"),
    "ranging.pick": get_args(Pick),
    "receiver.correlation": get_args(Correlation),
    "detector.kind": ("ideal", "linear", "logarithmic", "salca"),
    "detector.range_effect.kind": ("none", "inverse-square", "hancock"),
}
"""What a key with a word may hold."""


def decode_instrument(content: bytes, file: str) -> Instrument:
    """Make an instrument of the content of its file.

    Raises
    ------
    BadInput
        The content is not TOML, or a key is missing, unknown or out of bounds; the sentence
        names `file` and the key.
    """
    try:
        table = msgspec.toml.decode(content, type=InstrumentTable)
    except msgspec.ValidationError as error:
        raise _explain(str(error), file) from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadInput(f"{file} is not a TOML file: {error}.", "Correct it there.") from error
    return _name_errors(file, "", lambda: _assemble(table, file))


def _assemble(table: InstrumentTable, file: str) -> Instrument:
    ranging: Callable[[], Ranging] = table.ranging.build
    detector: Callable[[], Detector] = table.detector.build
    return Instrument(
        name=table.name,
        title=table.title,
        wavelengths_nm=table.wavelengths_nm,
        bundle=_name_errors(file, "beam", table.beam.build),
        ranging=_name_errors(file, "ranging", ranging),
        receiver=_name_errors(file, "receiver", table.receiver.build),
        detector=_name_errors(file, "detector", detector),
        step_deg=table.step(),
        ranging_channel=table.ranging_channel,
        notes=table.notes,
    )


def _name_errors(file: str, key: str, make: Callable[[], Made]) -> Made:
    """What `make` gives; its complaint becomes a `BadInput` that names file and table."""
    try:
        return make()
    except WrongUse as error:
        place = f"{file}, [{key}]" if key else file
        raise BadInput(f"{place}: {error.what}", error.hint) from error


def _explain(message: str, file: str) -> BadInput:
    """The decoder's message as a sentence that names file and key."""
    complaint, _, path = message.partition(" - at `$")
    place = path.rstrip("`").lstrip(".")
    field = re.search("(unknown|required) field `(.*)`", complaint)
    if field:
        key = ".".join(filter(None, (place, field[2])))
        if field[1] == "unknown":
            return BadInput(f"{file} has the key {key}, which no instrument has.", "Remove it.")
        return BadInput(f"{file} lacks the key {key}.", _offer(key) or "Add it.")
    wanted = complaint[:1].lower() + complaint[1:].replace("`", "")
    return BadInput(f"{file}, key {place}: {wanted}.", _offer(place) or "Correct it there.")


def _offer(key: str) -> str:
    return f"Choose from: {', '.join(CHOICES[key])}." if key in CHOICES else ""
