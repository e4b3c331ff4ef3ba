"""Whole lines of a text file in blocks of a few megabytes, with line numbers for messages."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput

BLOCK = 1 << 21
LONGEST_LINE = 1 << 20


class LineReader:
    """Reads single lines and blocks of lines, in turns, from one file.

    Attributes
    ----------
    lines_read : int
        Lines given out so far; the next line is number ``lines_read + 1``.
    """

    def __init__(self, path: Path, offset: int = 0) -> None:
        self._path = path
        self._size = max(path.stat().st_size, 1)
        self._file: BinaryIO = path.open("rb")
        self._file.seek(offset, os.SEEK_SET)
        self._buffer, self._start = b"", 0
        self._position = offset
        self.lines_read = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    @property
    def fraction(self) -> float:
        """Share of the file that was given out."""
        return min(self._position / self._size, 1.0)

    @property
    def bytes_left(self) -> int:
        """Bytes of the file that were not given out."""
        return self._size - self._position

    def line(self) -> str | None:
        """The next line without its end; None at the end of the file."""
        for block in self.blocks(1):
            return decode(block).rstrip("\r\n")
        return None

    def peek(self) -> str | None:
        """The next line, which stays the next one."""
        position, read = self._position, self.lines_read
        line = self.line()
        if line is not None:
            self._start -= self._position - position
            self._position, self.lines_read = position, read
        return line

    def blocks(self, lines: int | None = None) -> Iterator[bytes]:
        """Blocks of whole lines, `lines` of them altogether or all that there are."""
        while lines is None or lines > 0:
            block, found = self._next_block(lines)
            if not block:
                return
            lines = None if lines is None else lines - found
            self.lines_read += found
            self._position += len(block)
            yield block

    def _next_block(self, lines: int | None) -> tuple[bytes, int]:
        while self._buffer.find(b"\n", self._start) < 0:
            more = self._file.read(BLOCK)
            if not more:
                return self._take(len(self._buffer))
            self._buffer, self._start = self._buffer[self._start :] + more, 0
            self._refuse_long_line(self._buffer)
        return self._take(*self._find_end(lines))

    def _take(self, end: int, found: int = 1) -> tuple[bytes, int]:
        block = self._buffer[self._start : end]
        self._start = end
        return block, found

    def _find_end(self, lines: int | None) -> tuple[int, int]:
        """End of the last of up to `lines` whole lines in the buffer, and their number."""
        rest = len(self._buffer) - self._start
        # Look close by first: files of many small scans would else search each block often.
        for window in (min(rest, (lines or rest) * 128), rest):
            ends = np.flatnonzero(self._view(window) == ord("\n"))
            if lines is not None and len(ends) >= lines:
                return self._start + int(ends[lines - 1]) + 1, lines
        return self._start + int(ends[-1]) + 1, len(ends)

    def _view(self, size: int) -> AnyArray:
        return np.frombuffer(self._buffer, np.uint8, count=size, offset=self._start)

    def _refuse_long_line(self, data: bytes) -> None:
        if len(data) > LONGEST_LINE + BLOCK and b"\n" not in data[:LONGEST_LINE]:
            raise BadInput(
                f"{self._path.name}: line {self.lines_read + 1} is longer than"
                f" {LONGEST_LINE} characters.",
                "This is no text file of points.",
            )


def decode(line: bytes) -> str:
    """Text of a line: UTF-8, or Latin-1 where it is none."""
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError:
        return line.decode("latin-1")


def count_lines(path: Path) -> int:
    """Lines of a file, the last one with or without its end."""
    count, last = 0, b"\n"
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            count += block.count(b"\n")
            last = block[-1:]
    return count + (last != b"\n")
