"""The two commands of the README and the pins they install."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

import pytest

SCRIPTS = ("packaging/run", "packaging/test", "packaging/lock", "packaging/setup.sh", ".ci/run")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
PIN = re.compile(r"[a-z0-9][a-z0-9-]*==[0-9][0-9A-Za-z.+!-]*( ; .+)?")
posix = pytest.mark.skipif(os.name != "posix", reason="the scripts are for bash")


def normalise(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def read_pins(root: Path) -> list[str]:
    return (root / "packaging/constraints.txt").read_text(encoding="utf-8").splitlines()


def list_requirements(root: Path) -> set[str]:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = chain(project["dependencies"], *project["optional-dependencies"].values())
    return {normalise(match.group()) for line in lines if (match := NAME.match(line))}


def write_program(folder: Path, name: str, code: str) -> None:
    path = folder / name
    path.write_text(f"#!/bin/bash\n{code}\n", encoding="utf-8")
    path.chmod(0o755)


def source_setup(root: Path, programs: Path, command: str) -> subprocess.CompletedProcess[str]:
    """Run a command of setup.sh with the programs of a folder before all others."""
    return subprocess.run(
        ["bash", "-c", f'set -euo pipefail; source "$1"; {command}', "-",
         str(root / "packaging/setup.sh")],
        env={**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"},
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


@posix
@pytest.mark.parametrize("script", SCRIPTS)
def test_scripts_parse_and_start_by_bash(root: Path, script: str) -> None:
    path = root / script
    subprocess.run(["bash", "-n", str(path)], check=True)
    if path.suffix != ".sh":
        text = path.read_text(encoding="utf-8")
        assert text.startswith("#!/usr/bin/env bash\n")
        assert "set -euo pipefail" in text
        assert os.access(path, os.X_OK)


@posix
@pytest.mark.skipif(shutil.which("shellcheck") is None, reason="shellcheck is not installed")
def test_shellcheck_finds_nothing(root: Path) -> None:
    paths = [str(root / script) for script in SCRIPTS]
    run = subprocess.run(
        ["shellcheck", "--shell=bash", "--severity=warning", "--exclude=SC1091,SC2034", *paths],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout


def test_every_requirement_is_pinned(root: Path) -> None:
    pinned = {normalise(line.split("==")[0]) for line in read_pins(root)}
    assert not list_requirements(root) - pinned, "run packaging/lock"


def test_constraints_are_plain_pins(root: Path) -> None:
    strange = [line for line in read_pins(root) if not PIN.fullmatch(line) or "://" in line]
    assert not strange


@posix
def test_only_missing_system_packages_are_asked_for(root: Path, tmp_path: Path) -> None:
    """A package counts as present under its own name or under one that it provides."""
    write_program(
        tmp_path,
        "dpkg-query",
        "echo 'installed libgl1 '\n"
        "echo 'installed libglib2.0-0t64 libglib2.0-0 (= 2.80), libglib2.0-0t64-udeb'\n"
        "echo 'config-files libegl1 '",
    )
    run = source_setup(root, tmp_path, "missing_packages libgl1 libglib2.0-0 libegl1 xvfb")
    assert run.stdout.split() == ["libegl1", "xvfb"]


@posix
def test_without_rights_the_command_to_type_is_printed(root: Path, tmp_path: Path) -> None:
    write_program(tmp_path, "sudo", "exit 1")
    run = source_setup(root, tmp_path, "is_root() { return 1; }; install_packages xvfb openbox")
    assert run.returncode == 1
    assert "apt-get install -y --no-install-recommends xvfb openbox" in run.stderr


@posix
def test_system_packages_are_installed_without_questions(root: Path, tmp_path: Path) -> None:
    log = tmp_path / "log"
    write_program(tmp_path, "apt-get", f'echo "$DEBIAN_FRONTEND $*" >>"{log}"')
    run = source_setup(root, tmp_path, "is_root() { return 0; }; install_packages xvfb openbox")
    assert run.returncode == 0, run.stderr
    update, install = log.read_text(encoding="utf-8").splitlines()
    assert update.startswith("noninteractive")
    assert update.endswith(" update")
    assert install.endswith("install -y --no-install-recommends xvfb openbox")


@posix
def test_an_empty_shim_is_no_python(root: Path, tmp_path: Path) -> None:
    """The first name that starts and is new enough is taken."""
    write_program(tmp_path, "python3.11", "exit 127")
    write_program(tmp_path, "python3.12", f'exec "{sys.executable}" "$@"')
    assert source_setup(root, tmp_path, "find_python").stdout == "python3.12"


@posix
def test_a_python_without_ensurepip_asks_for_its_venv_package(root: Path, tmp_path: Path) -> None:
    write_program(
        tmp_path, "bare", f'[[ $2 == *ensurepip* ]] && exit 1; exec "{sys.executable}" "$@"'
    )
    version = "{}.{}".format(*sys.version_info)
    run = source_setup(root, tmp_path, "python_packages bare; echo; python_packages ''")
    assert run.stdout.splitlines() == [f"python{version}-venv", "python3 python3-venv"]


@posix
def test_a_failed_step_shows_its_output_and_stops(root: Path, tmp_path: Path) -> None:
    run = source_setup(root, tmp_path, "timed Trying bash -c 'echo the cause; exit 3'; echo on")
    assert run.returncode == 1
    assert "the cause" in run.stderr
    assert "this step failed: Trying" in run.stderr
    assert run.stdout.split() == ["Trying", "..."]
