"""The header of a LAS or LAZ file, checked against the file's size (ASPRS LAS 1.4 R15)."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from app.core.errors import BadInput
from app.formats.guard import clean
from app.formats.header import Header
from app.formats.las_extra import ExtraField, parse_extra_fields

RECORD_BYTES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)  # by point format
OUR_VLR = ("leafscope", 1)
_HEADER_BYTES = {0: 227, 1: 227, 2: 227, 3: 235, 4: 375, 5: 393}
_VLR_BYTES = 54
_MOST_VLRS = 10_000
_LONGEST_CRS = 1_000_000
_WORKING_MEMORY = 1 << 26  # one chunk of records and what is made of it
_WAVEFORMS = 99  # the descriptor of waveforms n is record 99 + n
_COMPRESSORS = (1, 2, 3)  # pointwise, pointwise chunked, layered chunked


@dataclass(frozen=True, slots=True)
class Compression:
    """The LASzip record: raw for the decoder, and what is checked in it."""

    raw: bytes
    compressor: int
    chunk: int

    @property
    def varies(self) -> bool:
        """Chunks of different length, as in COPC."""
        return self.chunk in (0, 0xFFFFFFFF)


@dataclass(frozen=True, slots=True)
class Layout:
    """All that is needed to find and decode the point records."""

    version: tuple[int, int]
    header_bytes: int
    offset: int
    vlr_count: int
    point_format: int
    compressed: bool
    record_bytes: int
    points: int
    scales: tuple[float, float, float]
    offsets: tuple[float, float, float]
    software: str = ""
    system: str = ""
    crs: str = ""
    extra: tuple[ExtraField, ...] = ()
    compression: Compression | None = None
    names: str = ""
    encoding: int = 0
    waveform_start: int = 0
    descriptors: tuple[tuple[int, bytes], ...] = ()
    warnings: tuple[str, ...] = ()
    shortfall: str = ""


def read_layout(path: Path, recover: bool = False) -> Layout:
    """Read and check the header; nothing is allocated by a claimed number.

    Raises
    ------
    BadInput
        A field of the header is impossible, or the file is cut off and the user did not
        ask to `recover` what is complete.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        layout = _check(_parse(file.read(393), path.name), size, path.name)
        layout = _read_vlrs(file, layout, path.name)
        check = _check_chunks if layout.compressed else _check_length
        layout = check(file, layout, size, path.name)
    if layout.shortfall and not recover:
        raise BadInput(
            layout.shortfall, "The file is cut or damaged; --recover reads the complete points."
        )
    return _warn(layout, layout.shortfall) if layout.shortfall else layout


def describe(layout: Layout) -> Header:
    """The layout as every format tells it."""
    value_bytes = layout.record_bytes - 12 + sum(f.memory - f.bytes for f in layout.extra)
    flags = 8  # bit fields become a byte each
    details = {
        "format": f"{'LAZ' if layout.compressed else 'LAS'} {layout.version[0]}."
        f"{layout.version[1]}, point format {layout.point_format}",
        "software": layout.software,
        "system": layout.system,
        "crs": layout.crs,
        "las_scale": " ".join(map(repr, layout.scales)),
        "las_offset": " ".join(map(repr, layout.offsets)),
    }
    return Header(
        points=layout.points,
        attributes=_list_attributes(layout),
        memory=layout.points * (24 + value_bytes + flags) + _WORKING_MEMORY,
        details={key: value for key, value in details.items() if value},
        warnings=layout.warnings,
    )


def _list_attributes(layout: Layout) -> tuple[str, ...]:
    """What a user may look for; the flags of LAS go without saying."""
    kind = layout.point_format
    names = ["intensity", "return_number", "number_of_returns", "classification"]
    names += ["gps_time"] if kind not in (0, 2) else []
    names += ["red", "green", "blue"] if kind in (2, 3, 5, 7, 8, 10) else []
    names += ["nir"] if kind in (8, 10) else []
    return (*names, *(name for field in layout.extra for name in field.columns))


