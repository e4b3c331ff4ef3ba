"""Files appear whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app.core.errors import BadInput, Cancelled
from app.formats.atomic import atomic_files, atomic_path, refuse_target, refuse_targets


def test_new_file_appears_after_the_block(tmp_path: Path) -> None:
    target = tmp_path / "a.ply"
    with atomic_path(target) as temporary:
        assert temporary == tmp_path / f"a.ply.tmp-{os.getpid()}"
        temporary.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    assert os.listdir(tmp_path) == ["a.ply"]


def test_existing_file_needs_permission(tmp_path: Path) -> None:
    target = tmp_path / "a.ply"
    target.write_text("old")
    with pytest.raises(BadInput, match="exists already"), atomic_path(target):
        pytest.fail("the block must not run")
    with atomic_path(target, overwrite=True) as temporary:
        temporary.write_text("new")
    assert target.read_text() == "new"


def write_half(target: Path, error: BaseException) -> None:
    with atomic_path(target, overwrite=True) as temporary:
        temporary.write_text("half")
        raise error


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), Cancelled(), KeyError()])
def test_failure_leaves_the_old_file(tmp_path: Path, error: BaseException) -> None:
    target = tmp_path / "a.ply"
    target.write_text("old")
    expected = BadInput if isinstance(error, OSError) else type(error)
    with pytest.raises(expected):
        write_half(target, error)
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.ply"]


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_fault_in_the_last_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    def fail(*_: object) -> None:
        raise OSError(5, "Input/output error")

    target = tmp_path / "a.ply"
    target.write_text("old")
    monkeypatch.setattr(os, step, fail)
    with (
        pytest.raises(BadInput, match="Input/output error"),
        atomic_path(target, overwrite=True) as temporary,
    ):
        temporary.write_text("new")
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.ply"]


def test_missing_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="does not exist"), atomic_path(tmp_path / "no" / "a.ply"):
        pytest.fail("the block must not run")


def test_folder_as_target_is_said(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="is a folder"), atomic_path(tmp_path, overwrite=True):
        pytest.fail("the block must not run")


NAMES = ("a.ptx", "a.ptx.fields.npz", "a.ptx.json")


def write_together(folder: Path, text: str) -> None:
    with atomic_files() as begin:
        for name in NAMES:
            begin(folder / name, True).write_text(text)


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_files_that_belong_together(tmp_path: Path) -> None:
    for text in ("old", "new"):
        write_together(tmp_path, text)
        assert contents(tmp_path) == dict.fromkeys(NAMES, text)


def write_without_permission(folder: Path) -> None:
    with atomic_files() as begin:
        for name in NAMES:
            begin(folder / name, False).write_text("new")


def test_the_second_of_several_files_needs_permission_too(tmp_path: Path) -> None:
    (tmp_path / NAMES[1]).write_text("old")
    with pytest.raises(BadInput, match=r"fields\.npz exists already"):
        write_without_permission(tmp_path)
    assert contents(tmp_path) == {NAMES[1]: "old"}


@pytest.mark.parametrize("old", [(), NAMES[:1], NAMES[1:], NAMES])
@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("failing", [0, 1, 2])
def test_one_that_cannot_be_renamed_takes_the_others_back(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    old: tuple[str, ...],
    links: bool,
    failing: int,
) -> None:
    replace = os.replace

    def fail(source: Path, target: Path) -> None:
        if target.name == NAMES[failing] and ".tmp-" in source.name:
            raise OSError(13, "Permission denied")
        replace(source, target)

    def refuse(*_: object) -> None:
        raise OSError(1, "Operation not permitted")

    for name in old:
        (tmp_path / name).write_text(f"old {name}")
    before = contents(tmp_path)
    monkeypatch.setattr(os, "replace", fail)
    if not links:
        monkeypatch.setattr(os, "link", refuse)
    with pytest.raises(BadInput, match=r"a\.ptx could not be written: Permission denied"):
        write_together(tmp_path, "new")
    assert contents(tmp_path) == before


def test_a_folder_without_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Root may write anywhere, so the system is made to say no.
    monkeypatch.setattr(os, "access", lambda _, mode: mode != os.W_OK)
    with pytest.raises(BadInput, match="may not write"):
        refuse_target(tmp_path / "a.laz", overwrite=False)
    refuse_target(tmp_path / "later" / "a.laz", overwrite=False, folder_follows=True)


@pytest.mark.parametrize("name", ["scan.laz", "x/../scan.laz", "link.laz", "hard.laz"])
def test_what_is_read_is_never_replaced(tmp_path: Path, name: str) -> None:
    source = tmp_path / "scan.laz"
    source.write_text("measured")
    (tmp_path / "x").mkdir()
    (tmp_path / "link.laz").symlink_to(source)
    (tmp_path / "hard.laz").hardlink_to(source)
    with pytest.raises(BadInput, match="would replace the measurements"):
        refuse_target(tmp_path / name, overwrite=True, sources=[tmp_path / "no.laz", source])
    refuse_target(tmp_path / "other.laz", overwrite=True, sources=[source])


def test_two_results_need_two_names(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="two results"):
        refuse_targets([tmp_path / "a.csv", tmp_path / "x" / ".." / "a.csv"], overwrite=True)
    refuse_targets([tmp_path / "a.csv", tmp_path / "b.csv"], overwrite=False)
