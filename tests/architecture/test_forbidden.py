"""Calls that open a door to hostile data or give wrong numbers, and text that must not be kept."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

UNSAFE_MODULES = {"pickle", "cPickle", "_pickle", "cloudpickle", "dill", "marshal", "shelve"}
UNSAFE_CALLS = {"eval", "exec", "yaml.load", "os.system", "os.popen"}
# numba's fastmath=True lets the compiler assume that NaN cannot occur: wrong numbers on holes.
UNSAFE_KEYWORDS = {"shell", "allow_pickle", "fastmath"}

# Spelt in two pieces, so that this file does not hold what it looks for.
INDEX_NAMES = ("py" + "pi", "python" + "hosted", "ana" + "conda", "npm" + "js", "crates" + ".io")
INDEX = re.compile("|".join(map(re.escape, INDEX_NAMES)), re.IGNORECASE)
MACHINE_PATH = re.compile(r"(?<![\w.~-])/(?:work|home|root)(?![\w.-])")
MOST_BINARY_BYTES = 1_000_000
TOP_LEVEL = {
    "pyproject.toml", "app", "widgets", "resources", "tests", "packaging", "README.md", "LICENSE",
}  # fmt: skip


def find_unsafe_imports(node: ast.AST) -> Iterator[str]:
    names: list[str] = []
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        names = [node.module or ""]
    yield from (f"imports {n}" for n in names if n.split(".")[0] in UNSAFE_MODULES)


def find_unsafe_calls(node: ast.AST) -> Iterator[str]:
    if not isinstance(node, ast.Call):
        return
    if (name := ast.unparse(node.func)) in UNSAFE_CALLS:
        yield f"calls {name}"
    for word in node.keywords:
        if word.arg in UNSAFE_KEYWORDS and getattr(word.value, "value", None) is True:
            yield f"passes {word.arg}=True"


def find_swallowed_errors(node: ast.AST) -> Iterator[str]:
    if not isinstance(node, ast.ExceptHandler):
        return
    caught = "" if node.type is None else ast.unparse(node.type)
    if not caught:
        yield "has a bare except"
    elif caught in {"Exception", "BaseException"} and all(map(is_empty, node.body)):
        yield f"swallows every {caught}"


def is_empty(statement: ast.stmt) -> bool:
    return isinstance(statement, (ast.Pass, ast.Continue)) or (
        isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
    )


def find_faults(tree: ast.Module) -> list[str]:
    looks = (find_unsafe_imports, find_unsafe_calls, find_swallowed_errors)
    return [
        f"{getattr(node, 'lineno', 0)} {fault}"
        for node in ast.walk(tree)
        for look in looks
        for fault in look(node)
    ]


def is_binary(path: Path) -> bool:
    return b"\0" in path.read_bytes()[:8192]


def test_code_holds_nothing_forbidden(modules: dict[Path, ast.Module]) -> None:
    faults = [f"{path}:{row}" for path, tree in modules.items() for row in find_faults(tree)]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize(
    "code",
    [
        "import pickle",
        "from dill import loads",
        "eval('1')",
        "exec('x = 1')",
        "yaml.load(text)",
        "subprocess.run('ls', shell=True)",
        "np.load(path, allow_pickle=True)",
        "njit(fastmath=True)(f)",
        "try:\n    f()\nexcept:\n    g()",
        "try:\n    f()\nexcept Exception:\n    pass",
        "try:\n    f()\nexcept Exception:\n    ...",
    ],
)
def test_each_forbidden_thing_is_found(code: str) -> None:
    assert len(find_faults(ast.parse(code))) == 1


@pytest.mark.parametrize(
    "code",
    [
        "dialog.exec()",
        "njit(fastmath={'contract', 'nsz'})(f)",
        "np.load(path, allow_pickle=False)",
        "yaml.safe_load(text)",
        "try:\n    f()\nexcept ValueError:\n    pass",
        "try:\n    f()\nexcept Exception as error:\n    report(error)",
    ],
)
def test_harmless_twins_pass(code: str) -> None:
    assert find_faults(ast.parse(code)) == []


@pytest.mark.parametrize(("pattern", "what"), [(INDEX, "package index"), (MACHINE_PATH, "path")])
def test_text_names_no_index_and_no_machine(
    tracked: list[Path], pattern: re.Pattern[str], what: str
) -> None:
    found = [
        f"{path}:{number} {match.group()}"
        for path in tracked
        if not is_binary(path)
        for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1)
        if (match := pattern.search(line))
    ]
    assert not found, f"names a {what}:\n" + "\n".join(found)


def test_patterns_find_what_they_are_for() -> None:
    assert INDEX.search("see https://" + INDEX_NAMES[0] + ".org/simple")
    assert MACHINE_PATH.search("open('" + "/ho" + "me/anna/scan.e57')")
    assert not MACHINE_PATH.search("see example.org/work and ~/work and a frame/work")


def test_no_notebook_and_no_large_binary(tracked: list[Path]) -> None:
    refused = [
        f"{path} {path.stat().st_size} bytes"
        for path in tracked
        if path.suffix == ".ipynb" or (path.stat().st_size > MOST_BINARY_BYTES and is_binary(path))
    ]
    assert not refused, "notebooks and large binaries stay out: " + ", ".join(refused)


def test_packaging_is_no_package(root: Path) -> None:
    """packaging/__init__.py would hide the library of that name."""
    assert not (root / "packaging" / "__init__.py").exists()


def test_top_level_is_the_agreed_one(tracked: list[Path], root: Path) -> None:
    top = {path.relative_to(root).parts[0] for path in tracked}
    strange = {name for name in top - TOP_LEVEL if not name.startswith(".")}
    assert not strange, f"does not belong at the top of the repository: {sorted(strange)}"
