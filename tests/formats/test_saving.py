"""Export that is cancelled, or runs out of disk, leaves the old file as it was."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled
from app.core.progress import LiveProgress
from app.formats import csv_table, npz, ply, ptx
from app.formats.cloud import Cloud
from app.formats.saving import Writer, save
from app.model.scan import Grid, Scan

WRITERS = [ply.write, csv_table.write, npz.write, ptx.write]


def make_cloud() -> Cloud:
    row, column = np.divmod(np.arange(5000, dtype=np.int32), 50)
    grid = Grid(100, 50, row, column)
    return Cloud(Scan("s", np.ones((5000, 3)), {"intensity": np.arange(5000.0)}, grid=grid))


@contextmanager
def disk_of(size: int) -> Iterator[None]:
    """Let no file grow beyond `size` bytes."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.skipif(sys.platform == "win32", reason="needs file size limits")
@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize("size", [0, 1, 100, 5000, 50_000])
def test_full_disk(tmp_path: Path, write: Writer, size: int) -> None:
    target = tmp_path / "a.out"
    target.write_text("old")
    with disk_of(size), pytest.raises(BadInput, match="could not be written"):
        save(target, make_cloud(), write, overwrite=True)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("write", WRITERS)
def test_cancel(tmp_path: Path, write: Writer) -> None:
    with pytest.raises(Cancelled):
        save(tmp_path / "a.out", make_cloud(), write, progress=LiveProgress(print, lambda: True))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("write", WRITERS)
def test_never_over_an_existing_file(tmp_path: Path, write: Writer) -> None:
    target = tmp_path / "a.out"
    target.write_text("old")
    with pytest.raises(BadInput, match="exists already"):
        save(target, make_cloud(), write)
    assert target.read_text() == "old"