def _parse(head: bytes, name: str) -> Layout:
    if len(head) < _HEADER_BYTES[0]:
        raise BadInput(f"{name} ends inside its LAS header ({len(head)} bytes).")
    header_bytes, offset, vlrs, kind, record, points = struct.unpack_from("<HIIBHI", head, 94)
    values = struct.unpack_from("<6d", head, 131)
    minor, waveforms = head[25], 0
    if minor >= 3 and len(head) >= 235:
        (waveforms,) = struct.unpack_from("<Q", head, 227)
    if minor >= 4 and len(head) >= 255:
        (long_count,) = struct.unpack_from("<Q", head, 247)
        points = long_count or points
    return Layout(
        version=(head[24], minor),
        header_bytes=header_bytes,
        offset=offset,
        vlr_count=vlrs,
        point_format=kind & 0x3F,
        compressed=bool(kind & 0xC0),
        record_bytes=record,
        points=points,
        scales=values[:3],
        offsets=values[3:],
        software=_text(head[58:90]),
        system=_text(head[26:58]),
        encoding=head[6],
        waveform_start=waveforms,
    )


def _check(layout: Layout, size: int, name: str) -> Layout:
    major, minor = layout.version
    if major != 1 or minor not in _HEADER_BYTES:
        raise BadInput(f"{name} claims to be LAS {major}.{minor}, which does not exist.")
    if not _HEADER_BYTES[minor] <= layout.header_bytes <= layout.offset:
        raise BadInput(
            f"{name}: a header of {layout.header_bytes} bytes with points from byte "
            f"{layout.offset} is impossible for LAS {major}.{minor}."
        )
    if layout.offset > size:
        raise BadInput(
            f"{name}: points begin at byte {layout.offset}, but the file has {size} bytes."
        )
    if layout.point_format >= len(RECORD_BYTES):
        raise BadInput(f"{name}: point format {layout.point_format} does not exist.")
    if layout.record_bytes < RECORD_BYTES[layout.point_format]:
        raise BadInput(
            f"{name}: records of {layout.record_bytes} bytes are too short for "
            f"point format {layout.point_format}."
        )
    if not all(math.isfinite(s) and 1e-9 <= s <= 1e3 for s in layout.scales):
        raise BadInput(f"{name}: the scale of the coordinates is impossible: {layout.scales}.")
    if not all(math.isfinite(o) and abs(o) <= 1e12 for o in layout.offsets):
        raise BadInput(f"{name}: the offset of the coordinates is impossible: {layout.offsets}.")
    if layout.points == 0:
        return _warn(layout, "The file says that it holds no points.")
    return layout


def _read_vlrs(file: BinaryIO, layout: Layout, name: str) -> Layout:
    """Walk the variable length records as far as they fit before the points."""
    room = (layout.offset - layout.header_bytes) // _VLR_BYTES
    count = min(layout.vlr_count, room, _MOST_VLRS)
    extra: list[bytes] = []
    end = layout.header_bytes
    found = 0
    for found in range(count + 1):
        file.seek(end)
        head = file.read(_VLR_BYTES)
        if found == count or len(head) < _VLR_BYTES:
            break
        record, length = struct.unpack_from("<HH", head, 18)
        end += _VLR_BYTES + length
        if end > layout.offset:
            break
        key = (_text(head[2:18]), record)
        data = file.read(length)
        if key == ("LASF_Spec", 4):
            extra.append(data)
        else:
            layout = _take_vlr(layout, key, data, name)
    if found < layout.vlr_count:
        layout = _warn(layout, f"Only {found} of {layout.vlr_count} header records are readable.")
    spare = layout.record_bytes - RECORD_BYTES[layout.point_format]
    fields, notes = parse_extra_fields(b"".join(extra), spare)
    return _warn(replace(layout, extra=fields), *notes)


