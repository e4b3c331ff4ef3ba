"""Every way a file can be wrong has its sentence; the process, the clock and the disk are safe."""

from __future__ import annotations

import hashlib
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest

from app.core.errors import BadInput, Cancelled, WrongUse
from app.core.progress import QUIET, LiveProgress
from app.formats import las
from app.formats.cloud import Cloud
from app.formats.isolation import Limits, run_reader
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.saving import save
from app.model.scan import Scan
from app.services import reading
from app.services.reading import hash_file, inspect_file, read_file

POINTS = 3000


@pytest.fixture(autouse=True)
def no_leftovers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Temporary files of these tests have a folder of their own, which is empty at the end."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []
    assert find_readers() == []


def find_readers() -> list[psutil.Process]:
    """Reading processes that we started; a display server may be our child as well."""
    return [p for p in psutil.Process().children() if "app.formats.child" in p.cmdline()]


def make_las(path: Path, n: int = POINTS) -> Path:
    rng = np.random.default_rng(4)
    intensity = rng.integers(0, 65536, n).astype(np.uint16)
    save(path, Cloud(Scan("s", rng.normal(size=(n, 3)), {"intensity": intensity})), las.write)
    return path


def test_a_file_is_read_with_its_source(tmp_path: Path) -> None:
    path = make_las(tmp_path / "ä b.laz")
    (scan,) = read_file(path)
    (direct,) = las.read(path, DEFAULTS, QUIET)
    assert np.array_equal(scan.xyz, direct.xyz)
    assert scan.source is not None
    assert scan.source.path == str(path)
    assert scan.source.size == path.stat().st_size
    assert scan.source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest() == hash_file(path)
    assert scan.source.options == {}


def test_options_travel_to_the_reader(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.las")
    (whole,) = read_file(path)
    (part,) = read_file(path, ReadOptions(every_nth=10, metres_per_unit=0.5))
    assert np.array_equal(part.xyz, whole.xyz[::10] * 0.5)
    assert part.source is not None
    assert part.source.options == {"every_nth": "10", "metres_per_unit": "0.5"}


def test_a_relative_path_becomes_absolute(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make_las(tmp_path / "a.las")
    monkeypatch.chdir(tmp_path)
    (scan,) = read_file("a.las")
    assert scan.source is not None
    assert scan.source.path == str(path)


def test_modules_in_the_current_folder_are_not_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_las(tmp_path / "a.las")
    (tmp_path / "numpy.py").write_text("raise SystemExit('hijacked')")
    monkeypatch.chdir(tmp_path)
    assert len(read_file(path)[0]) == POINTS


NOTHING = bytes(99)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("missing.las", None, "does not exist"),
        ("folder.las", "folder", "is a folder"),
        ("pipe.las", "pipe", "no regular file"),
        ("empty.las", b"", "is empty"),
        ("a.rxp", NOTHING, "raw RIEGL stream"),
        ("a.rdbx", NOTHING, "RIEGL point database"),
        ("a.png", b"\x89PNG\r\n\x1a\n" + bytes(99), "not a scan of a format"),
        ("a.las", b"LASF" + bytes(20), "ends inside its LAS header"),
        ("a.txt", b"LASF" + bytes(400), "LAS 0.0"),
        ("x" * 300, None, "cannot be opened|does not exist"),
        ("zero\0byte", None, "cannot be opened|does not exist"),
    ],
)
def test_every_wrong_place_has_its_sentence(
    tmp_path: Path, name: str, content: bytes | str | None, sentence: str
) -> None:
    path = tmp_path / name
    if content == "folder":
        path.mkdir()
    elif content == "pipe":
        os.mkfifo(path)
    elif isinstance(content, bytes):
        path.write_bytes(content)
    with pytest.raises(BadInput, match=sentence):
        read_file(path)


def test_a_file_without_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make_las(tmp_path / "a.las")
    # Root may read everything, so the answer of the system is played.
    monkeypatch.setattr(os, "access", lambda place, _: Path(place) != path)
    with pytest.raises(BadInput, match="may not be read by you"):
        read_file(path)


