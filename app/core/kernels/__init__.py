"""Compiled loops. Imported late: numba costs a second when it is cold.

They are single-threaded and release the interpreter lock: `app.core.chunks` runs them in
threads. numba's own parallel loops cost two seconds to compile, and its default threading
layer aborts the process when two threads enter it at once.

`SAFE` holds the relaxations that still know what NaN is; full fastmath does not.

numba renews the cache of a function when its own file changes, not when a file that it calls
into does. So the cache lives in a folder named after all the sources together.
"""

from __future__ import annotations

import hashlib
import shutil
import time
from pathlib import Path

import platformdirs
from numba import config

SAFE = {"contract", "reassoc", "arcp", "nsz"}
INNER = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""Options of what only other kernels call: compiling the way in from Python takes long."""
KEEP_DAYS = 30.0
"""An older version's folder is removed when nobody has used it for so long."""


def choose_cache(sources: Path, base: Path) -> Path | None:
    """Folder under `base` for kernels compiled from these sources; None when not writable."""
    digest = hashlib.sha256()
    for source in sorted(sources.rglob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    folder = base / f"kernels-{digest.hexdigest()[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        folder.touch()
        drop_old(base)
    except OSError:
        return None
    return folder


def drop_old(base: Path) -> None:
    """Remove the folders of versions that were not used for `KEEP_DAYS`."""
    limit = time.time() - KEEP_DAYS * 86400
    for folder in base.glob("kernels-*"):
        if folder.stat().st_mtime < limit:
            shutil.rmtree(folder, ignore_errors=True)


if not config.CACHE_DIR:
    _chosen = choose_cache(Path(__file__).parent, Path(platformdirs.user_cache_dir("leafscope")))
    config.CACHE_DIR = str(_chosen or "")
