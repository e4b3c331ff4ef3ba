"""Facts about the machine that a measurement was made on."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import version
from pathlib import Path

from app import __version__
from app.core.chunks import count_processors

PACKAGES = ("numpy", "scipy", "numba")


def describe_machine() -> dict[str, str]:
    """Processor, cores that may be used, memory, system and versions."""
    import psutil

    return {
        "processor": name_processor(),
        "cores": str(count_processors()),
        "memory": f"{psutil.virtual_memory().total / 2**30:.0f} GiB",
        "system": f"{platform.system()} {platform.machine()}",
        "python": sys.version.split()[0],
        "leafscope": __version__,
        **{name: version(name) for name in PACKAGES},
    }


def name_processor() -> str:
    """The processor's name, as well as the system tells it."""
    facts = Path("/proc/cpuinfo")
    if facts.is_file():
        for line in facts.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return " ".join(line.split(":", 1)[1].split())
    return platform.processor() or platform.machine()