def test_the_magic_decides_not_the_suffix(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.laz").rename(tmp_path / "a.e57")
    assert inspect_file(path)[0] == "las"
    assert len(read_file(path)[0]) == POINTS


def test_memory_is_asked_before_it_is_taken(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.las")
    with pytest.raises(BadInput, match=r"--every-nth \d+") as refusal:
        read_file(path, memory_cap=30_000_000)
    nth = int(refusal.value.hint.split("--every-nth ")[1].split(")")[0])
    assert len(read_file(path, ReadOptions(every_nth=nth), memory_cap=30_000_000)[0]) > 0


def test_a_claim_of_billions_is_refused_at_once(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.laz")
    raw = bytearray(path.read_bytes())
    struct.pack_into("<Q", raw, 247, 2**40)
    path.write_bytes(raw)
    start = time.perf_counter()
    with pytest.raises(BadInput):
        read_file(path)
    assert time.perf_counter() - start < 1.0


def test_cancel_ends_the_process_soon(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.laz", 2_000_000)
    asked: list[float] = []

    def listen(fraction: float, text: str) -> None:
        if text == "Reading points" and not asked:
            asked.append(time.perf_counter())

    with pytest.raises(Cancelled):
        read_file(path, progress=LiveProgress(listen, lambda: bool(asked)))
    assert time.perf_counter() - asked[0] < 0.5


def test_progress_grows_to_its_end(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.las")
    seen: list[float] = []
    read_file(path, progress=LiveProgress(lambda fraction, _: seen.append(fraction)))
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGABRT, signal.SIGKILL])
def test_a_crash_of_the_reader_is_a_sentence(tmp_path: Path, number: signal.Signals) -> None:
    path = make_las(tmp_path / "a.las")

    def shoot(fraction: float, text: str) -> None:
        for reader in find_readers():
            reader.send_signal(number)

    with pytest.raises(BadInput, match=rf"crashed on a.las \(signal {number.value}\)"):
        read_file(path, progress=LiveProgress(shoot))


def test_what_takes_too_long_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make_las(tmp_path / "a.las")
    monkeypatch.setattr(reading, "_allow_seconds", lambda *_: 0.0)
    with pytest.raises(BadInput, match="could not be read within 0 s"):
        read_file(path)


@pytest.mark.skipif(os.name != "posix", reason="address space is bounded on POSIX")
@pytest.mark.parametrize("memory", [0, -(900 << 20)])
def test_a_reader_that_wants_more_than_it_may_ends_with_a_sentence(
    tmp_path: Path, memory: int
) -> None:
    """The check of the header is left out here, as a hostile file might get around it."""
    path = make_las(tmp_path / "a.las", 100)
    folder = tmp_path / "folder"
    folder.mkdir()
    raw = bytearray(path.read_bytes())
    struct.pack_into("<Q", raw, 247, 40_000_000)
    path.write_bytes(raw + bytes(0))
    os.truncate(path, 40_000_000 * 40)  # sparse: a file that is as large as it claims
    with pytest.raises(BadInput, match=r"memory|crashed"):
        run_reader(path, "las", DEFAULTS.as_json(), folder, Limits(memory, 30.0), QUIET)


def test_folders_of_dead_processes_are_swept(tmp_path: Path, no_leftovers: Path) -> None:
    process = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"],
                             capture_output=True, text=True, check=True)  # fmt: skip
    dead = no_leftovers / f"leafscope-read-{process.stdout.strip()}-x"
    alive = no_leftovers / f"leafscope-read-{os.getpid()}-x"
    for folder in (dead, alive):
        folder.mkdir()
    read_file(make_las(tmp_path / "a.las"))
    assert not dead.exists()
    alive.rmdir()


def test_a_file_that_changes_meanwhile_is_refused(tmp_path: Path) -> None:
    path = make_las(tmp_path / "a.las")

    def touch(fraction: float, text: str) -> None:
        os.utime(path, (1, 1))

    with pytest.raises(BadInput, match="changed while"):
        read_file(path, progress=LiveProgress(touch))


def test_wrong_options_are_wrong_use() -> None:
    for wrong in ({"every_nth": 0}, {"metres_per_unit": 0.0}, {"metres_per_unit": float("nan")}):
        with pytest.raises(WrongUse):
            ReadOptions(**wrong)


def test_options_survive_json() -> None:
    options = ReadOptions(every_nth=3, columns=("x", "y"), separator=";")
    assert ReadOptions.from_json(options.as_json()) == options


@pytest.mark.data
def test_real_files_are_read_or_refused(shared_data: Path) -> None:
    for name in ("edge_cases/las__bad_vlr_count.las", "e57_reference/测试点云.e57"):
        try:
            assert read_file(shared_data / name)
        except BadInput as error:
            assert Path(name).name in error.what  # noqa: PT017 (either end is right)