def _take_vlr(layout: Layout, key: tuple[str, int], data: bytes, name: str) -> Layout:
    if key == ("laszip encoded", 22204):
        return replace(layout, compression=_parse_laszip(data, layout.record_bytes, name))
    if key == ("LASF_Projection", 2112):
        return replace(layout, crs=_text(data[:_LONGEST_CRS]))
    if key == OUR_VLR:
        return replace(layout, names=_text(data))
    if key[0] == "LASF_Spec" and _WAVEFORMS < key[1] <= _WAVEFORMS + 255:
        known = (*layout.descriptors, (key[1] - _WAVEFORMS, data[:26]))
        return replace(layout, descriptors=known[-255:])
    return layout


def _parse_laszip(data: bytes, record_bytes: int, name: str) -> Compression:
    if len(data) < 34:
        raise BadInput(f"{name}: its LASzip record is cut short.")
    compressor, _, _, _, _, _, chunk = struct.unpack_from("<HHBBHII", data)
    (items,) = struct.unpack_from("<H", data, 32)
    if len(data) < 34 + 6 * items or compressor not in _COMPRESSORS:
        raise BadInput(f"{name}: its LASzip record is damaged.")
    sizes = [struct.unpack_from("<HHH", data, 34 + 6 * i)[1] for i in range(items)]
    if sum(sizes) != record_bytes:
        raise BadInput(
            f"{name}: LASzip describes records of {sum(sizes)} bytes, the header of {record_bytes}."
        )
    return Compression(data, compressor, chunk)


def _check_length(_: BinaryIO, layout: Layout, size: int, name: str) -> Layout:
    whole = (size - layout.offset) // layout.record_bytes
    if layout.points <= whole:
        return layout
    text = f"{name} claims {layout.points} points, but only {whole} complete records are in it."
    if whole == 0:
        raise BadInput(f"{name} claims {layout.points} points, but holds none: it was cut off.")
    return replace(layout, points=whole, shortfall=text)


def _check_chunks(file: BinaryIO, layout: Layout, size: int, name: str) -> Layout:
    """Bound the chunk table, on whose count lazrs allocates."""
    packing = layout.compression
    if packing is None:
        raise BadInput(f"{name} is compressed, but has no LASzip record.")
    if layout.points == 0 or packing.compressor == 1:
        return layout
    table = _find_table(file, layout.offset, size)
    if table is None:
        return replace(layout, shortfall=f"{name} was cut off: it ends before its chunk table.")
    file.seek(table)
    _, chunks = struct.unpack("<II", file.read(8))
    most = layout.points if packing.varies else -(-layout.points // packing.chunk) + 1
    if chunks > most or chunks > table - layout.offset:
        raise BadInput(f"{name}: {chunks} chunks for {layout.points} points are impossible.")
    if not packing.varies and chunks * packing.chunk < layout.points:
        raise BadInput(f"{name}: {layout.points} points do not fit into {chunks} chunks.")
    return layout


def _find_table(file: BinaryIO, offset: int, size: int) -> int | None:
    """Where the chunk table begins; None where the file ends before it."""
    for place in (offset, size - 8):  # a streaming writer leaves -1 and appends the place
        file.seek(place)
        raw = file.read(8)
        if len(raw) < 8:
            return None
        (table,) = struct.unpack("<q", raw)
        if table != -1:
            return int(table) if offset + 8 <= table <= size - 8 else None
    return None


def _warn(layout: Layout, *sentences: str) -> Layout:
    return replace(layout, warnings=(*layout.warnings, *sentences))


def _text(raw: bytes) -> str:
    return clean(raw.split(b"\0")[0].decode("utf-8", "replace"))


def parse_names(layout: Layout) -> dict[str, dict[str, str]]:
    """What our own writer noted about each stored column; empty for other writers' files."""
    try:
        columns = json.loads(layout.names or "{}").get("columns", {})
    except (ValueError, AttributeError, RecursionError):
        return {}
    if not isinstance(columns, dict):
        return {}
    return {str(k): v for k, v in columns.items() if isinstance(v, dict)}
