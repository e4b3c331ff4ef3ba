"""PCD: a naive writer in all three encodings, damage, real files."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import pcd
from app.formats.lzf import decompress_lzf
from app.formats.options import ReadOptions

PLAIN = ReadOptions()
ROWS = [(1.0, 2.0, 3.0, 7, 1.5, 2.5), (4.0, 5.0, 6.0, 8, 3.5, 4.5)]


def make_pcd(encoding: str, view: str = "0 0 0 1 0 0 0", size: str = "WIDTH 2\nHEIGHT 1") -> bytes:
    head = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z label pair\nSIZE 8 8 8 4 4\nTYPE F F F U F\n"
        f"COUNT 1 1 1 1 2\n{size}\nVIEWPOINT {view}\nPOINTS 2\nDATA {encoding}\n"
    ).encode()
    if encoding == "ascii":
        return head + "".join(" ".join(map(str, row)) + "\n" for row in ROWS).encode()
    if encoding == "binary":
        return head + b"".join(struct.pack("<3dI2f", *row) for row in ROWS)
    fields = b"".join(struct.pack("<2d", *(row[i] for row in ROWS)) for i in range(3))
    fields += struct.pack("<2I", *(row[3] for row in ROWS))
    fields += struct.pack("<4f", *(value for row in ROWS for value in row[4:]))
    packed = compress_literally(fields)
    return head + struct.pack("<2I", len(packed), len(fields)) + packed


def compress_literally(data: bytes) -> bytes:
    parts = [data[i : i + 32] for i in range(0, len(data), 32)]
    return b"".join(bytes([len(part) - 1]) + part for part in parts)


def put(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "a.pcd"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_all_encodings(tmp_path: Path, encoding: str) -> None:
    path = put(tmp_path, make_pcd(encoding))
    (scan,) = pcd.read(path, PLAIN, QUIET)
    np.testing.assert_array_equal(scan.xyz, [row[:3] for row in ROWS])
    assert scan.attributes["label"].dtype == np.uint32
    assert scan.attributes["label"].tolist() == [7, 8]
    assert scan.attributes["pair_0"].tolist() == [1.5, 3.5]
    assert scan.attributes["pair_1"].dtype == np.float32
    assert scan.pose is None
    assert scan.grid is None
    assert pcd.preflight(path).points == 2
    (half,) = pcd.read(path, ReadOptions(every_nth=2), QUIET)
    assert half.attributes["label"].tolist() == [7]


def test_viewpoint_becomes_the_pose(tmp_path: Path) -> None:
    quarter = np.sqrt(0.5)
    path = put(tmp_path, make_pcd("ascii", view=f"1 2 3 {quarter} 0 0 {quarter}"))
    (scan,) = pcd.read(path, PLAIN, QUIET)
    assert scan.pose is not None
    assert scan.pose.position == (1.0, 2.0, 3.0)
    np.testing.assert_allclose(np.array(scan.pose.rotation) @ [1, 0, 0], [0, 1, 0], atol=1e-15)


def test_organised_cloud_has_a_grid(tmp_path: Path) -> None:
    (scan,) = pcd.read(put(tmp_path, make_pcd("binary", size="WIDTH 1\nHEIGHT 2")), PLAIN, QUIET)
    assert scan.grid is not None
    assert (scan.grid.rows, scan.grid.columns) == (2, 1)
    assert scan.grid.row.tolist() == [0, 1]


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_cut_anywhere(tmp_path: Path, encoding: str) -> None:
    good = make_pcd(encoding)
    for size in range(len(good) - 3):
        path = put(tmp_path, good[:size])
        with pytest.raises(BadInput):
            pcd.read(path, PLAIN, QUIET)
    if encoding != "binary_compressed":
        (scan,) = pcd.read(path, ReadOptions(recover=True), QUIET)
        assert len(scan) in (1, 2)
        assert len(scan) == 2 or "1 of 2 points missing" in scan.warnings[0]


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
@given(data=st.data())
def test_noise(
    tmp_path_factory: pytest.TempPathFactory, encoding: str, data: st.DataObject
) -> None:
    good = bytearray(make_pcd(encoding))
    for _ in range(data.draw(st.integers(1, 4))):
        good[data.draw(st.integers(0, len(good) - 1))] = data.draw(st.integers(0, 255))
    path = put(tmp_path_factory.mktemp("noise"), bytes(good))
    for options in (PLAIN, ReadOptions(recover=True)):
        try:
            pcd.read(path, options, QUIET)
        except BadInput:
            continue


@pytest.mark.parametrize("key", ["WIDTH 2", "HEIGHT 1", "POINTS 2", "COUNT 1 1 1 1 2", "SIZE 8"])
@pytest.mark.parametrize("value", ["0", "1", "2147483648", "9" * 40, "-1", "x", ""])
def test_changed_counts(tmp_path: Path, key: str, value: str) -> None:
    changed = make_pcd("binary").replace(key.encode(), f"{key.split()[0]} {value}".encode())
    path = put(tmp_path, changed)
    for options in (PLAIN, ReadOptions(recover=True)):
        try:
            (scan,) = pcd.read(path, options, QUIET)
        except BadInput:
            continue
        assert len(scan) <= 2


def compress_greedily(data: bytes) -> bytes:
    """A plain LZF encoder: the longest match in the last 8192 bytes, else a literal."""
    out, i = bytearray(), 0
    while i < len(data):
        best, distance = 0, 0
        for start in range(max(0, i - 8192), i):
            length = 0
            while (
                length < 264 and i + length < len(data) and data[start + length] == data[i + length]
            ):
                length += 1
            if length > best:
                best, distance = length, i - start - 1
        if best >= 3:
            code = best - 2
            out.append((min(code, 7) << 5) | (distance >> 8))
            if code >= 7:
                out.append(code - 7)
            out.append(distance & 255)
            i += best
        else:
            out += bytes([0, data[i]])
            i += 1
    return bytes(out)


@given(st.lists(st.sampled_from([b"a", b"b", b"ab", b"abcabc", b"z" * 40]), max_size=25))
def test_lzf_round_trip(parts: list[bytes]) -> None:
    data = b"".join(parts)
    assert decompress_lzf(compress_greedily(data), len(data), QUIET) == data


@given(st.binary(max_size=60), st.integers(0, 300))
def test_lzf_noise(data: bytes, size: int) -> None:
    try:
        assert len(decompress_lzf(data, size, QUIET)) == size
    except BadInput:
        return


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "points"),
    [("autzen-utm", 1065), ("utm17_comma", 10), ("utm17_space", 10), ("utm17_tab", 10)],
)
def test_real_files(shared_data: Path, name: str, points: int) -> None:
    (scan,) = pcd.read(shared_data / "edge_cases" / f"pcd__{name}.pcd", PLAIN, QUIET)
    assert len(scan) == points
    if name != "autzen-utm":
        assert scan.xyz[0].tolist() == [289814.15, 4320978.61, 170.76]


@pytest.mark.data
def test_missing_header_is_said(shared_data: Path) -> None:
    with pytest.raises(BadInput, match="no PCD header"):
        pcd.preflight(shared_data / "edge_cases" / "pcd__missingheader.pcd")
