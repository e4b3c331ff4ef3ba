"""The formats that can be read, and how a file finds its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats import e57, las, pcd, ply, ptx, text
from app.formats.header import Header
from app.formats.options import DEFAULTS, ReadOptions
from app.model.scan import Scan

_HEAD = 4096
_FOREIGN = {
    ".rxp": "a raw RIEGL stream",
    ".rdb": "a RIEGL point database",
    ".rdbx": "a RIEGL point database",
    ".fls": "a raw FARO scan",
    ".lsproj": "a FARO project",
    ".zfs": "a raw Zoller + Fröhlich scan",
    ".ptg": "a raw Leica scan",
    ".imp": "a Leica database",
    ".dp": "a DotProduct scan",
}


class Format(Protocol):
    """What the module of a format offers. Imports of its libraries wait for `read`."""

    @property
    def NAME(self) -> str:  # noqa: N802 (a constant of the module)
        """Name for the user."""

    @property
    def SUFFIXES(self) -> tuple[str, ...]:  # noqa: N802 (a constant of the module)
        """Endings of its files, with the dot."""

    def matches(self, head: bytes, path: Path) -> bool:
        """Whether the first bytes (or, without a magic, the suffix) are of this format."""

    def preflight(self, path: Path, options: ReadOptions = DEFAULTS) -> Header:
        """Check the header in Python; raise `BadInput` with a sentence."""

    def read(self, path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
        """Read the points; may crash on a hostile file, so it runs in a child process."""


# Text comes last: it has no magic bytes and takes whatever looks like a table.
FORMATS: Mapping[str, Format] = {
    "las": las,
    "e57": e57,
    "ply": ply,
    "pcd": pcd,
    "ptx": ptx,
    "text": text,
}


def find_format(path: Path) -> str:
    """The key in `FORMATS` of the file `path`, by its first bytes.

    Raises
    ------
    BadInput
        The format is unknown, or one that only its maker's software opens.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
    foreign = _FOREIGN.get(path.suffix.lower())
    if foreign is None:
        for name, module in FORMATS.items():
            if module.matches(head, path):
                return name
        raise BadInput(
            f"{path.name} is not a scan of a format that Leafscope reads.",
            "It reads LAS, LAZ, E57, PTX, PLY, PCD and text with columns.",
        )
    raise BadInput(
        f"{path.name} is {foreign}, which only the maker's software opens.",
        "Export it there as E57, LAZ or PTX.",
    )
