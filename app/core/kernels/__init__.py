"""Compiled loops. Imported late: numba costs a second when it is cold.

They are single-threaded and release the interpreter lock: `app.core.chunks` runs them in
threads. numba's own parallel loops cost two seconds to compile, and its default threading
layer aborts the process when two threads enter it at once.

A kernel's cache is renewed when its own file changes, not when a file that it calls into
does: after editing `plane.py` touch `grid.py` and `voxels.py`.

`SAFE` holds the relaxations that still know what NaN is; full fastmath does not.
"""

SAFE = {"contract", "reassoc", "arcp", "nsz"}
