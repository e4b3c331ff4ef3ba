"""Series: scans of the same leaves at other angles of their holder, or at other times."""

from __future__ import annotations

import math
from collections.abc import Mapping

import msgspec
from msgspec.structs import replace

from app.core.errors import WrongUse
from app.model.points import PointSet
from app.model.scan import Vector


class Correction(msgspec.Struct, frozen=True):
    """The points of a leaf in one scan, said by the user; none: the leaf is not in it.

    Attributes
    ----------
    leaf : str
        Key of the leaf in the series' reference scan.
    members : PointSet
    """

    leaf: str
    members: PointSet


class SeriesEntry(msgspec.Struct, frozen=True):
    """A scan of a series, and what was different when it was made.

    Attributes
    ----------
    scan : str
    angle_deg : float or None
        Of the holder.
    hours : float or None
    treatment, label : str
    corrections : tuple of Correction
    """

    scan: str
    angle_deg: float | None = None
    hours: float | None = None
    treatment: str = ""
    label: str = ""
    corrections: tuple[Correction, ...] = ()

    def __post_init__(self) -> None:
        for what, value in (("angle", self.angle_deg), ("time", self.hours)):
            if value is not None and not math.isfinite(value):
                raise WrongUse(f"The {what} of a scan must be a number, not {value}.")

    def corrected(self, leaf: str) -> PointSet | None:
        """What the user said of a leaf; None where nothing was said."""
        found = (one.members for one in self.corrections if one.leaf == leaf)
        return next(found, None)


class HolderAxis(msgspec.Struct, frozen=True):
    """The axis of a holder, in world coordinates; it turns by the right-hand rule.

    Attributes
    ----------
    point : (x, y, z)
        Metres.
    direction : (x, y, z)
        Unit vector.
    origin : str
        Where it comes from in words, e.g. "picked" or "fit of 18 planes".
    """

    point: Vector
    direction: Vector
    origin: str = ""


class Series(msgspec.Struct, frozen=True):
    """Scans of the same leaves.

    The leaves are those of the reference scan; those of the others are carried from there.

    Attributes
    ----------
    key, name : str
    entries : tuple of SeriesEntry
    reference : str
        Scan whose leaves are carried to the others; one of the entries.
    axis : HolderAxis or None
        About which the holder turns; None: all scans were made in the same pose.
    """

    key: str
    name: str
    entries: tuple[SeriesEntry, ...]
    reference: str
    axis: HolderAxis | None = None

    def entry(self, scan: str) -> SeriesEntry:
        """What is known of a scan; raises `WrongUse` where it is not of the series."""
        for entry in self.entries:
            if entry.scan == scan:
                return entry
        raise WrongUse(f"The scan {scan} is not in the series {self.name}.")

    def correct(self, scan: str, leaf: str, members: PointSet | None) -> Series:
        """The same series with another word on one leaf in one scan; None takes it back."""
        changed = self.entry(scan)
        kept = tuple(one for one in changed.corrections if one.leaf != leaf)
        said = () if members is None else (Correction(leaf, members),)
        entry = replace(changed, corrections=(*kept, *said))
        entries = tuple(entry if one.scan == scan else one for one in self.entries)
        return replace(self, entries=entries)


def check_series(series: Series, sizes: Mapping[str, int]) -> None:
    """Refuse (`WrongUse`) a series that cannot be.

    Parameters
    ----------
    series : Series
    sizes : mapping of str to int
        Points of each scan there is.
    """
    scans = [entry.scan for entry in series.entries]
    if len(set(scans)) != len(scans):
        raise WrongUse(f"A scan is in the series {series.name} twice.")
    series.entry(series.reference)
    for entry in series.entries:
        if entry.scan not in sizes:
            raise WrongUse(f"There is no scan {entry.scan} in this session.")
        for one in entry.corrections:
            rows = one.members.indices
            if len(rows) and not 0 <= rows[0] <= rows[-1] < sizes[entry.scan]:
                raise WrongUse(
                    f"The points {rows[0]} to {rows[-1]} are not all in {entry.scan}, which has "
                    f"{sizes[entry.scan]}."
                )
