"""The process that reads: ``python -m app.formats.child``.

It takes one request as JSON on stdin, tells its progress as JSON lines on stdout and leaves
the scans in a folder (`handover`). A hostile file can at worst end this process.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any, TextIO

_SILENCE = 0.05  # seconds between two progress lines


def main() -> int:
    """Serve the one request and end."""
    request = json.load(sys.stdin)
    _limit_memory(int(request["memory"]))
    with _take_stdout() as answers:
        _serve(request, _Speaker(answers))
    return 0


class _Speaker:
    """Writes one JSON object per line."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._last = 0.0

    def say(self, event: str, **facts: Any) -> None:
        self._stream.write(json.dumps({"event": event, **facts}) + "\n")
        self._stream.flush()

    def progress(self, fraction: float, text: str) -> None:
        now = time.monotonic()
        if now - self._last > _SILENCE:
            self._last = now
            self.say("progress", fraction=fraction, text=text)


def _limit_memory(most: int) -> None:
    """Bound the address space before anything large is imported; POSIX only."""
    if os.name != "posix":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _take_stdout() -> TextIO:
    """Keep stdout for the answers: whatever a library prints goes to stderr."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers


def _serve(request: dict[str, Any], speaker: _Speaker) -> None:
    from app.core.errors import LeafscopeError, WrongUse
    from app.formats.guard import library_errors

    path = Path(request["path"])
    try:
        with library_errors(path, "its reader"):
            _read(path, request, speaker)
    except LeafscopeError as error:
        kind = "WrongUse" if isinstance(error, WrongUse) else "BadInput"
        speaker.say("error", kind=kind, what=error.what, hint=error.hint)
    except MemoryError:
        what = f"{path.name} needs more memory than it may use."
        speaker.say("error", kind="BadInput", what=what, hint="Read every n-th point only.")
    else:
        speaker.say("done")


def _read(path: Path, request: dict[str, Any], speaker: _Speaker) -> None:
    from app.core.progress import LiveProgress
    from app.formats._registry import FORMATS
    from app.formats.handover import save_scans
    from app.formats.options import ReadOptions

    reader = FORMATS[request["format"]]
    options = ReadOptions.from_json(request["options"])
    speaker.say("started")
    scans = reader.read(path, options, LiveProgress(speaker.progress))
    save_scans(scans, Path(request["folder"]))


if __name__ == "__main__":
    sys.exit(main())
