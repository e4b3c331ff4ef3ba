"""Session files: whole or not at all, and never trusted."""

from __future__ import annotations

import json
import os
from pathlib import Path

import h5py
import numpy as np
import pytest

from app.core.errors import BadInput
from app.formats import session as container
from app.formats.session import Session
from app.model.history import Entry
from app.model.operations import AddScan, MarkGhosts, Select, SetDeleted
from app.model.points import PointSet
from app.model.scan import Source
from app.model.selection import FieldRange
from app.model.view_state import ColourRange, ViewState

SOURCE = Source("/somewhere/scan.laz", 12, "ab" * 32, 1, {"every_nth": "2"})


@pytest.fixture
def session() -> Session:
    log = [
        Entry("do", AddScan("scan-00001", "scan", SOURCE)),
        Entry("do", SetDeleted("scan-00001", PointSet(range(0, 40_000, 2)))),
        Entry("do", MarkGhosts("scan-00001", PointSet([3]), PointSet([4]))),
        Entry("do", Select("scan-00001", PointSet(), FieldRange("range", 0.1, 1 / 3))),
        Entry("undo"),
        Entry("redo"),
    ]
    view = ViewState("scan-00001", colour="ndi", ranges={"ndi": ColourRange(-0.1, 1 / 7)})
    return Session({"scan-00001": SOURCE}, log, view)


def test_a_session_comes_back_equal(tmp_path: Path, session: Session) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    again = container.read(path)
    assert (again.sources, again.log, again.view) == (session.sources, session.log, session.view)


def test_the_same_session_gives_the_same_bytes(tmp_path: Path, session: Session) -> None:
    first, second = tmp_path / "a.leafscope", tmp_path / "b.leafscope"
    container.write(first, session)
    container.write(second, session)
    assert first.read_bytes() == second.read_bytes()


def test_an_older_file_is_kept_and_never_overwritten_unasked(
    tmp_path: Path, session: Session
) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    old = path.read_bytes()
    with pytest.raises(BadInput, match="exists already"):
        container.write(path, session)
    container.write(path, Session(session.sources, session.log[:1], session.view), overwrite=True)
    assert (tmp_path / "a.leafscope.bak").read_bytes() == old
    assert len(container.read(path).log) == 1


def test_a_failing_disk_leaves_the_old_file(
    tmp_path: Path, session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    old = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(BadInput, match="No space left"):
        container.write(path, Session({}, [], ViewState()), overwrite=True)
    assert path.read_bytes() == old
    assert [p for p in tmp_path.iterdir() if "tmp" in p.name] == []


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.6, 0.95, 0.999])
def test_a_cut_file_is_refused_in_words(tmp_path: Path, session: Session, share: float) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(BadInput, match=r"a\.leafscope"):
        container.read(path)


def test_flipped_bytes_are_refused_or_harmless(tmp_path: Path, session: Session) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    whole = path.read_bytes()
    random = np.random.default_rng(5)
    refused = 0
    for place in random.integers(8, len(whole), 60):
        broken = bytearray(whole)
        broken[place] ^= 0xFF
        path.write_bytes(broken)
        try:
            again = container.read(path)
        except BadInput:
            refused += 1
        else:
            assert again.log == session.log
    assert refused > 10


def test_a_newer_format_is_refused_politely(tmp_path: Path) -> None:
    path = tmp_path / "a.leafscope"
    with h5py.File(path, "w") as file:
        file["meta"] = np.frombuffer(b'{"version": 99, "strange": true}', np.uint8)
        file.create_group("arrays")
    with pytest.raises(BadInput, match=r"newer Leafscope.*Update"):
        container.read(path)


def test_a_claim_of_terabytes_takes_no_memory(tmp_path: Path, session: Session) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    with h5py.File(path, "a") as file:
        file["arrays"].create_dataset("bomb", shape=(10**12,), dtype="f8", chunks=(1024,))
    with pytest.raises(BadInput, match="claims more numbers"):
        container.read(path)


def test_what_is_no_session_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "a.leafscope"
    with h5py.File(other, "w") as file:
        file["x"] = np.arange(3)
    with pytest.raises(BadInput, match="not a Leafscope session"):
        container.read(other)
    other.write_bytes(b"LASF")
    with pytest.raises(BadInput, match="not a Leafscope session"):
        container.read(other)
    with pytest.raises(BadInput, match="cannot be opened"):
        container.read(tmp_path / "missing.leafscope")


@pytest.mark.parametrize("place", ["meta", "arrays"])
def test_a_group_where_numbers_belong_and_the_reverse_are_refused(
    tmp_path: Path, session: Session, place: str
) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    with h5py.File(path, "a") as file:
        del file[place]
        if place == "meta":
            file.create_group("meta")
        else:
            file["arrays"] = np.arange(3)
    with pytest.raises(BadInput, match="not a Leafscope session"):
        container.read(path)


def test_many_claims_that_are_each_small_enough_are_refused(
    tmp_path: Path, session: Session
) -> None:
    path = tmp_path / "a.leafscope"
    container.write(path, session)
    claim = 20 * path.stat().st_size
    with h5py.File(path, "a") as file:
        for number in range(300):
            file["arrays"].create_dataset(f"b{number}", (claim,), "f8", chunks=(1024,))
    with pytest.raises(BadInput, match="claims more numbers"):
        container.read(path)


def test_numbers_of_another_file_are_refused(tmp_path: Path, session: Session) -> None:
    (tmp_path / "secret").write_bytes(bytes(80))
    for number, kind in enumerate(("link", "external")):
        path = tmp_path / f"{number}.leafscope"
        container.write(path, session)
        with h5py.File(path, "a") as file:
            if kind == "link":
                file["arrays"]["x"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/x")
            else:
                secret = [(str(tmp_path / "secret"), 0, 80)]
                file["arrays"].create_dataset("x", (10,), "f8", external=secret)
        with pytest.raises(BadInput, match="another"):
            container.read(path)


def test_endless_nesting_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.leafscope"
    deep = '{"op":"Several","name":"","steps":[' * 5000 + "]}" * 5000
    log = f'[{{"deed":"do","operation":{json.dumps(deep)}}}]'
    meta = f'{{"version":1,"written_by":"","sources":{{}},"log":{log},"view":{{}}}}'
    with h5py.File(path, "w") as file:
        file["meta"] = np.frombuffer(meta.encode(), np.uint8)
        file.create_group("arrays")
    with pytest.raises(BadInput, match="cannot be read"):
        container.read(path)
