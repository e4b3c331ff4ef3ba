"""How much memory the scans of a series need when all of them are open at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

from app.core.errors import BadInput
from app.core.units import count_points
from app.formats.options import DEFAULTS, ReadOptions
from app.services.reading import SHARE_OF_FREE, inspect_file

MIB, GIB = 2**20, 2**30


@dataclass(frozen=True, slots=True)
class Need:
    """What opening files takes, as their headers say.

    Attributes
    ----------
    scans, points : int
    memory : int
        Bytes that stay in use, at most.
    free : int
        Bytes of this machine that may be filled.
    """

    scans: int
    points: int
    memory: int
    free: int

    @property
    def fits(self) -> bool:
        """Whether there is room."""
        return self.memory <= self.free

    def describe(self) -> str:
        """A sentence."""
        return (
            f"{self.scans} scans with {count_points(self.points)} need up to "
            f"{show_size(self.memory)} of memory; {show_size(self.free)} may be used."
        )


def show_size(size: int) -> str:
    """Bytes as people read them."""
    return f"{size / GIB:.1f} GiB" if size >= GIB else f"{max(size / MIB, 1):.0f} MiB"


def estimate_need(files: Sequence[Path], options: ReadOptions = DEFAULTS) -> Need:
    """Look at the headers of files; raises `BadInput` where one cannot be read."""
    headers = [inspect_file(file, options)[1] for file in files]
    free = int(psutil.virtual_memory().available * SHARE_OF_FREE)
    return Need(
        sum(header.scans for header in headers),
        sum(header.points for header in headers) // options.every_nth,
        sum(header.memory for header in headers) // options.every_nth,
        free,
    )


def refuse_too_much(need: Need) -> None:
    """Raise `BadInput` where scans do not fit into the memory together."""
    if not need.fits:
        raise BadInput(
            need.describe(),
            "Open fewer scans; or let leafscope series measure their folder, which holds two "
            "scans at a time.",
        )
