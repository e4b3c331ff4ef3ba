"""Waveform packets of LAS 1.3 and 1.4, point formats 4, 5, 9 and 10 (LAS 1.4 R15, 2.5 and 2.7).

They lie in the file itself or in a .wdp beside it. Opening a file looks at their places only;
the samples are read when an energy is asked for.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import BadInput
from app.formats.las_preflight import Layout
from app.model.waveforms import Packets

COLUMNS = {
    "wavepacket_index": "u1",
    "wavepacket_offset": "u8",
    "wavepacket_size": "u4",
    "return_point_wave_location": "f4",
}
_POINT_FORMATS = (4, 5, 9, 10)
_EXTERNAL = 4  # bit of the global encoding
_DESCRIPTOR_BYTES = 26
_BITS = (8, 16, 32)
_MOST_SAMPLES = 1_000_000  # of one packet; real ones have hundreds to thousands
_LARGEST = 1e30  # volts
_BLOCK = 1_000_000  # points that are checked at a time
_GAP = 256  # bytes that are read along rather than sought over


@dataclass(frozen=True, slots=True)
class Descriptor:
    """How the packets of one kind were digitised: volts = offset + gain · number."""

    bits: int
    compression: int
    samples: int
    step_ps: int
    gain: float
    offset: float

    @property
    def bytes(self) -> int:
        """Bytes of a sample."""
        return self.bits // 8

    @property
    def volts(self) -> tuple[float, float]:
        """Of the smallest and the largest number."""
        return self.offset, self.offset + self.gain * (2.0**self.bits - 1.0)

    @property
    def refusal(self) -> str:
        """Why such packets cannot be read; empty where they can."""
        if self.compression:
            return "its waveforms are compressed, which no published format describes"
        if self.bits not in _BITS:
            return f"its waveforms have {self.bits} bits per sample; 8, 16 and 32 can be read"
        if not 0 < self.samples <= _MOST_SAMPLES:
            return f"waveforms of {self.samples} samples are impossible"
        if self.step_ps == 0:
            return "the time between the samples of its waveforms is 0"
        if self.gain == 0.0 or not all(abs(v) < _LARGEST for v in self.volts):
            return f"a digitiser gain of {self.gain:g} and offset of {self.offset:g} is impossible"
        return ""


@dataclass(frozen=True, eq=False)
class LasWaveforms:
    """The waveforms of a LAS file; see `app.model.waveforms.Waveforms`.

    Attributes
    ----------
    path : str
        The file that holds the packets.
    size, modified : int
        Its bytes and the time of its last change, ns, when it was opened.
    start : int
        Byte that the places of packets count from.
    descriptors : mapping of int to Descriptor
    columns : mapping of str to (n,) arrays
        Those of `COLUMNS`: descriptor (0: no waveform), place and bytes of the packet, and
        picoseconds from its first sample to the return.
    missing : str
        Why there are no packets at all; empty where there are.
    """

    path: str
    size: int
    modified: int
    start: int
    descriptors: Mapping[int, Descriptor]
    columns: Mapping[str, AnyArray]
    missing: str = ""

    def __len__(self) -> int:
        return len(self.columns["wavepacket_index"])

    def take(self, points: AnyArray) -> LasWaveforms:
        """Those of some points."""
        return replace(self, columns={name: a[points] for name, a in self.columns.items()})

    def count_samples(self, points: Ints) -> Ints:
        """Samples of each point's waveform."""
        if self.missing:
            raise BadInput(self.missing, "Put it beside the points and open them again.")
        kind = self.columns["wavepacket_index"][points]
        self._check_kinds(kind)
        size = self.columns["wavepacket_size"][points].astype(np.int64)
        self._check_places(points, kind, size)
        width = np.maximum(self._table["bytes"][kind], 1)
        return np.where(kind > 0, np.minimum(size // width, self._table["samples"][kind]), 0)

    def read(self, points: Ints) -> Packets:
        """The waveforms of some points."""
        count = self.count_samples(points)
        offsets = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        kind = self.columns["wavepacket_index"][points]
        used = np.flatnonzero(count)
        place = self.columns["wavepacket_offset"][points[used]].astype(np.int64) + self.start
        data, at = self._fetch(place, count[used] * self._table["bytes"][kind[used]])
        samples = np.empty(offsets[-1])
        for number, length in np.unique(np.stack([kind[used], count[used]]), axis=1).T:
            rows = np.flatnonzero((kind[used] == number) & (count[used] == length))
            volts = _decode(data, at[rows], int(length), self.descriptors[int(number)])
            room = np.lib.stride_tricks.sliding_window_view(samples, length, writeable=True)
            room[offsets[used[rows]]] = volts
        step = self._table["step_ps"][kind]
        location = self.columns["return_point_wave_location"][points].astype(np.float64)
        return Packets(
            samples, offsets, step * 1e-3, location / step,
            self._table["quantum"][kind], self._table["ceiling"][kind],
        )  # fmt: skip

    @cached_property
    def _table(self) -> AnyArray:
        """What each descriptor number stands for; 0 is no waveform."""
        names = ("bytes", "samples", "step_ps", "quantum", "ceiling")
        table = np.zeros(256, [(n, "i8" if n in names[:2] else "f8") for n in names])
        table["step_ps"] = 1.0
        for number, d in self.descriptors.items():
            if not d.refusal:
                half = 0.5 * abs(d.gain)
                table[number] = d.bytes, d.samples, d.step_ps, 2 * half, max(d.volts) - half
        return table

    def _check_kinds(self, kind: AnyArray) -> None:
        name = Path(self.path).name
        for number in np.unique(kind[kind > 0]).tolist():
            if number not in self.descriptors:
                raise BadInput(f"{name}: waveform descriptor {number} is not in the file.")
            if refusal := self.descriptors[number].refusal:
                raise BadInput(f"{name}: {refusal}.")

    def _check_places(self, points: Ints, kind: AnyArray, size: Ints) -> None:
        path = Path(self.path)
        if _stat(path) != (self.size, self.modified):
            raise BadInput(f"{path.name} changed since it was opened.", "Open the scan again.")
        room = max(self.size - self.start, 0)
        place = self.columns["wavepacket_offset"][points]
        outside = (kind > 0) & ((place > room) | (size > room - np.minimum(place, room)))
        if outside.any():
            raise BadInput(
                f"{outside.sum()} or more waveforms lie outside {path.name} ({self.size} bytes).",
                "The file was cut off or belongs to other points.",
            )

    def _fetch(self, place: Ints, size: Ints) -> tuple[AnyArray, Ints]:
        """Bytes that hold all packets, and where in them each begins.

        Packets that lie side by side, or on each other, are read in one go.
        """
        order = np.argsort(place, kind="stable")
        begin, end = place[order], np.maximum.accumulate((place + size)[order])
        fresh = np.ones(len(order), bool)
        fresh[1:] = begin[1:] > end[:-1] + _GAP
        firsts = np.flatnonzero(fresh)
        seek = begin[firsts]
        length = end[np.append(firsts[1:], len(order)) - 1] - seek if len(order) else seek
        goal = np.cumsum(length) - length
        data = bytearray(int(length.sum()))
        with Path(self.path).open("rb") as file, memoryview(data) as room:
            for source, count, target in np.stack([seek, length, goal], axis=1).tolist():
                file.seek(source)
                if file.readinto(room[target : target + count]) < count:
                    raise BadInput(f"{Path(self.path).name} became shorter while it was read.")
        run = np.cumsum(fresh) - 1
        at = np.empty(len(order), np.int64)
        at[order] = goal[run] + begin - seek[run]
        return np.frombuffer(data, np.uint8), at


def find_waveforms(
    path: Path, layout: Layout, attributes: Mapping[str, AnyArray]
) -> tuple[LasWaveforms | None, tuple[str, ...]]:
    """The waveforms of the points that were read from a file, and warnings.

    Returns
    -------
    LasWaveforms or None
        None where the file has no such points. What is wrong with the packets is a warning
        here and an error when they are read, so that the points can be used all the same.
    """
    if layout.point_format not in _POINT_FORMATS:
        return None, ()
    columns = {name: attributes.get(name) for name in COLUMNS}
    if any(a is None or a.dtype != np.dtype(COLUMNS[n]) for n, a in columns.items()):
        return None, ()  # a file of ours that keeps other columns
    index = columns["wavepacket_index"]
    if index is None or not index.any():
        return None, ()
    known: dict[str, Any] = {"columns": columns, "descriptors": _parse(layout)}
    found = _locate(path, layout, known)
    try:
        for first in range(0, len(found), _BLOCK):
            found.count_samples(np.arange(first, min(first + _BLOCK, len(found))))
    except BadInput as error:
        return found, (f"{error.what} There are no energies of its returns.",)
    return found, ()


def describe_waveforms(waveforms: LasWaveforms) -> str:
    """How many there are, how they were digitised, and where they lie."""
    index = waveforms.columns["wavepacket_index"]
    kinds = [waveforms.descriptors.get(k) for k in np.unique(index[index > 0]).tolist()]
    how = [f"{d.samples} × {d.bits} bit, {d.step_ps / 1e3:g} ns apart" for d in kinds if d]
    used = int(np.count_nonzero(index))
    return f"{used} points, {' or '.join(how[:3])}, in {Path(waveforms.path).name}"


def _parse(layout: Layout) -> dict[int, Descriptor]:
    return {
        number: Descriptor(*struct.unpack_from("<BBIIdd", raw))
        for number, raw in layout.descriptors
        if len(raw) >= _DESCRIPTOR_BYTES
    }


def _locate(path: Path, layout: Layout, known: dict[str, Any]) -> LasWaveforms:
    """Where the packets lie: in the file where its header says so, else beside it."""
    if layout.waveform_start and not layout.encoding & _EXTERNAL:
        return LasWaveforms(str(path), *_stat(path), layout.waveform_start, **known)
    for beside in (path.with_suffix(".wdp"), path.with_suffix(".WDP")):
        if beside.is_file():
            return LasWaveforms(str(beside), *_stat(beside), 0, **known)
    beside = path.with_suffix(".wdp")
    missing = f"{beside.name}, which holds the waveforms of {path.name}, is missing."
    return LasWaveforms(str(beside), 0, 0, 0, **known, missing=missing)


def _stat(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_size, found.st_mtime_ns


def _decode(data: AnyArray, at: Ints, length: int, kind: Descriptor) -> Floats:
    """Volts of packets of one length, (k, length)."""
    rows = np.lib.stride_tricks.sliding_window_view(data, length * kind.bytes)[at]
    numbers: AnyArray = np.ascontiguousarray(rows).view(f"<u{kind.bytes}")
    return numbers * float(kind.gain) + float(kind.offset)
