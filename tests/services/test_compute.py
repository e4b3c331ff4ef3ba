"""Seconds in a report leave compilation out."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

SCRIPT = """
import sys
from pathlib import Path
from app.services.preparation import warm_up
from app.services.opening import Opening, open_file

if __name__ == "__main__":
    project, (key,) = open_file(Opening(Path(sys.argv[1])))
    warm_up(project, key, ("ghost",))
    from app.core.kernels import ghosts, grid

    print(len(ghosts.score_support.signatures), len(grid.fit_in_windows.signatures))
"""


def test_the_kernels_of_a_field_are_compiled_before_it_is_timed(
    leaves_file: Path, tmp_path: Path
) -> None:
    script = tmp_path / "warm.py"
    script.write_text(SCRIPT)
    words = [sys.executable, str(script), str(leaves_file)]
    root = Path(__file__).parents[2]
    done = subprocess.run(
        words, capture_output=True, text=True, check=True, env={"PYTHONPATH": str(root)}
    )
    assert done.stdout.split() == ["1", "1"]
