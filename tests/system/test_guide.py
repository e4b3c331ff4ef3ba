"""What the guide shows works as it stands there."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from app.simulate.instrument import list_instruments
from app.simulate.parts import KINDS
from app.simulate.virtual_scan import simulate


@pytest.fixture(scope="module")
def guide() -> str:
    return (Path(__file__).parents[2] / "resources/docs/guide.md").read_text(encoding="utf-8")


def find_block(guide: str, language: str) -> str:
    (block,) = re.findall(rf"```{language}\n(.*?)```", guide, re.DOTALL)
    return str(block)


def test_the_scene_of_the_guide(guide: str, tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(find_block(guide, "toml"))
    scan = simulate(path, step_deg=0.05).scan
    assert set(scan.attributes["truth_leaf"]) == {-1, 0, 1}


def test_the_lines_of_python_of_the_guide(guide: str) -> None:
    ran = subprocess.run(
        [sys.executable, "-c", find_block(guide, "python")],
        cwd=Path(__file__).parents[2], capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    count, ghosts, mean = ran.stdout.split()
    assert int(count) > 1000
    assert 0 < float(ghosts) < 0.2
    assert float(mean) > 0


def test_the_guide_names_every_field_of_the_truth(guide: str) -> None:
    from app.model.truth_fields import _FIELDS

    said = set(re.findall(r"truth_(\w+)", guide))
    missing = [n for n in _FIELDS if re.sub(r"_[23xyz]$", "", n) not in {*said, "normal"}]
    assert missing == []


def test_the_guide_names_every_instrument_and_kind_of_part(guide: str) -> None:
    names = {*KINDS, *(tool.name for tool in list_instruments())}
    assert {name for name in names if not re.search(rf"\b{name}\b", guide)} == set()
