"""Small pieces: a file, a function and a class keep to their size; a name says what it holds."""

from __future__ import annotations

import ast
from pathlib import Path

MOST_LINES = 500
MANY_LINES = 300
SHARE_OF_LONG_FILES = 0.05
MOST_FUNCTION_LINES = 60
MOST_METHODS = 25
VAGUE_NAMES = {"util", "utils", "helper", "helpers", "manager", "managers"}
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
CODE = ("app", "widgets", "packaging")
SCRIPTS = ("", ".sh", ".spec", ".py")

Modules = dict[Path, ast.Module]


def count_lines(root: Path) -> dict[str, int]:
    paths = [p for name in CODE for p in (root / name).rglob("*") if p.suffix in SCRIPTS]
    return {
        str(path.relative_to(root)): len(path.read_text(encoding="utf-8").splitlines())
        for path in paths
        if path.is_file()
    }


def find_long_functions(path: Path, tree: ast.Module) -> list[str]:
    return [
        f"{path}:{node.lineno} {node.name}: {length} lines"
        for node in ast.walk(tree)
        if isinstance(node, FUNCTIONS)
        and (length := (node.end_lineno or 0) - node.lineno + 1) > MOST_FUNCTION_LINES
    ]


def find_large_classes(path: Path, tree: ast.Module) -> list[str]:
    return [
        f"{path}:{node.lineno} class {node.name}: {methods} methods"
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        and (methods := sum(isinstance(item, FUNCTIONS) for item in node.body)) > MOST_METHODS
    ]


def test_no_file_is_too_long(root: Path) -> None:
    long = [
        f"{path}:1 {lines} lines" for path, lines in count_lines(root).items() if lines > MOST_LINES
    ]
    assert not long, f"more than {MOST_LINES} lines:\n" + "\n".join(long)


def test_few_files_are_long(root: Path) -> None:
    sizes = count_lines(root)
    long = [f"{path}:1 {lines} lines" for path, lines in sizes.items() if lines > MANY_LINES]
    assert len(long) <= SHARE_OF_LONG_FILES * len(sizes), (
        f"{len(long)} of {len(sizes)} files have more than {MANY_LINES} lines:\n" + "\n".join(long)
    )


def test_functions_are_short(modules: Modules) -> None:
    long = [row for path, tree in modules.items() for row in find_long_functions(path, tree)]
    assert not long, f"more than {MOST_FUNCTION_LINES} lines:\n" + "\n".join(long)


def test_classes_are_small(modules: Modules) -> None:
    large = [row for path, tree in modules.items() for row in find_large_classes(path, tree)]
    assert not large, f"more than {MOST_METHODS} methods:\n" + "\n".join(large)


def test_names_say_what_they_hold(root: Path) -> None:
    paths = [path for name in CODE for path in (root / name).rglob("*")]
    vague = [str(p) for p in paths if VAGUE_NAMES & set(p.stem.lower().split("_"))]
    assert not vague, "name what the file holds: " + ", ".join(vague)


def test_budgets_are_measured_as_meant() -> None:
    """A function and a class just over their budget are found, those on it are not."""
    body = "    x = 1\n"
    long = ast.parse("def fits():\n" + body * 59 + "def bursts():\n" + body * 60)
    assert find_long_functions(Path("f.py"), long) == ["f.py:61 bursts: 61 lines"]
    method = "    def m(self): ...\n"
    large = ast.parse("class Fits:\n" + method * 25 + "class Bursts:\n" + method * 26)
    assert find_large_classes(Path("f.py"), large) == ["f.py:27 class Bursts: 26 methods"]
