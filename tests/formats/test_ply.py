"""PLY: round trips, a naive writer, damage, real files."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import ply
from app.formats.cloud import Cloud
from app.formats.options import ReadOptions
from app.formats.saving import save
from app.model.scan import Channel, Grid, Pose, Scan

PLAIN = ReadOptions()
CODES = {"char": "b", "uchar": "B", "int16": "h", "uint": "I", "float32": "f", "double": "d"}


def make_cloud(n: int = 7) -> Cloud:
    random = np.random.default_rng(1)
    attributes = {
        "intensity_1545": random.normal(size=n),
        "Reflectance (dB)": random.normal(size=n).astype(np.float32),
        "count": np.arange(n, dtype=np.int16),
        "time": np.arange(n, dtype=np.int64) * 10**12,
        "X": random.normal(size=n),
    }
    rows, columns = np.arange(n, dtype=np.int32) % 3, np.arange(n, dtype=np.int32) % 4
    scan = Scan(
        "leaf",
        random.normal(size=(n, 3)) + 5e5,
        attributes,
        channels=(Channel("SWIR", "intensity_1545", 1545.0, "linear", "panel", 0.03),),
        pose=Pose((1.0, 2.0, 1 / 3), ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)), "given"),
        grid=Grid(3, 4, rows, columns, np.array([1, 2, 3, 7, 11])),
    )
    fields = {"ghost": np.arange(n) % 2 == 0, "incidence": np.full(n, np.nan)}
    return Cloud(scan, fields, {"incidence": "deg"}, {"leafscope": "0.1", "seed": np.int64(4)})


def test_round_trip_is_bit_identical(tmp_path: Path) -> None:
    cloud = make_cloud()
    target = tmp_path / "a.ply"
    save(target, cloud, ply.write)
    (scan,) = ply.read(target, PLAIN, QUIET)
    assert scan.xyz.tobytes() == cloud.scan.xyz.tobytes()
    expected = {**cloud.scan.attributes, **cloud.fields}
    assert set(scan.attributes) == set(expected)
    for name, values in expected.items():
        assert scan.attributes[name].dtype == values.dtype
        assert scan.attributes[name].tobytes() == values.tobytes()
    assert scan.pose == cloud.scan.pose
    assert scan.channels == cloud.scan.channels
    assert scan.grid is not None
    assert cloud.scan.grid is not None
    for key in ("rows", "columns", "row", "column", "no_return"):
        np.testing.assert_array_equal(getattr(scan.grid, key), getattr(cloud.scan.grid, key))
    assert scan.warnings == ()


def test_pose_and_names_survive_without_the_sidecar(tmp_path: Path) -> None:
    cloud = make_cloud()
    save(tmp_path / "a.ply", cloud, ply.write, sidecar=False)
    (scan,) = ply.read(tmp_path / "a.ply", PLAIN, QUIET)
    assert scan.pose == cloud.scan.pose
    assert {"Reflectance (dB)", "X"} <= set(scan.attributes)
    assert "leafscope seed: 4" in scan.metadata["comments"]


def test_integers_that_ply_cannot_hold_are_refused(tmp_path: Path) -> None:
    scan = Scan("s", np.zeros((1, 3)), {"id": np.array([2**60 + 1])})
    with pytest.raises(BadInput, match="no type for the values of id"):
        save(tmp_path / "a.ply", Cloud(scan), ply.write)
    assert list(tmp_path.iterdir()) == []


def test_an_empty_cloud_round_trips(tmp_path: Path) -> None:
    save(tmp_path / "a.ply", make_cloud(0), ply.write)
    (scan,) = ply.read(tmp_path / "a.ply", PLAIN, QUIET)
    assert len(scan) == 0


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[str], list[list[float]]]:
    types = draw(st.lists(st.sampled_from(sorted(CODES)), min_size=3, max_size=6))
    number = st.integers(0, 100)
    row = st.lists(number, min_size=len(types), max_size=len(types))
    return types, draw(st.lists(row, max_size=5))


@settings(max_examples=150)
@given(
    table=tables(),
    encoding=st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]),
    faces=st.sampled_from(["none", "before", "after"]),
    every=st.integers(1, 3),
    crlf=st.booleans(),
)
def test_against_a_naive_writer(
    tmp_path_factory: pytest.TempPathFactory,
    table: tuple[list[str], list[list[float]]],
    encoding: str,
    faces: str,
    every: int,
    crlf: bool,
) -> None:
    types, rows = table
    names = ["x", "y", "z", "a", "b", "c"][: len(types)]
    path = tmp_path_factory.mktemp("ply") / "a.ply"
    path.write_bytes(naive_ply(names, types, rows, encoding, faces, b"\r\n" if crlf else b"\n"))
    (scan,) = ply.read(path, ReadOptions(every_nth=every), QUIET)
    values = np.array(rows, dtype=float).reshape(-1, len(types))[::every]
    np.testing.assert_array_equal(scan.xyz, values[:, :3])
    for i, name in enumerate(names[3:], 3):
        np.testing.assert_array_equal(scan.attributes[name], values[:, i])
        assert scan.attributes[name].dtype == np.dtype(CODES[types[i]])
    assert ply.preflight(path).points == len(rows)


def naive_ply(
    names: list[str],
    types: list[str],
    rows: list[list[float]],
    encoding: str,
    faces: str,
    end: bytes = b"\n",
) -> bytes:
    vertex = [f"element vertex {len(rows)}"]
    vertex += [f"property {t} {n}" for t, n in zip(types, names, strict=True)]
    face = ["element face 2", "property list uchar int vertex_indices", "property float q"]
    order = ">" if encoding.endswith("big_endian") else "<"
    blocks = {"vertex": vertex, "face": face}
    if encoding == "ascii":
        data = {
            "vertex": "".join(" ".join(map(str, row)) + "\n" for row in rows).encode(),
            "face": b"3 0 1 2 0.5\n4 0 1 2 3 0.5\n",
        }
    else:
        code = order + "".join(CODES[t] for t in types)
        data = {
            "vertex": b"".join(struct.pack(code, *row) for row in rows),
            "face": struct.pack(order + "B3if", 3, 0, 1, 2, 0.5)
            + struct.pack(order + "B4if", 4, 0, 1, 2, 3, 0.5),
        }
    sequence = {"none": ["vertex"], "before": ["face", "vertex"], "after": ["vertex", "face"]}
    lines = ["ply", f"format {encoding} 1.0", "comment any"]
    for name in sequence[faces]:
        lines += blocks[name]
    head = end.join(line.encode() for line in [*lines, "end_header", ""])
    return head + b"".join(data[name] for name in sequence[faces])


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("count", ["0", "1", "3", "2147483648", "9" * 40, "-1", "x", "1.5", "²"])
@pytest.mark.parametrize("element", ["vertex", "face"])
def test_changed_counts(tmp_path: Path, encoding: str, count: str, element: str) -> None:
    good = naive_ply(["x", "y", "z"], ["double"] * 3, [[1, 2, 3], [4, 5, 6]], encoding, "before")
    path = tmp_path / "a.ply"
    path.write_bytes(
        good.replace(f"element {element} 2".encode(), f"element {element} {count}".encode())
    )
    for options in (PLAIN, ReadOptions(recover=True)):
        try:
            ply.preflight(path, options)
            (scan,) = ply.read(path, options, QUIET)
        except BadInput:
            continue
        assert len(scan) <= 5


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_cut_anywhere(tmp_path: Path, encoding: str) -> None:
    good = naive_ply(["x", "y", "z"], ["double"] * 3, [[1, 2, 3], [4, 5, 6]], encoding, "none")
    path = tmp_path / "a.ply"
    for size in range(len(good) - 2):
        path.write_bytes(good[:size])
        with pytest.raises(BadInput):
            ply.read(path, PLAIN, QUIET)
    (scan,) = ply.read(path, ReadOptions(recover=True), QUIET)
    np.testing.assert_array_equal(scan.xyz, [[1, 2, 3]])
    assert "1 of 2 points missing" in scan.warnings[0]


@settings(max_examples=200)
@given(data=st.data())
def test_noise(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    encoding = data.draw(st.sampled_from(["ascii", "binary_little_endian"]))
    good = bytearray(
        naive_ply(["x", "y", "z"], ["double"] * 3, [[1, 2, 3], [4, 5, 6]], encoding, "before")
    )
    for _ in range(data.draw(st.integers(1, 4))):
        good[data.draw(st.integers(0, len(good) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("noise") / "a.ply"
    path.write_bytes(good)
    for options in (PLAIN, ReadOptions(recover=True)):
        try:
            ply.read(path, options, QUIET)
        except BadInput:
            continue


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("property double z", "property list uchar int z"), "the property z .* is a list"),
        (("property double z", "property double q"), "have no z"),
        (("property double z", "property quad z"), "'property quad z' means nothing"),
        (("property double z", "property double z\nproperty int X"), "same name"),
        (("element vertex", "element points"), "no element vertex; its elements: points"),
        (("end_header", "end"), "no end_header"),
        (("format ascii 1.0", "comment none"), "ascii or binary"),
    ],
)
def test_sentences(tmp_path: Path, change: tuple[str, str], sentence: str) -> None:
    text = naive_ply(["x", "y", "z"], ["double"] * 3, [[1, 2, 3]], "ascii", "none").decode()
    path = tmp_path / "a.ply"
    path.write_text(text.replace(*change))
    with pytest.raises(BadInput, match=sentence):
        ply.preflight(path)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "points"),
    [
        ("edge_cases/ply__issue_2421", 1), ("edge_cases/ply__mesh", 4),
        ("edge_cases/ply__simple_binary", 3), ("edge_cases/ply__simple_text", 3),
        ("edge_cases/ply__text_extradim", 1), ("edge_cases/ply__no_vertex", None),
        ("edge_cases/ply__sized_dims", None), ("edge_cases/ply__unsized_dims", None),
        ("ply_pcd_misc/diamond", 6), ("ply_pcd_misc/diamond_with_bool", 6),
        ("ply_pcd_misc/sphere", 2929), ("ply_pcd_misc/voxelgrid", 6),
    ],
)  # fmt: skip
def test_real_files(shared_data: Path, name: str, points: int | None) -> None:
    path = shared_data / f"{name}.ply"
    if points is None:
        with pytest.raises(BadInput):
            ply.read(path, PLAIN, QUIET)
    else:
        (scan,) = ply.read(path, PLAIN, QUIET)
        assert len(scan) == ply.preflight(path).points == points
