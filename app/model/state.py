"""The document at one moment: immutable, shared freely between threads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from app.core.arrays import AnyArray, Bools
from app.core.errors import MissingChannel, WrongUse
from app.model.calibrated import calibrated_channels
from app.model.corrections import corrected_channels
from app.model.leaf import FitRecord, Leaf, Sample
from app.model.parameters import Parameters
from app.model.points import EMPTY, PointSet
from app.model.scan import Channel, Scan
from app.model.series import Series

V = TypeVar("V")


@dataclass(frozen=True, eq=False)
class ScanState:
    """A scan with everything that the user did to it.

    Attributes
    ----------
    scan : Scan
    deleted : (n,) bool array
        Deletion is a mask: nothing is lost.
    marks : (n,) int8 array
        1 marked as ghost, 2 as one to delete, 3 as one to correct; -1 kept though it looks like
        one; 0 not judged.
    selection : PointSet
    parameters : Parameters
    closed : bool
        Taken off the table; comes back by undo.
    confidence : (n,) float32 array or None
        Of points that were put back on a surface, that they lie right, 0 to 1; NaN for others.
    """

    scan: Scan
    deleted: Bools
    marks: AnyArray
    selection: PointSet = EMPTY
    parameters: Parameters = field(default_factory=Parameters)
    closed: bool = False
    confidence: AnyArray | None = None

    @classmethod
    def fresh(cls, scan: Scan) -> ScanState:
        """A scan as it was read."""
        return cls(scan, np.zeros(len(scan), bool), np.zeros(len(scan), np.int8))

    @cached_property
    def alive(self) -> Bools:
        """Points that exist for the user: finite and not deleted, (n,) booleans."""
        return self.scan.valid & ~self.deleted

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Calibrated channels, then those of the file, then corrected ones.

        The earlier is the better one to use where nothing is said. Without a scanner position
        nothing can be corrected.
        """
        given = (*calibrated_channels(self.scan, self.parameters.profile), *self.scan.channels)
        if self.scan.pose is None:
            return given
        return (*given, *corrected_channels(self.parameters.corrections, given))

    def channel(self, name: str) -> Channel:
        """The channel of that name; raises `MissingChannel` with the names there are."""
        return self.scan.with_channels(self.channels).channel(name)

    @property
    def wavelengths(self) -> dict[str, float | None]:
        """Wavelength of each channel that is not corrected, nm, by its name; calibrated first."""
        return self.wavelengths_of("")

    def wavelengths_of(self, workflow: str) -> dict[str, float | None]:
        """Wavelength of each channel of one workflow, by its name: an index never mixes them."""
        return {c.name: c.wavelength_nm for c in self.channels if c.workflow == workflow}

    @property
    def workflows(self) -> tuple[str, ...]:
        """How channels are corrected, each way once; "" for those that are not."""
        return tuple(dict.fromkeys(("", *(channel.workflow for channel in self.channels))))

    def channel_in_use(self, needed_for: str) -> Channel:
        """The channel that fits and angles from intensity use.

        Raises
        ------
        MissingChannel
            The scan has no intensity; the sentence names `needed_for`.
        """
        if self.parameters.channel is not None:
            return self.channel(self.parameters.channel)
        if not self.channels:
            raise MissingChannel(
                f"{self.scan.name} has no intensity, and {needed_for} needs it.",
                "Name a channel if one of its attributes is an intensity.",
            )
        return self.channels[0]

    @cached_property
    def shown(self) -> int:
        """Number of points that exist for the user."""
        return int(np.count_nonzero(self.alive))


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All that a session holds, apart from how it is looked at."""

    library: Mapping[str, Scan] = field(default_factory=dict)
    scans: Mapping[str, ScanState] = field(default_factory=dict)
    leaves: Mapping[str, Leaf] = field(default_factory=dict)
    fits: Mapping[str, FitRecord] = field(default_factory=dict)
    samples: Mapping[str, Sample] = field(default_factory=dict)
    series: Mapping[str, Series] = field(default_factory=dict)

    def scan(self, key: str) -> ScanState:
        """The scan of that key; raises `WrongUse` when there is none."""
        if key not in self.scans:
            raise WrongUse(f"There is no scan {key} in this session.")
        return self.scans[key]

    def leaves_of(self, scan: str) -> tuple[Leaf, ...]:
        """Leaves of one scan, in the order of their keys."""
        return tuple(leaf for leaf in self.leaves.values() if leaf.scan == scan)

    def with_scan(self, key: str, scan: ScanState) -> State:
        """The same state with one scan put in place."""
        return replace(self, scans=put(self.scans, key, scan))


def put(mapping: Mapping[str, V], key: str, value: V | None) -> Mapping[str, V]:
    """A copy of a mapping with one value set, or taken out when it is None.

    Keys stay sorted, so that undoing a removal puts a leaf back in its old place.
    """
    copy = dict(mapping)
    if value is None:
        copy.pop(key, None)
    else:
        copy[key] = value
    return MappingProxyType(dict(sorted(copy.items())))


def next_key(keys: Iterable[str], stem: str) -> str:
    """A key that sorts behind the others: ``leaf-00004`` after ``leaf-00003``."""
    last = max((int(key.rpartition("-")[2]) for key in keys), default=0)
    return make_key(stem, last + 1)


def next_leaf_key(state: State) -> str:
    """A key for a new leaf, never that of a removed one to which a fit still refers."""
    fitted = (key for fit in state.fits.values() for key in fit.leaves)
    return next_key((*state.leaves, *fitted), "leaf")


def make_key(stem: str, number: int) -> str:
    """The key of that number."""
    return f"{stem}-{number:05d}"
