"""What is asked of a series, its files, and what each of them is."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from app.core.carry import USUAL, Tolerance
from app.core.errors import BadInput, WrongUse
from app.formats._registry import FORMATS
from app.formats.options import DEFAULTS
from app.formats.session import SUFFIX
from app.services.opening import Opening
from app.services.series.entries import Entry, Understood, read_entries, type_entries
from app.services.series.file_names import match_names, read_names
from app.services.series.reference import Reference

FIT = "fit"
NAME = "name"
TEXT = "text"


@dataclass(frozen=True, slots=True)
class SeriesOrder:
    """What is asked of a series.

    Attributes
    ----------
    files : tuple of Path
        Scans, or folders of scans. None: those of the session's own series.
    leaves : str
        A session with leaves, a scan with labels, or ``find``.
    angle_from, time_from : str or None
        ``name``, a pattern such as ``leaf_{angle}.laz``, a CSV, or numbers with commas between;
        None: names, where they say something.
    axis : str or None
        ``x,y,z,dx,dy,dz`` or ``fit``; None: fit where angles change.
    same_pose : bool
        Nothing turns, whatever the angles.
    reference : Path or None
        Scan in which leaves are found; None: the one nearest to angle 0, or the first.
    label_field : str or None
        Of a scan with labels.
    tolerance : Tolerance
    opening : Opening
        How scans are read; its path does not count.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    full_hits : bool
        Leave out points that the beam hits in part.
    """

    files: tuple[Path, ...]
    leaves: str
    angle_from: str | None = None
    time_from: str | None = None
    axis: str | None = None
    same_pose: bool = False
    reference: Path | None = None
    label_field: str | None = None
    tolerance: Tolerance = USUAL
    opening: Opening = Opening(Path(), DEFAULTS)  # noqa: RUF009 (immutable)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    full_hits: bool = False

    def __post_init__(self) -> None:
        if self.same_pose and self.axis is not None:
            raise WrongUse("Leaves in the same pose turn about no axis.", "Give one of the two.")
        if not self.files and Path(self.leaves).suffix != SUFFIX:
            raise WrongUse("Name the scans of the series, or the folder that holds them.")

    def open(self, file: Path) -> Opening:
        """How one of the files is read."""
        return replace(self.opening, path=file)

    def sources(self) -> list[Path]:
        """Every file that may be read: scans, leaves, and tables of angles and times."""
        told = (self.leaves, self.angle_from, self.time_from, self.reference)
        files = list_scans(self.files) if self.files else []
        return [*files, *(Path(text) for text in told if text is not None)]


def list_scans(paths: Sequence[Path]) -> list[Path]:
    """Scans of files and folders, in the order of the numbers in their names.

    Of a folder, text files count only where there is nothing else: they may be tables.

    Raises
    ------
    BadInput
        A folder without scans, or a path that does not exist.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            found += _list_folder(path)
        elif path.exists():
            found.append(path)
        else:
            raise BadInput(f"{path} does not exist.", "Check the name.")
    return list(dict.fromkeys(found))


def _list_folder(folder: Path) -> list[Path]:
    text = set(FORMATS[TEXT].SUFFIXES)
    others = {suffix for module in FORMATS.values() for suffix in module.SUFFIXES} - text
    files = sorted((path for path in folder.iterdir() if path.is_file()), key=_natural)
    scans = [path for path in files if path.suffix.lower() in others]
    scans = scans or [path for path in files if path.suffix.lower() in text - {".csv"}]
    if not scans:
        raise BadInput(f"There is no scan in the folder {folder}.")
    return scans


def _natural(path: Path) -> list[tuple[float, str]]:
    """Key that sorts leaf_5 before leaf_10, and -5 before 5."""
    pieces = re.split(r"((?<![A-Za-z0-9])-?\d+(?:\.\d+)?)", path.name.casefold())
    return [(float(p), "") if k % 2 else (0.0, p) for k, p in enumerate(pieces)]


def understand(files: Sequence[Path], order: SeriesOrder) -> Understood:
    """What each file of a series is; see `SeriesOrder` for where that is said.

    Raises
    ------
    BadInput, WrongUse
        It is not said, or not for every file.
    """
    if order.angle_from is None and order.time_from is None:
        try:
            return read_names(files)
        except WrongUse:
            if not order.same_pose:
                raise
            unnamed = tuple(Entry(file, label=file.stem) for file in files)
            return Understood(unnamed, "nothing but names")
    told = [
        _read(files, text, role)
        for text, role in ((order.angle_from, "angle"), (order.time_from, "hours"))
        if text is not None
    ]
    if len(told) == 1:
        return told[0]
    angles, times = told
    entries = tuple(
        replace(one, hours=other.hours, moment=other.moment)
        for one, other in zip(angles.entries, times.entries, strict=True)
    )
    return Understood(entries, f"{angles.how}; {times.how}")


def _read(files: Sequence[Path], text: str, role: str) -> Understood:
    if text == NAME:
        return read_names(files)
    if "{" in text:
        return match_names(files, text)
    if text.lower().endswith((".csv", ".tsv", ".txt")):
        return read_entries(files, Path(text))
    return type_entries(files, text, role)


def series_entries(reference: Reference) -> Understood:
    """Entries of the series that the reference's session holds; raises `WrongUse` without one."""
    if reference.series is None:
        raise WrongUse("The session holds no series of scans.", "Name the scans, or their folder.")
    entries = tuple(
        Entry(reference.files[one.scan], one.angle_deg, one.hours, None, one.treatment, one.label)
        for one in reference.series.entries
    )
    return Understood(entries, f"the series {reference.series.name} of the session")


def choose_reference(order: SeriesOrder, understood: Understood) -> Path:
    """The scan in which leaves are found: as said, else the one nearest to angle 0, or first."""
    if order.reference is not None:
        return order.reference
    entries = understood.entries
    if understood.turns:
        angles = [(abs(e.angle_deg), e) for e in entries if e.angle_deg is not None]
        return min(angles, key=lambda pair: pair[0])[1].file
    timed = [(e.hours, e) for e in entries if e.hours is not None]
    return min(timed, key=lambda pair: pair[0])[1].file if timed else entries[0].file
