"""The open document: its state, its history, its fields, and who watches it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from msgspec.structs import replace as replace_fields
from psygnal import Signal

from app.core.arrays import Floats, Ints
from app.core.progress import QUIET, Progress
from app.model.catalogue import build_catalogue, catalogue_depends_on
from app.model.events import Aspect, Change
from app.model.field_cache import FieldCache
from app.model.fields import Catalogue, Evaluation, Same, Subject, Values, fingerprint
from app.model.history import DEFAULT_CAP, Entry, History
from app.model.operations import AnyOperation, SetParameters
from app.model.scan import Scan
from app.model.state import State, next_key, put

ASPECTS_OF_A_SCAN: dict[Aspect, str] = {
    "deleted": "deleted",
    "ghosts": "marks",
    "selection": "selection",
    "parameters": "parameters",
}


class Project:
    """A document. Only its owner's thread calls it; workers get `Subject` and `Values`.

    Parameters
    ----------
    undo_cap : int
        Bytes of undo data to hold in memory before the oldest go to disk.
    """

    changed = Signal(Change)

    def __init__(self, undo_cap: int = DEFAULT_CAP) -> None:
        self.state = State()
        self.history = History(undo_cap)
        self.cache = FieldCache()
        self.saved_at = 0
        self._catalogues: dict[str, tuple[object, Catalogue]] = {}

    @property
    def modified(self) -> bool:
        """Whether something was done since the last save."""
        return self.history.deeds != self.saved_at

    def shelve(self, scan: Scan, key: str | None = None) -> str:
        """Put a scan that was read into the library; give its key. Not an operation."""
        key = key or next_key(self.state.library, "scan")
        self.state = replace(self.state, library=put(self.state.library, key, scan))
        return key

    def do(self, operation: AnyOperation) -> None:
        """Apply an operation; it can be undone."""
        self._replace_state(self.history.do(operation, self.state))

    def set_parameters(self, scan: str, drag: str = "", **values: Any) -> None:
        """Change some parameters of a scan, as one step; the steps of one drag merge."""
        old = self.state.scan(scan).parameters
        self.do(SetParameters(scan, replace_fields(old, **values), drag))

    def undo(self) -> None:
        """Take back the last operation."""
        self._replace_state(self.history.undo(self.state))

    def redo(self) -> None:
        """Do again what was undone last."""
        self._replace_state(self.history.redo(self.state))

    def restore(self, log: list[Entry]) -> None:
        """Take over a stored log; the library must hold its scans already."""
        self._replace_state(self.history.restore(log, self.state))
        self.saved_at = self.history.deeds

    def catalogue(self, scan: str) -> Catalogue:
        """The fields that a scan can have, by name."""
        state = self.state.scan(scan)
        made_by = catalogue_depends_on(state.parameters)
        mark = (state.scan.channels, Same(state.scan.attributes), made_by)
        held = self._catalogues.get(scan)
        if held is None or held[0] != mark:
            held = (mark, build_catalogue(state.scan, state.parameters))
            self._catalogues[scan] = held
        return held[1]

    def subject(self, scan: str) -> Subject:
        """What fields of a scan are computed from, to hand to a worker."""
        return Subject(self.state.scan(scan), self.state.leaves_of(scan))

    def evaluation(self, scan: str, progress: Progress = QUIET) -> Evaluation:
        """A computation to run in any thread; give its results to `accept`."""
        return Evaluation(
            self.catalogue(scan), self.subject(scan), self.cache.known(scan), progress
        )

    def accept(self, scan: str, results: Mapping[str, Values]) -> None:
        """Take over computed fields and tell who watches; what has become stale is dropped."""
        self.cache.count(scan, results)
        valid = {
            name: values for name, values in results.items() if self._is_valid(scan, name, values)
        }
        if valid:
            self.cache.accept(scan, valid)
            self.changed.emit(Change(frozenset({"fields"}), frozenset(valid)))

    def field(
        self, scan: str, name: str, points: Ints | None = None, progress: Progress = QUIET
    ) -> Floats:
        """Values of a field at the points (None: all), computed here and now if need be."""
        evaluation = self.evaluation(scan, progress)
        values = evaluation.read(name, points)
        if evaluation.results:
            self.accept(scan, evaluation.results)
        return values

    def known_field(self, scan: str, name: str) -> Values | None:
        """Valid values of a field as far as they are there; computes nothing."""
        return self.cache.find(scan, self.catalogue(scan), name, self.subject(scan))

    def _is_valid(self, scan: str, name: str, values: Values) -> bool:
        if scan not in self.state.scans or name not in self.catalogue(scan):
            return False
        return values.fingerprint == fingerprint(self.catalogue(scan), name, self.subject(scan))

    def _replace_state(self, new: State) -> None:
        old, self.state = self.state, new
        aspects = differences(old, new)
        if aspects:
            self.changed.emit(Change(aspects))


def differences(old: State, new: State) -> frozenset[Aspect]:
    """Which aspects of the document differ between two states."""
    aspects: set[Aspect] = set()
    for name in ("leaves", "fits", "samples", "series"):
        if getattr(old, name) is not getattr(new, name):
            aspects.add(name)
    if old.scans.keys() != new.scans.keys():
        aspects.add("scans")
    for key in old.scans.keys() & new.scans.keys():
        before, after = old.scans[key], new.scans[key]
        if before is after:
            continue
        aspects |= {
            a
            for a, part in ASPECTS_OF_A_SCAN.items()
            if getattr(before, part) is not getattr(after, part)
        }
        if before.closed != after.closed:
            aspects.add("scans")
        if before.scan.xyz is not after.scan.xyz:
            aspects.add("points")
        if before.scan.pose != after.scan.pose:
            aspects.add("pose")
        if before.scan.channels != after.scan.channels:
            aspects.add("channels")
    return frozenset(aspects)
