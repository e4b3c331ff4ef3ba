"""Writer of NPZ: ``xyz``, one array per attribute and field, and ``provenance`` as JSON."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO

import numpy as np

from app.core.arrays import AnyArray
from app.core.progress import Progress
from app.formats.cloud import Cloud
from app.formats.column_names import give_file_names
from app.formats.sidecar import describe_cloud, encode_json

NAME = "NPZ"
SUFFIXES = (".npz",)
_CHUNK = 1 << 24  # bytes written between two looks at the progress


def write(path: Path, cloud: Cloud, progress: Progress) -> None:
    """Write a cloud so that ``numpy.load`` reads it without pickle.

    ``provenance`` is a string array of one JSON text with what is no column: pose, size of
    the grid, channels, units and the cloud's own provenance.
    """
    columns = cloud.columns
    names = give_file_names(columns, taken=("xyz", "provenance"), clean=clean_name)
    arrays = {"xyz": cloud.scan.xyz, **{names[name]: v for name, v in columns.items()}}
    arrays["provenance"] = np.array(encode_json(describe_cloud(cloud)).decode("utf-8"))
    write_arrays(path, arrays, progress)


def write_arrays(path: Path, arrays: Mapping[str, AnyArray], progress: Progress) -> None:
    """Write arrays under their names, not compressed; the same arrays give the same bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for index, (name, values) in enumerate(arrays.items()):
            part = progress.part(index / len(arrays), (index + 1) / len(arrays))
            _write_array(archive, name, np.asarray(values, order="C"), part)


def _write_array(archive: zipfile.ZipFile, name: str, values: AnyArray, progress: Progress) -> None:
    # A fixed date, for the same bytes.
    entry = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
    with archive.open(entry, "w", force_zip64=True) as file:
        header = np.lib.format.header_data_from_array_1_0(values)
        np.lib.format.write_array_header_2_0(file, header)
        _write_data(file, values, progress)


def _write_data(file: IO[bytes], values: AnyArray, progress: Progress) -> None:
    data = values.reshape(-1).view(np.uint8).data
    for start in range(0, len(data), _CHUNK):
        progress.report(start / len(data), "Writing NPZ")
        file.write(data[start : start + _CHUNK])


def clean_name(name: str) -> str:
    """A name that stays one plain file inside the archive."""
    return "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in name)
