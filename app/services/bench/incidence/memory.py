"""Peak memory of the angles of a scan, measured in a process that does nothing else.

``python -m app.services.bench.incidence.memory SCAN.npz RADIUS`` prints bytes as JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from app.core.arrays import Floats
from app.core.errors import LeafscopeError
from app.core.incidence import incidence_angle, local_planes
from app.core.neighbours.steps import Cells
from app.services.bench.incidence.scenes import Truth

LONGEST = 600.0
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def measure_memory(truth: Truth, xyz: Floats, radius: float) -> float:
    """Bytes per grid cell, at most, that the angles of all points take beyond the points.

    Results are counted. It is the process's peak less what it held just before the call; where
    the system cannot begin a peak anew, an earlier one makes that too much, never too little.
    """
    with tempfile.TemporaryDirectory(prefix="leafscope-") as folder:
        path = Path(folder) / "scan.npz"
        grid = truth.grid
        np.savez(
            path, xyz=xyz, scanner=truth.scanner, row=grid.row, column=grid.column,
            shape=np.array([grid.rows, grid.columns]),
        )  # fmt: skip
        root = str(Path(__file__).parents[4])
        done = subprocess.run(
            [sys.executable, "-m", __name__, str(path), str(radius)],
            cwd=root, capture_output=True, text=True, timeout=LONGEST, check=False,
        )  # fmt: skip
    if done.returncode:
        raise LeafscopeError(f"Memory could not be measured: {done.stderr.strip()[-300:]}")
    return float(json.loads(done.stdout)["bytes"]) / truth.cells


def read_peak() -> int:
    """Largest memory that this process has held, bytes."""
    if STATUS.is_file():
        # Not getrusage: on Linux a new process inherits that from the one that started it.
        lines = STATUS.read_text(encoding="utf-8").splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM"))
    import psutil

    facts = psutil.Process().memory_info()
    if hasattr(facts, "peak_wset"):
        return int(facts.peak_wset)
    import resource

    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


def forget_peak() -> None:
    """Let the peak begin anew, where the system can."""
    if RESET.exists():
        with suppress(OSError):
            RESET.write_text("5", encoding="utf-8")


def main(path: str, radius: float) -> None:
    """Compute the angles of a scan and print what that took."""
    import psutil

    with np.load(path, allow_pickle=False) as file:
        xyz, scanner, (rows, columns) = file["xyz"], file["scanner"], file["shape"]
        cells = Cells(int(rows), int(columns), file["row"], file["column"])
    few = np.arange(min(100, len(xyz)))
    local_planes(xyz, scanner, few, radius, cells)
    forget_peak()
    before = psutil.Process().memory_info().rss
    planes = local_planes(xyz, scanner, None, radius, cells)
    omega = incidence_angle(xyz, planes.normals, scanner)
    taken = read_peak() - before
    print(json.dumps({"bytes": taken, "points": len(omega)}))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
