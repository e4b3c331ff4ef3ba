"""Seconds in a report leave compilation out."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from app.formats.cloud import Cloud
from app.model.scan import Scan
from app.services.export import export

SCRIPT = """
import sys
from pathlib import Path
from app.services.preparation import warm_up
from app.services.opening import Opening, open_file


def count_compiled():
    kernels = [m for name, m in sys.modules.items() if name.startswith("app.core.kernels.")]
    return {
        (module.__name__, name): len(thing.signatures)
        for module in kernels
        for name, thing in vars(module).items()
        if hasattr(thing, "signatures")
    }


if __name__ == "__main__":
    project, (key,) = open_file(Opening(Path(sys.argv[1])))
    warm_up(project, key, ("ghost",))
    before = count_compiled()
    project.field(key, "ghost")
    print(sum(before.values()), count_compiled() == before)
"""


@pytest.mark.parametrize("gridded", [True, False])
def test_the_kernels_of_a_field_are_compiled_before_it_is_timed(
    leaves: Scan, tmp_path: Path, gridded: bool
) -> None:
    path = tmp_path / "leaves.laz"
    export(Cloud(leaves if gridded else replace(leaves, grid=None)), path)
    script = tmp_path / "warm.py"
    script.write_text(SCRIPT)
    words = [sys.executable, str(script), str(path)]
    root = Path(__file__).parents[2]
    done = subprocess.run(
        words, capture_output=True, text=True, check=True, env={"PYTHONPATH": str(root)}
    )
    compiled, same = done.stdout.split()
    assert int(compiled) > 5
    assert same == "True"
