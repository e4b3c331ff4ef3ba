"""Undo and redo without a limit of steps, and the log that a session keeps."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.model.codec import decode, encode
from app.model.operations import AnyOperation
from app.model.state import State

Deed = Literal["do", "undo", "redo"]
DEFAULT_CAP = 512 * 2**20


class Entry(msgspec.Struct, frozen=True):
    """One line of the log: an operation done, or a step back or forth."""

    deed: Deed
    operation: AnyOperation | None = None


@dataclass(slots=True)
class Step:
    """A done operation and the way back, which may lie on disk."""

    operation: AnyOperation
    inverse: AnyOperation | Path
    nbytes: int


class History:
    """Done steps, undone steps and the log of everything; the log is never shortened.

    Where a drag goes on, its line in the log is written anew: a brush over millions of points
    would fill the session file with selections that nobody can go back to.

    Parameters
    ----------
    cap : int
        Bytes of inverses to hold in memory; the oldest beyond it go to disk.

    Attributes
    ----------
    log : list of Entry
    deeds : int
        How often something was done, undone or redone; unlike the log it grows in a drag too.
    """

    def __init__(self, cap: int = DEFAULT_CAP) -> None:
        self.log: list[Entry] = []
        self.deeds = 0
        self._done: list[Step] = []
        self._undone: list[AnyOperation] = []
        self._cap = cap
        self._spill: tempfile.TemporaryDirectory[str] | None = None
        self._spilled = 0

    @property
    def done(self) -> tuple[AnyOperation, ...]:
        """Operations in force, oldest first."""
        return tuple(step.operation for step in self._done)

    @property
    def undone(self) -> tuple[AnyOperation, ...]:
        """Operations that redo would bring back, next first."""
        return tuple(reversed(self._undone))

    @property
    def on_disk(self) -> int:
        """How many inverses lie on disk."""
        return sum(isinstance(step.inverse, Path) for step in self._done)

    def do(self, operation: AnyOperation, state: State) -> State:
        """Apply an operation; whatever was undone before can no longer be redone."""
        state, inverse = operation.apply(state)
        self._undone.clear()
        if self._done and operation.follows(self._done[-1].operation):
            if self.log[-1].operation is self._done[-1].operation:
                self.log.pop()
            self._done[-1].operation = operation
        else:
            self._push(operation, inverse)  # type: ignore[arg-type]
        self._note(Entry("do", operation))
        return state

    def undo(self, state: State) -> State:
        """Take back the last step; nothing happens when there is none."""
        if not self._done:
            return state
        step = self._done[-1]
        state, _ = self._inverse(step).apply(state)
        self._done.pop()
        self._undone.append(step.operation)
        self._note(Entry("undo"))
        return state

    def redo(self, state: State) -> State:
        """Do again what was undone last; nothing happens when there is none."""
        if not self._undone:
            return state
        operation = self._undone[-1]
        state, inverse = operation.apply(state)
        self._undone.pop()
        self._push(operation, inverse)  # type: ignore[arg-type]
        self._note(Entry("redo"))
        return state

    def restore(self, log: list[Entry], state: State) -> State:
        """Replay a stored log; steps that were undone are not applied, but can be redone."""
        done, undone = settle(log)
        for operation in done:
            state, inverse = operation.apply(state)
            self._push(operation, inverse)  # type: ignore[arg-type]
        self._undone = list(undone)
        self.log = list(log)
        self.deeds = len(log)
        return state

    def _note(self, entry: Entry) -> None:
        self.log.append(entry)
        self.deeds += 1

    def _push(self, operation: AnyOperation, inverse: AnyOperation) -> None:
        self._done.append(Step(operation, inverse, _weigh(inverse)))
        held = sum(s.nbytes for s in self._done if not isinstance(s.inverse, Path))
        for step in self._done[:-1]:
            if held <= self._cap:
                break
            if not isinstance(step.inverse, Path):
                held -= step.nbytes
                step.inverse = self._write(step.inverse)

    def _write(self, inverse: AnyOperation) -> Path:
        if self._spill is None:
            self._spill = tempfile.TemporaryDirectory(prefix="leafscope-undo-")
        self._spilled += 1
        path = Path(self._spill.name) / f"{self._spilled}.npz"
        arrays: dict[str, AnyArray] = {}
        text = encode(inverse, arrays, "a")
        np.savez(path, allow_pickle=False, record=np.frombuffer(text, np.uint8), **arrays)
        return path

    def _inverse(self, step: Step) -> AnyOperation:
        if not isinstance(step.inverse, Path):
            return step.inverse
        try:
            with np.load(step.inverse, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
            step.inverse.unlink()
        except OSError as error:
            raise BadInput(
                f"The undo data in {step.inverse} cannot be read: {error.strerror or error}.",
                "Save the session: opening it again brings undo back.",
            ) from error
        return decode(arrays.pop("record").tobytes(), arrays)


def settle(log: list[Entry]) -> tuple[list[AnyOperation], list[AnyOperation]]:
    """Work out from a log which operations are in force and which could be redone.

    Returns
    -------
    done, undone : lists of operations
        `done` oldest first; the last of `undone` is the next to redo.

    Raises
    ------
    BadInput
        The log takes back more than was done.
    """
    done: list[AnyOperation] = []
    undone: list[AnyOperation] = []
    for entry in log:
        if entry.deed != "do" and not (done if entry.deed == "undo" else undone):
            raise BadInput(f"The log holds one {entry.deed} too many.")
        if entry.deed == "undo":
            undone.append(done.pop())
        elif entry.deed == "redo":
            done.append(undone.pop())
        elif entry.operation is not None:
            undone.clear()
            if done and entry.operation.follows(done[-1]):
                done[-1] = entry.operation
            else:
                done.append(entry.operation)
    return done, undone


def _weigh(operation: AnyOperation) -> int:
    arrays: dict[str, AnyArray] = {}
    return len(encode(operation, arrays, "a")) + sum(a.nbytes for a in arrays.values())
