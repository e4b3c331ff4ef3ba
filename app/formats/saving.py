"""Export of a cloud: the file and what lies beside it, whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from app.core.arrays import AnyArray
from app.core.progress import QUIET, Progress
from app.formats.atomic import atomic_files
from app.formats.cloud import Cloud
from app.formats.fields_file import fields_path, write_fields
from app.formats.sidecar import sidecar_path, write_sidecar

# What a writer gives back are the columns that its format has no place for, in the order
# of the points in the file.
Writer = Callable[[Path, Cloud, Progress], Mapping[str, AnyArray] | None]

_SHARE = 0.8  # of the work is the file itself, the rest what lies beside it


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
        Whether the format needs one (all but E57 and NPZ do); an older one is replaced.

    Raises
    ------
    BadInput
        The file exists, or cannot be written; nothing was changed.
    """
    written, fields = [target], None
    with atomic_files() as begin:
        data = begin(target, overwrite)
        columns = write(data, cloud, progress.part(0.0, _SHARE if sidecar else 1.0))
        if columns:
            written.append(fields_path(target))
            beside = begin(written[-1], overwrite)
            fields = write_fields(beside, columns, progress.part(_SHARE, 1.0))
        if sidecar:
            written.append(sidecar_path(target))
            write_sidecar(begin(written[-1], True), data, cloud, fields)
    return tuple(written)
