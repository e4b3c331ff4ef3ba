"""Fields on demand: what a field needs, what identifies its values, how it is computed.

A field is computed when somebody asks, for the points asked for, once. Its fingerprint
names everything that it depends on; a change of anything else leaves it alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.model.leaf import Leaf
from app.model.state import ScanState

FieldKind = Literal[
    "scalar",
    "angle",
    "signed angle",
    "signed",
    "score",
    "flag",
    "verdict",
    "mark",
    "correction",
    "class",
]
Need = Literal["points", "pose", "channels", "marks", "deleted", "leaves"]


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """What fields of one scan are computed from: immutable, free of the document."""

    state: ScanState
    leaves: tuple[Leaf, ...] = ()


@dataclass(frozen=True, slots=True)
class Computed:
    """Values for the points that were asked for, and what is worth telling about them.

    `beside` holds what the same work found besides, one value per point under each name;
    other fields read it with `Evaluation.read_beside`.
    """

    values: Floats
    notes: Mapping[str, object] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    beside: Mapping[str, AnyArray] = field(default_factory=dict)


Compute = Callable[["Evaluation", "Ints | None"], Computed]


@dataclass(frozen=True, slots=True)
class FieldSpec:
    """A field: its name and unit, what it depends on, and how it is computed.

    Attributes
    ----------
    inputs : tuple of str
        Other fields that it reads.
    parameters : tuple of str
        Attributes of `Parameters` that it depends on.
    needs : tuple of {'points', 'pose', 'channels', 'marks', 'deleted', 'leaves'}
        Parts of the scan that it reads besides.
    stored : bool
        The values are those of the attribute of the same name, as the file holds them.
    given : bool
        A service measures the values and hands them over; nobody can compute them on demand.
    compute : callable
        Given the evaluation and the points (None for all), gives one value per point.
    made_with : object
        What it depends on beside all these, told apart by its text.
    """

    name: str
    title: str
    unit: str
    kind: FieldKind
    compute: Compute
    inputs: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    needs: tuple[Need, ...] = ()
    stored: bool = False
    made_with: object = None
    given: bool = False


Catalogue = Mapping[str, FieldSpec]


class Same:
    """Compares by identity and keeps its object alive, so that an id is never reused."""

    __slots__ = ("thing",)

    def __init__(self, thing: object) -> None:
        self.thing = thing

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.thing is other.thing

    def __hash__(self) -> int:
        return id(self.thing)


def find_spec(catalogue: Catalogue, name: str) -> FieldSpec:
    """The field of that name; raises `WrongUse` with the names there are."""
    if name not in catalogue:
        raise WrongUse(f"There is no field {name} here; there are: {', '.join(catalogue)}.")
    return catalogue[name]


def fingerprint(catalogue: Catalogue, name: str, subject: Subject) -> tuple[Any, ...]:
    """Everything that the values of a field depend on; equal when they are still valid."""
    spec = find_spec(catalogue, name)
    state = subject.state
    parts: list[Any] = [spec.name, spec.title, repr(spec.made_with)]
    parts += [getattr(state.parameters, parameter) for parameter in spec.parameters]
    for need in spec.needs:
        match need:
            case "points":
                parts.append(Same(state.scan.xyz))
            case "pose":
                parts.append(state.scan.pose)
            case "channels":
                parts.append(state.scan.channels)
            case "marks":
                parts.append(Same(state.marks))
            case "deleted":
                parts.append(Same(state.deleted))
            case "leaves":
                parts.append(tuple((leaf.key, Same(leaf.members)) for leaf in subject.leaves))
    parts += [fingerprint(catalogue, other, subject) for other in spec.inputs]
    return tuple(parts)


@dataclass(slots=True, eq=False)
class Values:
    """Values of one field over a scan, as far as they were computed.

    `computed` counts all of them, `fresh` those of the last evaluation. `seconds` holds
    the field's own time under "own", without the fields it reads, and its stages beside it.
    `beside` holds what was found on the way, in rows like those of `values`.
    """

    fingerprint: tuple[Any, ...]
    values: Floats
    have: Bools
    complete: bool = False
    notes: dict[str, object] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    computed: int = 0
    fresh: int = 0
    beside: dict[str, AnyArray] = field(default_factory=dict)

    @classmethod
    def empty(cls, mark: tuple[Any, ...], size: int) -> Values:
        """Room for `size` values; untouched memory costs nothing until it is filled."""
        return cls(mark, np.empty(size), np.zeros(size, bool))

    def missing(self, points: Ints | None) -> Ints | None:
        """Points among those asked for that have no value yet; None means all of them."""
        if self.complete:
            return np.empty(0, np.int64)
        if points is None:
            return np.flatnonzero(~self.have) if self.computed else None
        return points[~self.have[points]]

    def covers(self, points: Ints | None) -> bool:
        """Whether all the points asked for have a value."""
        missing = self.missing(points)
        return missing is not None and len(missing) == 0

    def fill(self, points: Ints | None, computed: Computed) -> None:
        """Put values in place and count them."""
        if points is None:
            self.values, self.complete = computed.values, True
            self.beside = dict(computed.beside)
        else:
            self.values[points] = computed.values
            for name, found in computed.beside.items():
                self._room_beside(name, found)[points] = found
        self.have[slice(None) if points is None else points] = True
        self.computed += len(computed.values)
        self.fresh += len(computed.values)
        self.complete = self.complete or self.computed == len(self.values)
        self.notes.update(computed.notes)

    def join(self, newer: Values) -> Values:
        """What is known after `newer` arrived: a few points never replace many.

        Values that were handed out are read in workers, so only `newer` is filled up.
        """
        if newer.fingerprint != self.fingerprint or newer.complete:
            return newer
        if self.complete:
            return self
        newer.copy_rows(self, np.flatnonzero(self.have & ~newer.have))
        return newer

    def copy_rows(self, other: Values, rows: Ints) -> None:
        """Take over what another knows of some points."""
        self.values[rows] = other.values[rows]
        for name, found in other.beside.items():
            self._room_beside(name, found)[rows] = found[rows]
        self.have[rows] = True
        self.computed += len(rows)
        self.complete = self.computed == len(self.values)

    def _room_beside(self, name: str, like: AnyArray) -> AnyArray:
        if name not in self.beside:
            self.beside[name] = np.empty(len(self.values), like.dtype)
        return self.beside[name]

    def add_seconds(self, seconds: Mapping[str, float]) -> None:
        """Add run time, stage by stage."""
        for stage, value in seconds.items():
            self.seconds[stage] = self.seconds.get(stage, 0.0) + value


class Evaluation:
    """Computes fields for one request, in any thread; shares nothing with the document.

    Parameters
    ----------
    catalogue : mapping of str to FieldSpec
    subject : Subject
    known : mapping of str to Values
        What the cache holds; only read.
    progress : Progress
    """

    def __init__(
        self,
        catalogue: Catalogue,
        subject: Subject,
        known: Mapping[str, Values],
        progress: Progress = QUIET,
    ) -> None:
        self.catalogue = catalogue
        self.subject = subject
        self.progress = progress
        self.results: dict[str, Values] = {}
        self._known = known
        self._inner = 0.0

    @property
    def size(self) -> int:
        """Number of points of the scan."""
        return len(self.subject.state.scan)

    def read(self, name: str, points: Ints | None = None) -> Floats:
        """Values of a field at the points (None: all), computing what is missing."""
        return pick_rows(self._values(name, points).values, points)

    def read_beside(self, name: str, what: str, points: Ints | None = None) -> AnyArray:
        """What the computation of a field found besides, computing what is missing."""
        return pick_rows(self._values(name, points).beside[what], points)

    def _values(self, name: str, points: Ints | None) -> Values:
        mark = fingerprint(self.catalogue, name, self.subject)
        known = self._known.get(name)
        if known is not None and known.fingerprint == mark and known.covers(points):
            return known
        held = self._result(name, mark)
        if not held.covers(points):
            self._compute(name, held, held.missing(points))
        return held

    def _result(self, name: str, mark: tuple[Any, ...]) -> Values:
        if name not in self.results:
            fresh = Values.empty(mark, self.size)
            known = self._known.get(name)
            if known is not None and known.fingerprint == mark and known.computed:
                fresh.copy_rows(known, np.flatnonzero(known.have))
                fresh.notes.update(known.notes)
                fresh.seconds.update(known.seconds)
            self.results[name] = fresh
        return self.results[name]

    def _compute(self, name: str, held: Values, points: Ints | None) -> None:
        start, outer = time.perf_counter(), self._inner
        self._inner = 0.0
        computed = find_spec(self.catalogue, name).compute(self, points)
        held.fill(points, computed)
        elapsed = time.perf_counter() - start
        # Fields read meanwhile count their own time; it is added up again in reports.
        held.add_seconds({"own": elapsed - self._inner, **computed.seconds})
        self._inner = outer + elapsed


def pick_rows(values: AnyArray, points: Ints | None) -> AnyArray:
    """The values of some points; None means all of them."""
    return values if points is None else values[points]
