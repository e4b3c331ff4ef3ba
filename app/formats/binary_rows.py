"""Rows of fixed length from a binary file, in chunks, with progress and cancel."""

from __future__ import annotations

from pathlib import Path
from typing import IO

import numpy as np
import numpy.typing as npt

from app.core.progress import Progress

_CHUNK = 1 << 18  # rows


def read_rows(
    file: IO[bytes], dtype: np.dtype[np.void], rows: int, every_nth: int, progress: Progress
) -> tuple[npt.NDArray[np.void], int]:
    """Every n-th of up to `rows` rows from where `file` stands, and how many there were.

    Memory grows with what the file holds, not with `rows`.
    """
    chunks, found = [np.empty(0, dtype)], 0
    while found < rows:
        progress.report(found / rows, f"Reading {Path(file.name).name}")
        data = file.read(min(_CHUNK, rows - found) * dtype.itemsize)
        chunk = np.frombuffer(data, dtype, count=len(data) // dtype.itemsize)
        if not len(chunk):
            break
        chunks.append(chunk[-found % every_nth :: every_nth])
        found += len(chunk)
    return np.concatenate(chunks), found
