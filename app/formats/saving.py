"""Export of a cloud: the file whole or not at all, then its sidecar."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import atomic_path
from app.formats.cloud import Cloud
from app.formats.sidecar import write_sidecar

Writer = Callable[[Path, Cloud, Progress], None]


def save(
    target: Path,
    cloud: Cloud,
    write: Writer,
    overwrite: bool = False,
    progress: Progress = QUIET,
    sidecar: bool = True,
) -> tuple[Path, ...]:
    """Write a cloud with a format's `write`; give the files that were written.

    Parameters
    ----------
    sidecar : bool
        Whether the format needs one (all but E57 and NPZ do).

    Raises
    ------
    BadInput
        The file exists, or cannot be written; nothing was changed.
    """
    with atomic_path(target, overwrite) as temporary:
        write(temporary, cloud, progress)
    if not sidecar:
        return (target,)
    return target, write_sidecar(target, cloud)
