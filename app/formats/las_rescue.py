"""Reads a LAZ file that was cut off, record by record up to the damage.

lazrs wants the table of chunks, which stands at the end of the file and is lost. Reading in
sequence needs none of its numbers, so the decoder is given a made-up one, far behind the data.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any, BinaryIO

from app.core.errors import BadInput
from app.formats.las_preflight import Layout

_FAR = 1 << 40
_BLOCK = 100_000  # records


def rescue_records(file: BinaryIO, layout: Layout) -> Iterator[bytearray]:
    """Blocks of whole records; `file` stands at the first point.

    Raises
    ------
    BadInput
        The chunks vary in length, so that nothing can be read without their table.
    """
    decoder = _make_decoder(file, layout)
    record = bytearray(layout.record_bytes)
    block = bytearray()
    for i in range(layout.points):
        try:
            decoder.decompress_many(record)
        except (KeyboardInterrupt, SystemExit, MemoryError):
            raise
        except BaseException:  # noqa: BLE001 (a Rust panic is no Exception; the damage is found)
            break
        block += record
        if i % _BLOCK == _BLOCK - 1:
            yield block
            block = bytearray()
    yield block


def _make_decoder(file: BinaryIO, layout: Layout) -> Any:
    import lazrs

    packing = layout.compression
    if packing is None or packing.varies or packing.compressor == 1:
        raise BadInput("This LAZ file cannot be recovered: its chunks cannot be told apart.")
    table = io.BytesIO()
    chunks = [(packing.chunk, 1)] * -(-layout.points // packing.chunk)
    lazrs.write_chunk_table(table, chunks, lazrs.LazVlr(packing.raw))
    data = _FAR.to_bytes(8, "little") + file.read()[8:]
    return lazrs.LasZipDecompressor(_TwoParts(data, table.getvalue()), packing.raw)


class _TwoParts(io.RawIOBase):
    """A stream with bytes from 0 on, an end, and more bytes from `_FAR` on."""

    def __init__(self, near: bytes, far: bytes) -> None:
        self._near = near
        self._far = far
        self._place = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, place: int, whence: int = io.SEEK_SET) -> int:
        start = {io.SEEK_SET: 0, io.SEEK_CUR: self._place, io.SEEK_END: _FAR + len(self._far)}
        self._place = start[whence] + place
        return self._place

    def readinto(self, buffer: Any) -> int:
        source, start = (self._near, 0) if self._place < _FAR else (self._far, _FAR)
        found = source[self._place - start : self._place - start + len(buffer)]
        buffer[: len(found)] = found
        self._place += len(found)
        return len(found)
