"""Runs the reading process: limits, progress, cancel, and a sentence when it dies."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import app
from app.core.errors import BadInput, WrongUse
from app.core.progress import Progress

POLL = 0.1  # seconds between two looks at cancel
_START = 60.0  # a cold disk may need this long to import numpy
_LONGEST_LINE = 1 << 16
# Address space of the interpreter and its libraries, before the first point.
_LIBRARIES = 1 << 30


@dataclass(frozen=True, slots=True)
class Limits:
    """What the reading process may use: bytes for points, seconds on the clock."""

    memory: int
    seconds: float


def run_reader(
    path: Path,
    format_name: str,
    options: dict[str, Any],
    folder: Path,
    limits: Limits,
    progress: Progress,
) -> None:
    """Read `path` in a process of its own; the scans lie in `folder` afterwards.

    Raises
    ------
    BadInput
        The file was refused, took too long, or crashed its reader.
    Cancelled
        `progress` was cancelled; the process is gone within `POLL` seconds.
    """
    request = {
        "path": str(path),
        "format": format_name,
        "options": options,
        "folder": str(folder),
        "memory": limits.memory + _LIBRARIES,
    }
    with (folder / "stderr.txt").open("wb") as errors:
        process = _start(errors)
        try:
            _send(process, request)
            _follow(process, path, limits.seconds, progress)
        finally:
            process.kill()
            process.wait()
            _close(process)


def _start(errors: IO[bytes]) -> subprocess.Popen[bytes]:
    root = str(Path(app.__file__).parents[1])
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH", "")))),
        "PYTHONUTF8": "1",
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "MALLOC_ARENA_MAX": "2",  # each arena reserves 64 MB of the address space
        "RUST_BACKTRACE": "0",
    }
    # -P: a folder that the user happens to stand in must not lend us its modules.
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "app.formats.child"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        env=environment,
        start_new_session=True,  # Ctrl-C is for us; we end the reader ourselves
    )


def _send(process: subprocess.Popen[bytes], request: dict[str, Any]) -> None:
    assert process.stdin is not None  # noqa: S101 (for mypy: it is a pipe)
    try:
        process.stdin.write(json.dumps(request).encode())
        process.stdin.close()
    except BrokenPipeError:
        return  # it died at once; `_follow` says so


def _follow(
    process: subprocess.Popen[bytes], path: Path, seconds: float, progress: Progress
) -> None:
    lines = _listen(process)
    fraction, text = 0.0, "Starting the reader"
    deadline = time.monotonic() + _START
    while True:
        progress.report(fraction, text)
        if time.monotonic() > deadline:
            raise BadInput(f"{path.name} could not be read within {seconds:.0f} s: stopped.")
        try:
            event = lines.get(timeout=POLL)
        except queue.Empty:
            continue
        match event["event"]:
            case "progress":
                fraction, text = float(event["fraction"]), str(event["text"])
            case "started":
                deadline = time.monotonic() + seconds
            case "error":
                raise _error(event)
            case "done":
                return
            case _:
                raise _crash(process, path)


def _listen(process: subprocess.Popen[bytes]) -> queue.Queue[dict[str, Any]]:
    """Events of the process; the last one is always ``done``, ``error`` or ``end``."""
    lines: queue.Queue[dict[str, Any]] = queue.Queue()
    thread = threading.Thread(target=_pump, args=(process.stdout, lines), daemon=True)
    thread.start()
    return lines


def _pump(stream: IO[bytes], lines: queue.Queue[dict[str, Any]]) -> None:
    try:
        while line := stream.readline(_LONGEST_LINE):
            lines.put(json.loads(line))
    except ValueError:  # a torn line of a dying process, or the pipe closed by us
        pass
    finally:
        lines.put({"event": "end"})


def _close(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(BrokenPipeError):  # what it never read cannot be flushed
                pipe.close()


def _error(event: dict[str, Any]) -> BadInput | WrongUse:
    kind = WrongUse if event["kind"] == "WrongUse" else BadInput
    return kind(str(event["what"]), str(event["hint"]))


def _crash(process: subprocess.Popen[bytes], path: Path) -> BadInput:
    code = process.wait()
    how = f"signal {-code}" if code < 0 else f"exit code {code}"
    return BadInput(
        f"The reader crashed on {path.name} ({how}); nothing else was harmed.",
        "The file is damaged or made to do harm; export it again from its source.",
    )
