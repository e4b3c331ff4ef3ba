"""All scans of a series opened at once, for the window."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.model.scan import Scan
from app.services.reading import read_file
from app.services.series.memory import estimate_need, refuse_too_much


def read_all(files: Sequence[Path], progress: Progress = QUIET) -> list[Scan]:
    """Read files of one scan each.

    Raises
    ------
    BadInput
        They do not fit into the memory together, or a file holds another number of scans.
    """
    refuse_too_much(estimate_need(files))
    scans: list[Scan] = []
    for number, file in enumerate(files):
        part = progress.part(number / len(files), (number + 1) / len(files))
        found = read_file(file, progress=part)
        if len(found) != 1:
            raise BadInput(
                f"{file.name} holds {len(found)} scans; a series takes files of one.",
                "Write them to files of their own.",
            )
        scans += found
    return scans
