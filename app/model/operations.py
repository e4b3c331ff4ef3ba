"""Every change of the document: an immutable record whose application gives its inverse."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import msgspec
import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import WrongUse
from app.core.units import count_points
from app.model.leaf import FitRecord, Leaf, Sample
from app.model.parameters import Parameters
from app.model.points import EMPTY, PointSet
from app.model.scan import Channel, Pose, Source
from app.model.selection import Selection
from app.model.series import Series, check_series
from app.model.state import ScanState, State, put

Applied = tuple[State, "Operation"]


class Operation(msgspec.Struct, frozen=True, tag_field="op", tag=True):
    """Base of all operations. `apply` never changes the state that it is given."""

    @property
    def title(self) -> str:
        """What the history shows, e.g. "Delete 812 points"."""
        raise NotImplementedError

    def apply(self, state: State) -> Applied:
        """Give the new state and the operation that leads back."""
        raise NotImplementedError

    def follows(self, earlier: Operation) -> bool:
        """Say whether this one only goes on with a drag that `earlier` began."""
        return False


class AddScan(Operation, frozen=True):
    """Put a scan that was read into the library on the table."""

    scan: str
    name: str
    source: Source | None

    @property
    def title(self) -> str:
        return f"Open {self.name}"

    def apply(self, state: State) -> Applied:
        if self.scan not in state.library:
            raise WrongUse(f"The scan {self.name} was not read before it was opened.")
        return (
            state.with_scan(self.scan, ScanState.fresh(state.library[self.scan])),
            DropScan(self.scan, self.name, self.source),
        )


class DropScan(Operation, frozen=True):
    """Inverse of `AddScan`: all else that was done to the scan is undone already."""

    scan: str
    name: str
    source: Source | None

    @property
    def title(self) -> str:
        return f"Take {self.name} out"

    def apply(self, state: State) -> Applied:
        state.scan(self.scan)
        return (
            replace(state, scans=put(state.scans, self.scan, None)),
            AddScan(self.scan, self.name, self.source),
        )


class CloseScan(Operation, frozen=True):
    """Take a scan off the table, or put it back; its leaves stay with it."""

    scan: str
    closed: bool = True

    @property
    def title(self) -> str:
        return "Close scan" if self.closed else "Bring scan back"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        new = replace(old, closed=self.closed)
        return state.with_scan(self.scan, new), CloseScan(self.scan, old.closed)


class SetPose(Operation, frozen=True):
    """Say where the scanner stood, or that nobody knows."""

    scan: str
    pose: Pose | None

    @property
    def title(self) -> str:
        if self.pose is None:
            return "Mark scanner position unknown"
        x, y, z = self.pose.position
        return f"Set scanner position {x:g}, {y:g}, {z:g} ({self.pose.known_by})"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        new = replace(old, scan=old.scan.with_pose(self.pose))
        return state.with_scan(self.scan, new), SetPose(self.scan, old.scan.pose)


class SetChannels(Operation, frozen=True):
    """Name channels by hand: wavelength and kind."""

    scan: str
    channels: tuple[Channel, ...]

    @property
    def title(self) -> str:
        return "Set channels " + ", ".join(channel.name for channel in self.channels)

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        missing = [c.attribute for c in self.channels if c.attribute not in old.scan.attributes]
        if missing:
            raise WrongUse(f"{old.scan.name} has no values named {', '.join(missing)}.")
        new = replace(old, scan=old.scan.with_channels(self.channels))
        return state.with_scan(self.scan, new), SetChannels(self.scan, old.scan.channels)


class SetDeleted(Operation, frozen=True):
    """Delete points, or bring them back; only those that change are in the inverse."""

    scan: str
    points: PointSet
    deleted: bool = True
    basis: Selection | None = None

    @property
    def title(self) -> str:
        verb = "Delete" if self.deleted else "Bring back"
        return f"{verb} {count_points(len(self.points))}"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        rows = _rows(self.points, old)
        changed = PointSet(rows[old.deleted[rows] != self.deleted])
        mask = old.deleted.copy()
        mask[changed.indices] = self.deleted
        new = replace(old, deleted=mask)
        return state.with_scan(self.scan, new), SetDeleted(self.scan, changed, not self.deleted)


class MarkGhosts(Operation, frozen=True):
    """Judge points: ghosts, kept though they look like ghosts, or not judged.

    Of ghosts it may be said what a clean-up is to do with them: delete or correct.
    """

    scan: str
    ghosts: PointSet = EMPTY
    kept: PointSet = EMPTY
    cleared: PointSet = EMPTY
    basis: Selection | None = None
    deleting: PointSet = EMPTY
    correcting: PointSet = EMPTY

    @property
    def title(self) -> str:
        parts = (
            ("Mark", self.ghosts, "as ghosts"),
            ("Keep", self.kept, "as no ghosts"),
            ("Unmark", self.cleared, ""),
            ("Mark", self.deleting, "to delete"),
            ("Mark", self.correcting, "to correct"),
        )
        words = [f"{verb} {count_points(len(p))} {end}".strip() for verb, p, end in parts if len(p)]
        return ", ".join(words) or "Mark no points"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        marks = old.marks.copy()
        judged = {1: self.ghosts, -1: self.kept, 0: self.cleared, 2: self.deleting,
                  3: self.correcting}  # fmt: skip
        touched = PointSet(np.concatenate([_rows(points, old) for points in judged.values()]))
        before = old.marks[touched.indices]
        for value, points in judged.items():
            marks[points.indices] = value
        ghosts, kept, cleared, deleting, correcting = (
            PointSet(touched.indices[before == value]) for value in judged
        )
        inverse = MarkGhosts(self.scan, ghosts, kept, cleared, None, deleting, correcting)
        return state.with_scan(self.scan, replace(old, marks=marks)), inverse


class Coordinates:
    """Immutable (k, 3) world coordinates inside an operation."""

    __slots__ = ("values",)

    def __init__(self, values: Floats) -> None:
        self.values = np.ascontiguousarray(values, np.float64)
        self.values.flags.writeable = False

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Coordinates):
            return NotImplemented
        return np.array_equal(self.values, other.values, equal_nan=True)

    def __hash__(self) -> int:
        return hash(self.values.tobytes())

    def __repr__(self) -> str:
        return f"Coordinates({len(self.values)} points)"


class Numbers:
    """Immutable (k,) float32 numbers inside an operation, one per point."""

    __slots__ = ("values",)

    def __init__(self, values: AnyArray) -> None:
        self.values = np.array(values, np.float32)
        self.values.flags.writeable = False

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Numbers):
            return NotImplemented
        return np.array_equal(self.values, other.values, equal_nan=True)

    def __hash__(self) -> int:
        return hash(self.values.tobytes())

    def __repr__(self) -> str:
        return f"Numbers({len(self.values)} points)"


class MovePoints(Operation, frozen=True):
    """Put points somewhere else: corrected ghosts, and how sure each of them is there."""

    scan: str
    points: PointSet
    to: Coordinates
    confidence: Numbers | None = None

    @property
    def title(self) -> str:
        return f"Move {count_points(len(self.points))}"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        rows = _rows(self.points, old)
        if len(rows) != len(self.to.values):
            raise WrongUse(f"{len(rows)} points cannot move to {len(self.to.values)} places.")
        if self.confidence is not None and len(self.confidence.values) != len(rows):
            raise WrongUse(f"{len(self.confidence.values)} confidences are not of these points.")
        before = None if old.confidence is None else Numbers(old.confidence[rows])
        back = MovePoints(self.scan, self.points, Coordinates(old.scan.xyz[rows]), before)
        xyz = old.scan.xyz.copy()
        xyz[rows] = self.to.values
        new = replace(old, scan=old.scan.with_xyz(xyz), confidence=self._weigh(old, rows))
        return state.with_scan(self.scan, new), back

    def _weigh(self, old: ScanState, rows: Ints) -> AnyArray | None:
        """Confidence of all points of the scan; None where none is known."""
        if old.confidence is None and self.confidence is None:
            return None
        size = len(old.scan)
        found = np.full(size, np.nan, np.float32) if old.confidence is None else old.confidence
        found = found.copy()
        found[rows] = np.nan if self.confidence is None else self.confidence.values
        return found if np.isfinite(found).any() else None


class Select(Operation, frozen=True):
    """Replace the selection of a scan; the steps of one drag merge."""

    scan: str
    points: PointSet
    basis: Selection | None = None
    drag: str = ""

    @property
    def title(self) -> str:
        return f"Select {count_points(len(self.points))}" if len(self.points) else "Clear selection"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        _rows(self.points, old)
        new = replace(old, selection=self.points)
        return state.with_scan(self.scan, new), Select(self.scan, old.selection)

    def follows(self, earlier: Operation) -> bool:
        return isinstance(earlier, Select) and _goes_on(self, earlier)


class SetParameters(Operation, frozen=True):
    """Change what fields are computed with; the steps of one drag merge."""

    scan: str
    parameters: Parameters
    drag: str = ""

    @property
    def title(self) -> str:
        return "Set parameters"

    def apply(self, state: State) -> Applied:
        old = state.scan(self.scan)
        new = replace(old, parameters=self.parameters)
        return state.with_scan(self.scan, new), SetParameters(self.scan, old.parameters)

    def follows(self, earlier: Operation) -> bool:
        return isinstance(earlier, SetParameters) and _goes_on(self, earlier)


class PutLeaf(Operation, frozen=True):
    """Make, extend, rename or (leaf None) remove a leaf; `verb` says which."""

    key: str
    leaf: Leaf | None
    verb: str = "Make"

    @property
    def title(self) -> str:
        if self.leaf is None:
            return "Remove leaf"
        return f"{self.verb} {self.leaf.name} ({count_points(len(self.leaf.members))})"

    def apply(self, state: State) -> Applied:
        if self.leaf is not None:
            _check_key(self.key, self.leaf.key)
            _rows(self.leaf.members, state.scan(self.leaf.scan))
        old = state.leaves.get(self.key)
        new = replace(state, leaves=put(state.leaves, self.key, self.leaf))
        return new, PutLeaf(self.key, old, self.verb)


class PutFit(Operation, frozen=True):
    """Keep a fit, or (fit None) forget it."""

    key: str
    fit: FitRecord | None

    @property
    def title(self) -> str:
        return f"Fit {self.fit.model} to {self.fit.channel}" if self.fit else "Forget fit"

    def apply(self, state: State) -> Applied:
        if self.fit is not None:
            _check_key(self.key, self.fit.key)
        old = state.fits.get(self.key)
        return replace(state, fits=put(state.fits, self.key, self.fit)), PutFit(self.key, old)


class PutSample(Operation, frozen=True):
    """Group scans of one sample, or (sample None) ungroup them."""

    key: str
    sample: Sample | None

    @property
    def title(self) -> str:
        return f"Group {self.sample.name}" if self.sample else "Ungroup"

    def apply(self, state: State) -> Applied:
        for scan in self.sample.scans if self.sample else ():
            state.scan(scan)
        old = state.samples.get(self.key)
        new = replace(state, samples=put(state.samples, self.key, self.sample))
        return new, PutSample(self.key, old)


class PutSeries(Operation, frozen=True):
    """Make or change a series of scans, or (series None) forget it; `verb` says which."""

    key: str
    series: Series | None
    verb: str = "Make"

    @property
    def title(self) -> str:
        if self.series is None:
            return "Forget series"
        return f"{self.verb} series {self.series.name} ({len(self.series.entries)} scans)"

    def apply(self, state: State) -> Applied:
        if self.series is not None:
            _check_key(self.key, self.series.key)
            check_series(self.series, {key: len(held.scan) for key, held in state.scans.items()})
        old = state.series.get(self.key)
        new = replace(state, series=put(state.series, self.key, self.series))
        return new, PutSeries(self.key, old, self.verb)


class Several(Operation, frozen=True):
    """Operations that belong together and are undone together."""

    name: str
    steps: tuple[AnyOperation, ...]

    @property
    def title(self) -> str:
        return self.name

    def apply(self, state: State) -> Applied:
        inverses: list[AnyOperation] = []
        for step in self.steps:
            state, inverse = step.apply(state)
            inverses.append(inverse)  # type: ignore[arg-type]
        return state, Several(self.name, tuple(reversed(inverses)))


AnyOperation = (
    AddScan
    | DropScan
    | CloseScan
    | SetPose
    | SetChannels
    | SetDeleted
    | MarkGhosts
    | MovePoints
    | Select
    | SetParameters
    | PutLeaf
    | PutFit
    | PutSample
    | PutSeries
    | Several
)


def _goes_on(later: Select | SetParameters, earlier: Select | SetParameters) -> bool:
    return bool(later.drag) and (later.scan, later.drag) == (earlier.scan, earlier.drag)


def _check_key(key: str, own: str) -> None:
    if key != own or not key.rpartition("-")[2].isdecimal():
        raise WrongUse(f"{key!r} is no key of something that calls itself {own!r}.")


def _rows(points: PointSet, scan: ScanState) -> Ints:
    rows = points.indices
    if len(rows) and (rows[0] < 0 or rows[-1] >= len(scan.scan)):
        raise WrongUse(
            f"The points {rows[0]} to {rows[-1]} are not all in {scan.scan.name}, "
            f"which has {len(scan.scan)}."
        )
    return rows


def describe_parameters(old: Parameters, new: Parameters) -> Mapping[str, tuple[object, object]]:
    """Which parameters differ, as name -> (old, new)."""
    return {
        name: (getattr(old, name), getattr(new, name))
        for name in Parameters.__struct_fields__
        if getattr(old, name) != getattr(new, name)
    }
