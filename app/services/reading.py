"""Opens a file safely: sniff, check the header, budget the memory, read in a child process."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import psutil

from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.formats._registry import FORMATS, find_format
from app.formats.channels import name_constants
from app.formats.fields_file import fields_path
from app.formats.handover import load_scans
from app.formats.header import Header
from app.formats.isolation import Limits, run_reader
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.sidecar import sidecar_path
from app.model.scan import Scan, Source

SHARE_OF_FREE = 0.6  # of the free memory that one file may fill
_FOLDER = "leafscope-read-"
_HASH_CHUNK = 4 << 20
_SHORTEST_TIME = 10.0  # seconds
_BYTES_PER_SECOND = 1e6  # slower than any disk: the limit stops what hangs, not what is large
_POINTS_PER_SECOND = 5e4


def read_file(
    path: Path | str,
    options: ReadOptions = DEFAULTS,
    progress: Progress = QUIET,
    memory_cap: int | None = None,
) -> list[Scan]:
    """Read all scans of a file.

    Parameters
    ----------
    path : Path or str
    options : ReadOptions
    progress : Progress
        Cancel takes effect within 0.2 s.
    memory_cap : int or None
        Bytes that the points may fill; never more than 60 % of the free memory.

    Returns
    -------
    list of Scan
        In file order, each with its `Source`.

    Raises
    ------
    BadInput
        The file is missing, of an unknown format, damaged, too large for the memory, or it
        crashed its reader; one sentence says which.
    Cancelled
        `progress` was cancelled.
    """
    path = Path(path).absolute()
    format_name, header = inspect_file(path, options)
    need = _budget(path, header, options, memory_cap)
    before = path.stat()
    limits = Limits(need, _allow_seconds(before.st_size, header))
    with _private_folder() as folder:
        run_reader(path, format_name, options.as_json(), folder, limits, progress.part(0.0, 0.85))
        scans = load_scans(folder, progress.part(0.85, 0.9))
    digest = hash_file(path, progress.part(0.9, 1.0))
    after = path.stat()
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
        raise BadInput(f"{path.name} changed while it was read.", "Open it again.")
    source = Source(str(path), before.st_size, digest, 0, options.changed(), _hash_beside(path))
    return [
        replace(
            _to_metres(scan, options.metres_per_unit),
            source=replace(source, scan_index=i),
            warnings=(*scan.warnings, *name_constants(scan.attributes)),
        )
        for i, scan in enumerate(scans)
    ]


def inspect_file(path: Path, options: ReadOptions = DEFAULTS) -> tuple[str, Header]:
    """Name of the format and the checked header, without reading points.

    Raises
    ------
    BadInput
        As `read_file`, for whatever the header can tell.
    """
    _check_place(path)
    try:
        name = find_format(path)
        return name, FORMATS[name].preflight(path, options)
    except OSError as error:
        raise BadInput(f"{path.name} cannot be read: {error.strerror or error}.") from error


def hash_file(path: Path, progress: Progress = QUIET) -> str:
    """SHA-256 of a file, as hexadecimal text."""
    digest = hashlib.sha256()
    size = path.stat().st_size
    with path.open("rb") as file:
        while block := file.read(_HASH_CHUNK):
            digest.update(block)
            progress.report(file.tell() / max(size, 1), "Computing the checksum")
    return digest.hexdigest()


def _hash_beside(path: Path) -> str:
    """Hashes of what lies beside a file, one after the other."""
    places = (sidecar_path(path), fields_path(path))
    return "".join(hash_file(place) for place in places if place.is_file())


def _check_place(path: Path) -> None:
    try:
        if not path.exists():
            raise BadInput(f"{path} does not exist.", "Check the name.")
        if path.is_dir():
            raise BadInput(f"{path} is a folder.", "Give a file in it.")
        if not path.is_file():
            raise BadInput(f"{path} is no regular file.")
        if path.stat().st_size == 0:
            raise BadInput(f"{path.name} is empty (0 bytes).")
        if not os.access(path, os.R_OK):
            raise BadInput(f"{path.name} may not be read by you.", "Change its permissions.")
    except (OSError, ValueError) as error:  # a name too long, or with a zero byte
        raise BadInput(f"{str(path)[:200]!r} cannot be opened: {error}.") from error


def _budget(path: Path, header: Header, options: ReadOptions, cap: int | None) -> int:
    """Bytes that reading needs; refuses what does not fit and says what would."""
    free = int(psutil.virtual_memory().available * SHARE_OF_FREE)
    may = free if cap is None else min(free, cap)
    need = header.memory // options.every_nth
    if need > may:
        nth = -(-header.memory // max(may, 1))
        raise BadInput(
            f"{path.name} claims {header.points} points, which need {_size(need)} of memory; "
            f"{_size(may)} may be used.",
            f"Read every {nth}th point (every_nth, --every-nth {nth}), or free memory.",
        )
    return need


def _allow_seconds(size: int, header: Header) -> float:
    return _SHORTEST_TIME + size / _BYTES_PER_SECOND + header.points / _POINTS_PER_SECOND


@contextmanager
def _private_folder() -> Iterator[Path]:
    """A folder that only this user may enter, always removed."""
    _sweep_folders()
    folder = Path(tempfile.mkdtemp(prefix=f"{_FOLDER}{os.getpid()}-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


def _sweep_folders() -> None:
    """Remove what processes left behind that were killed while they read."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_FOLDER}*"):
        owner = folder.name.removeprefix(_FOLDER).split("-")[0]
        if owner.isdecimal() and not psutil.pid_exists(int(owner)):
            shutil.rmtree(folder, ignore_errors=True)  # it may be another user's


def _to_metres(scan: Scan, metres_per_unit: float) -> Scan:
    if metres_per_unit == 1.0:
        return scan
    scaled = scan.with_xyz(scan.xyz * metres_per_unit)
    if scan.pose is None:
        return scaled
    x, y, z = (metres_per_unit * value for value in scan.pose.position)
    return scaled.with_pose(replace(scan.pose, position=(x, y, z)))


def _size(count: int) -> str:
    return f"{count / 1e9:.1f} GB" if count >= 1e8 else f"{count / 1e6:.1f} MB"
