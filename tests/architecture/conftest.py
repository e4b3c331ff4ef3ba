"""What the checks of the tree itself share: its files."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PRODUCT = ("app", "widgets", "resources", "packaging")
LEFT_OUT = {"__pycache__", "out", "build", "dist"}


def list_tracked() -> list[Path]:
    """Files that git knows; where it knows none (an unpacked archive), every file of the tree."""
    if shutil.which("git") is None:
        return walk(ROOT)
    run = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    names = run.stdout.split("\0")[:-1] if run.returncode == 0 else []
    known = [ROOT / name for name in names if (ROOT / name).is_file()]
    return known or walk(ROOT)


def walk(folder: Path) -> list[Path]:
    """Every file below a folder, without caches, builds and hidden folders."""
    found = []
    for path, folders, names in os.walk(folder):
        folders[:] = [f for f in folders if f not in LEFT_OUT and not f.startswith(".")]
        found += [Path(path) / name for name in names]
    return sorted(found)


@pytest.fixture(scope="session")
def root() -> Path:
    """Root of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def tracked() -> list[Path]:
    """Every file of the repository."""
    return list_tracked()


@pytest.fixture(scope="session")
def modules() -> dict[Path, ast.Module]:
    """The parsed Python files of the product, with tests left out."""
    paths = [path for name in PRODUCT for path in (ROOT / name).rglob("*.py")]
    return {path: ast.parse(path.read_text(encoding="utf-8"), str(path)) for path in paths}
