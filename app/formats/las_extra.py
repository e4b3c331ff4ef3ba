"""Extra bytes of LAS: columns of any type behind the standard record (LAS 1.4 R15, 2.6)."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from app.formats.guard import clean

_DESCRIPTOR = 192
_TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")
_SCALED, _SHIFTED = 8, 16
_MOST_FIELDS = 500
_MOST_UNNAMED = 64  # bytes


@dataclass(frozen=True, slots=True)
class ExtraField:
    """One extra field of `count` numbers; a number is raw · scale + offset.

    `scale` and `offset` hold one value per number, or nothing where the numbers are plain.
    """

    name: str
    type: str
    count: int = 1
    scale: tuple[float, ...] = ()
    offset: tuple[float, ...] = ()
    unit: str = ""

    @property
    def bytes(self) -> int:
        """Bytes in a record."""
        return self.count * int(self.type[1:])

    @property
    def memory(self) -> int:
        """Bytes in memory: scaled numbers become float64."""
        return 8 * self.count if self.scale else self.bytes

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its numbers: several numbers are told apart by their place."""
        if self.count == 1:
            return (self.name,)
        return tuple(f"{self.name}_{i}" for i in range(self.count))


def parse_extra_fields(data: bytes, spare: int) -> tuple[tuple[ExtraField, ...], list[str]]:
    """Fields that fill the `spare` bytes of a record, and warnings.

    Bytes that nobody describes are kept as numbers of one byte, named ``ExtraBytes``,
    unless they are too many to mean anything.
    """
    fields: list[ExtraField] = []
    notes: list[str] = []
    for start in range(0, len(data) - _DESCRIPTOR + 1, _DESCRIPTOR):
        field, note = _parse(data[start : start + _DESCRIPTOR])
        if field is None or field.bytes > spare or len(fields) == _MOST_FIELDS:
            notes.append(note or f"Extra field {field.name if field else '?'} does not fit.")
            break  # what follows cannot be placed either
        spare -= field.bytes
        fields.append(field)
        notes.extend([note] if note else [])
    if spare > _MOST_UNNAMED:
        notes.append(f"{spare} bytes of each record are not described; they are left out.")
    elif spare:
        fields.append(ExtraField("ExtraBytes", "u1", spare))
    return tuple(fields), notes


def _parse(raw: bytes) -> tuple[ExtraField | None, str]:
    kind, options = raw[2], raw[3]
    name = _text(raw[4:36]) or "extra"
    if kind == 0:
        return ExtraField(name, "u1", options), ""
    if kind > 3 * len(_TYPES):
        return None, f"Extra field {name} is of an unknown type ({kind})."
    count = (kind - 1) // len(_TYPES) + 1
    field = ExtraField(name, _TYPES[(kind - 1) % len(_TYPES)], count, unit=_text(raw[160:192]))
    scale = struct.unpack_from("<3d", raw, 112)[:count] if options & _SCALED else (1.0,) * count
    offset = struct.unpack_from("<3d", raw, 136)[:count] if options & _SHIFTED else (0.0,) * count
    if all(s == 1.0 for s in scale) and not any(offset):
        return field, ""
    if not all(map(math.isfinite, scale + offset)) or 0.0 in scale:
        return field, f"Extra field {name} has an impossible scale; its raw numbers are kept."
    return ExtraField(name, field.type, count, scale, offset, field.unit), ""


def _text(raw: bytes) -> str:
    return clean(raw.split(b"\0")[0].decode("utf-8", "replace"))
