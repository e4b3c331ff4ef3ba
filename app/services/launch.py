"""Start the window as a process of its own; nothing of Qt is loaded here."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence

from app.core.errors import BadInput


def has_display() -> bool:
    """Whether a window could be shown; on Windows and macOS always."""
    if sys.platform in ("win32", "darwin"):
        return True
    offscreen = os.environ.get("QT_QPA_PLATFORM", "") in ("offscreen", "minimal", "vnc")
    return offscreen or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def open_window(arguments: Sequence[str]) -> None:
    """Open the window and wait until it is closed.

    Raises
    ------
    BadInput
        There is no display, or the window ended with an error.
    """
    if not has_display():
        raise BadInput(
            "There is no display, so no window can be opened.",
            "Use the commands of leafscope --help, e.g. leafscope demo --out demo.",
        )
    ended = subprocess.run([sys.executable, "-m", "widgets", *arguments], check=False)
    if ended.returncode != 0:
        raise BadInput(f"The window ended with an error ({ended.returncode}).")
