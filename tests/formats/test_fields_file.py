"""Columns beside a file: read only when they are what the sidecar vouches for."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput, Cancelled
from app.core.progress import QUIET, LiveProgress
from app.formats.fields_file import fields_path, find_fields, write_fields
from app.formats.sidecar import FieldsFile

COLUMNS = {
    "leaf": np.arange(5, dtype=np.int32),
    "a/b": np.linspace(0, 1, 5),
    "a:b": np.ones(5, np.float32),
    "": np.array([True, False, True, True, False]),
    "old": np.arange(5, dtype=">f8"),
}


def put(tmp_path: Path) -> tuple[Path, FieldsFile]:
    data = tmp_path / "a.ptx"
    return data, write_fields(fields_path(data), COLUMNS, QUIET)


def put_raw(tmp_path: Path, content: bytes) -> tuple[Path, FieldsFile]:
    """Any content, with a sidecar that vouches for it."""
    data = tmp_path / "a.ptx"
    fields_path(data).write_bytes(content)
    return data, FieldsFile(len(content), hashlib.sha256(content).hexdigest())


def test_round_trip(tmp_path: Path) -> None:
    found, warnings = find_fields(*put(tmp_path), 5, 1, QUIET)
    assert warnings == ()
    assert found is not None
    assert list(found) == list(COLUMNS)
    for name, values in COLUMNS.items():
        assert found[name].dtype == values.dtype.newbyteorder("<")
        np.testing.assert_array_equal(found[name], values)
    with np.load(tmp_path / "a.ptx.fields.npz", allow_pickle=False) as plain:
        assert plain.files == ["leaf", "a_b", "a_b_2", "field", "old"]


def test_every_nth(tmp_path: Path) -> None:
    found, _ = find_fields(*put(tmp_path), 3, 2, QUIET)
    assert found is not None
    assert found["leaf"].tolist() == [0, 2, 4]


def test_none_where_none_belong(tmp_path: Path) -> None:
    assert find_fields(tmp_path / "a.ptx", None, 5, 1, QUIET) == ({}, ())


def refused(data: Path, mark: FieldsFile, points: int = 5, every_nth: int = 1) -> str:
    found, (warning,) = find_fields(data, mark, points, every_nth, QUIET)
    assert found is None
    assert warning.endswith("Only what a.ptx itself holds was read.")
    return warning


@pytest.mark.parametrize(("points", "every_nth"), [(4, 1), (6, 1), (5, 2), (0, 1), (1, 4)])
def test_another_number_of_points(tmp_path: Path, points: int, every_nth: int) -> None:
    assert "rows for" in refused(*put(tmp_path), points, every_nth)


@pytest.mark.parametrize("change", [{"size": 1}, {"sha256": "ab" * 32}])
def test_not_what_the_sidecar_knows(tmp_path: Path, change: dict[str, object]) -> None:
    data, mark = put(tmp_path)
    assert "has changed" in refused(data, replace(mark, **change))


def make_npy(header: str, data: bytes = bytes(40), version: bytes = b"\x02\x00") -> bytes:
    text = header.encode() + b"\n"
    length = len(text).to_bytes(4 if version == b"\x02\x00" else 2, "little")
    return b"\x93NUMPY" + version + length + text + data


def make_zip(content: bytes, compression: int = zipfile.ZIP_STORED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        archive.writestr("leaf.npy", content)
    return buffer.getvalue()


GOOD = "{'descr': '<f8', 'fortran_order': False, 'shape': (5,)}"
HOSTILE: dict[str, Callable[[], bytes]] = {
    "no archive": lambda: b"PK\x03\x04 and so on",
    "empty": lambda: b"",
    "pickle": lambda: make_zip(make_npy(GOOD.replace("<f8", "|O"))),
    "words": lambda: make_zip(make_npy(GOOD.replace("<f8", "<U2"))),
    "structure": lambda: make_zip(make_npy(GOOD.replace("'<f8'", "[('a', '<f8')]"))),
    "header bomb": lambda: make_zip(make_npy(GOOD.replace("5", "10" + 12 * "0"))),
    "endless count": lambda: make_zip(make_npy(GOOD.replace("5", 40 * "9"))),
    "negative": lambda: make_zip(make_npy(GOOD.replace("5", "-5"))),
    "two dimensions": lambda: make_zip(make_npy(GOOD.replace("5,", "5, 1"))),
    "no dimension": lambda: make_zip(make_npy(GOOD.replace("5,", ""))),
    "short": lambda: make_zip(make_npy(GOOD, bytes(39))),
    "long": lambda: make_zip(make_npy(GOOD, bytes(41))),
    "old version": lambda: make_zip(make_npy(GOOD, version=b"\x01\x00")),
    "code": lambda: make_zip(make_npy("__import__('os').abort()")),
    "long header": lambda: make_zip(make_npy("(" * 50_000)),
    "no array": lambda: make_zip(b"nothing"),
    "deflated": lambda: make_zip(make_npy(GOOD), zipfile.ZIP_DEFLATED),
    "checksum": lambda: make_zip(make_npy(GOOD, b"A" * 40)).replace(b"A" * 40, b"B" * 40),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_give_a_warning(tmp_path: Path, name: str) -> None:
    refused(*put_raw(tmp_path, HOSTILE[name]()))


def test_the_good_one_of_the_hostile_is_read(tmp_path: Path) -> None:
    found, warnings = find_fields(*put_raw(tmp_path, make_zip(make_npy(GOOD))), 5, 1, QUIET)
    assert warnings == ()
    assert found is not None
    np.testing.assert_array_equal(found["leaf"], np.zeros(5))


def test_entries_over_the_same_bytes(tmp_path: Path) -> None:
    raw = make_zip(make_npy(GOOD, bytes(1 << 12)))
    start = raw.index(b"PK\x01\x02")
    end = raw.index(b"PK\x05\x06")
    directory = raw[start:end] * 3
    tail = bytearray(raw[end:])
    tail[8:10] = tail[10:12] = (3).to_bytes(2, "little")
    tail[12:16] = len(directory).to_bytes(4, "little")
    assert "claims more" in refused(*put_raw(tmp_path, raw[:start] + directory + bytes(tail)))


@given(place=st.integers(0, 2000), byte=st.integers(0, 255))
def test_any_changed_byte_gives_columns_or_a_warning(
    tmp_path_factory: pytest.TempPathFactory, place: int, byte: int
) -> None:
    tmp_path = tmp_path_factory.mktemp("fields")
    data, _ = put(tmp_path)
    raw = bytearray(fields_path(data).read_bytes())
    raw[place % len(raw)] = byte
    found, warnings = find_fields(*put_raw(tmp_path, bytes(raw)), 5, 1, QUIET)
    assert (found is None) == bool(warnings)
    assert all(len(values) == 5 for values in (found or {}).values())


def test_cancel(tmp_path: Path) -> None:
    data, mark = put(tmp_path)
    with pytest.raises(Cancelled):
        find_fields(data, mark, 5, 1, LiveProgress(lambda *_: None, lambda: True))


def test_what_is_no_number_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="kind holds"):
        write_fields(tmp_path / "a", {"kind": np.array(["leaf"])}, QUIET)
