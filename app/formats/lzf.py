"""LZF, the compression of binary PCD files: decoding only, with bounds checked."""

from __future__ import annotations

from app.core.errors import BadInput
from app.core.progress import Progress

_DAMAGED = "The compressed data are damaged."
_LOOK = 1 << 16  # steps between two looks at the progress


def decompress_lzf(data: bytes, size: int, progress: Progress) -> bytes:
    """Bytes that LZF made `data` of.

    A control byte below 32 begins a run of literals; any other one a copy of bytes that
    were written before (after Marc Lehmann's liblzf).

    Parameters
    ----------
    data : bytes
    size : int
        Bytes that must come out.

    Raises
    ------
    BadInput
        A run or a copy reaches outside of the data.
    """
    out = bytearray()
    position = steps = 0
    while position < len(data):
        if steps % _LOOK == 0:
            progress.report(position / len(data), "Decompressing")
        steps += 1
        control = data[position]
        position += 1
        if control < 32:
            position = _append_literals(out, data, position, control + 1)
        else:
            position = _append_copy(out, data, position, control)
        if len(out) > size:
            raise BadInput(_DAMAGED)
    if len(out) != size:
        raise BadInput(_DAMAGED)
    return bytes(out)


def _append_literals(out: bytearray, data: bytes, position: int, length: int) -> int:
    if position + length > len(data):
        raise BadInput(_DAMAGED)
    out += data[position : position + length]
    return position + length


def _append_copy(out: bytearray, data: bytes, position: int, control: int) -> int:
    length = (control >> 5) + 2
    needed = 2 if length == 9 else 1
    if position + needed > len(data):
        raise BadInput(_DAMAGED)
    if length == 9:  # a length of 7 + 2 goes on in the next byte
        length += data[position]
        position += 1
    distance = ((control & 31) << 8) + data[position] + 1
    if distance > len(out):
        raise BadInput(_DAMAGED)
    pattern = bytes(out[-distance:])[:length]
    repeats = -(-length // len(pattern))  # a copy may run into the bytes that it writes
    out += (pattern * repeats)[:length]
    return position + 1
