"""Who may import whom: by the text of the code, and by what really gets loaded."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

QT = {"PySide6", "shiboken6", "PyQt6", "PyQt5", "qtpy", "pyqtgraph", "pyvistaqt", "superqt"}
VTK = {"vtk", "vtkmodules", "pyvista"}
HEAVY = {"numpy", "scipy", "numba", "matplotlib", "h5py"}

# Notes who asked first for each watched package; asking alone (find_spec) does not load it yet.
WATCH = """
import importlib, json, sys, traceback

watched, names = set(sys.argv[1].split(",")), sys.argv[2:]
chains = {}

def loaded():
    return {name: chain for name, chain in chains.items() if name in sys.modules}

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name in watched and name not in chains:
            frames = [f for f in traceback.extract_stack() if not f.filename.startswith("<frozen")]
            chains[name] = [f"{f.filename}:{f.lineno}" for f in frames[1:-1]]
        return None

sys.meta_path.insert(0, Watch())
"""
IMPORT = """
for name in names:
    importlib.import_module(name)
print(json.dumps(loaded()))
"""
HELP = """
sys.argv = ["leafscope", "--help"]
from app.cli import main
try:
    code = main()
except SystemExit as end:
    code = end.code
print()
print(json.dumps({"code": code, "loaded": loaded()}))
"""


def watch(code: str, packages: set[str], *names: str) -> tuple[str, dict]:
    """Run code in a fresh process; return what it printed and the JSON of its last line."""
    run = subprocess.run(
        [sys.executable, "-c", WATCH + code, ",".join(sorted(packages)), *names],
        capture_output=True, text=True, timeout=200, check=False,
        cwd=Path(__file__).parents[2],
    )  # fmt: skip
    assert run.returncode == 0, run.stderr[-4000:]
    *printed, last = run.stdout.splitlines()
    return "\n".join(printed), json.loads(last)


def describe(chains: dict[str, list[str]]) -> str:
    return "\n".join(f"{name} by way of\n  " + "\n  ".join(c) for name, c in chains.items())


def list_modules(root: Path) -> list[str]:
    paths = [path.relative_to(root) for path in sorted((root / "app").rglob("*.py"))]
    names = [".".join(path.with_suffix("").parts).removesuffix(".__init__") for path in paths]
    return [name for name in names if not name.endswith("__main__")]


def test_import_contracts_are_kept(root: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-c", "import sys; from importlinter.cli import lint_imports_command\n"
         "lint_imports_command()", "--no-cache"],
        cwd=root, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 broken" in run.stdout


def test_no_module_of_app_loads_qt(root: Path) -> None:
    _, loaded = watch(IMPORT, QT, *list_modules(root))
    assert not loaded, describe(loaded)


def test_only_render_loads_vtk(root: Path) -> None:
    names = [name for name in list_modules(root) if not f"{name}.".startswith("app.render.")]
    _, loaded = watch(IMPORT, VTK, *names)
    assert not loaded, describe(loaded)


def test_help_loads_nothing_heavy() -> None:
    printed, seen = watch(HELP, QT | VTK | HEAVY)
    assert seen["code"] in (0, None)
    assert "compute" in printed
    assert not seen["loaded"], describe(seen["loaded"])


@pytest.mark.parametrize("name", ["numpy", "pyvista"])
def test_the_watch_sees_an_import_and_names_its_chain(tmp_path: Path, name: str) -> None:
    """A module that imports a watched package through another one is found out."""
    _, loaded = watch(
        "import os\nos.makedirs(names[0] + '/asks', exist_ok=True)\n"
        "open(names[0] + '/asks/__init__.py', 'w').write('import ' + names[1])\n"
        "sys.path.insert(0, names[0])\nnames = ['asks']\n" + IMPORT,
        {name}, str(tmp_path), name,
    )  # fmt: skip
    assert any("asks" in step for step in loaded[name])


def test_the_watch_lets_a_question_pass() -> None:
    _, loaded = watch("import importlib.util\nimportlib.util.find_spec(names.pop())\n" + IMPORT,
                      {"numpy"}, "numpy")  # fmt: skip
    assert loaded == {}
