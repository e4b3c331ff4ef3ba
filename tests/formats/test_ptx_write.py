"""Our PTX against a naive parser, and through reader, sidecar and columns back to the same scan."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from app.core.errors import BadInput, Cancelled
from app.core.progress import QUIET, LiveProgress
from app.formats import ptx
from app.formats.cloud import Cloud
from app.formats.options import ReadOptions
from app.formats.saving import save
from app.model.scan import Channel, Grid, Pose, Scan

KINDS = ("?", "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8")
TURN = Rotation.from_euler("zyx", [40.0, -20.0, 170.0], degrees=True).as_matrix()


def make_pose(matrix: np.ndarray, position: tuple[float, float, float]) -> Pose:
    x, y, z = (tuple(axis) for axis in matrix.tolist())
    return Pose(position, (x, y, z), "given")


POSES = [
    None,
    Pose((0.0, 0.0, 0.0), known_by="assumed"),
    Pose((1.5, -2.0, 1.7)),
    make_pose(TURN, (4.5e5, 5.1e6, 300.0)),
    make_pose(TURN * [-1, 1, 1], (1.0, 2.0, 3.0)),  # a mirror
    make_pose(np.ones((3, 3)), (1.0, 2.0, 3.0)),  # no axes at all
]


def make_cloud(pose: Pose | None = None, rows: int = 5, columns: int = 7, seed: int = 1) -> Cloud:
    """Points in some cells, in any order; beams without echo in some of the others."""
    rng = np.random.default_rng(seed)
    cells = rng.permutation(rows * columns)
    n = len(cells) // 2
    row, column = np.divmod(cells[:n].astype(np.int32), np.int32(columns))
    position = np.zeros(3) if pose is None else np.array(pose.position)
    attributes = {
        "reflectance_1063": rng.random(n).astype(np.float32),
        "intensity": rng.normal(size=n),
        "a/b: ω": rng.integers(0, 9, n),
    }
    for kind in KINDS:
        raw = rng.integers(0, 256, (n, np.dtype(kind).itemsize), dtype=np.uint8)
        attributes[kind] = raw[:, 0] > 9 if kind == "?" else raw.view(kind).ravel()
    channels = (
        Channel("NIR", "reflectance_1063", 1063.0, "reflectance", "panel", 0.01),
        Channel("intensity", "intensity", None, "dB"),
    )
    grid = Grid(rows, columns, row, column, np.sort(cells[n : n + n // 2]).astype(np.int64))
    xyz = rng.normal(size=(n, 3)) * 20 + position
    scan = Scan("s", xyz, attributes, channels, pose, grid)
    return Cloud(scan, {"ghost": rng.random(n) < 0.5}, {"ghost": "1"}, {"seed": seed})


def read(path: Path, every_nth: int = 1) -> Scan:
    (scan,) = ptx.read(path, ReadOptions(every_nth=every_nth), QUIET)
    return scan


def put(folder: Path, cloud: Cloud) -> Path:
    path = folder / "a.ptx"
    save(path, cloud, ptx.write, overwrite=True)
    return path


def file_order(cloud: Cloud) -> np.ndarray:
    """Points by column, then by row."""
    grid = cloud.scan.grid
    assert grid is not None
    return np.lexsort((grid.row, grid.column))


@given(
    pose=st.sampled_from(POSES),
    rows=st.integers(1, 9),
    columns=st.integers(1, 9),
    seed=st.integers(0, 99),
    every=st.integers(1, 3),
)
def test_round_trip(
    tmp_path_factory: pytest.TempPathFactory,
    pose: Pose | None,
    rows: int,
    columns: int,
    seed: int,
    every: int,
) -> None:
    cloud = make_cloud(pose, rows, columns, seed)
    back = read(put(tmp_path_factory.mktemp("ptx"), cloud), every)
    want = cloud.subset(file_order(cloud)[::every])
    np.testing.assert_allclose(back.xyz, want.scan.xyz, rtol=0, atol=2e-6)
    assert back.pose == pose
    assert back.channels == cloud.scan.channels
    grid, truth = back.grid, want.scan.grid
    assert grid is not None
    assert truth is not None
    assert (grid.rows, grid.columns) == (rows, columns)
    for part in ("row", "column", "no_return"):
        np.testing.assert_array_equal(getattr(grid, part), getattr(truth, part))
    expected = {k: v for k, v in want.columns.items() if k not in ("row", "column")}
    assert list(back.attributes) == list(expected)
    for name, values in expected.items():
        assert back.attributes[name].dtype == values.dtype, name
        assert back.attributes[name].tobytes() == values.tobytes(), name
    assert back.metadata["unit of ghost"] == "1"
    doubts = ("no rotation" in w for w in back.warnings)
    assert all(doubts) or "km from the points" in back.warnings[0]


@pytest.mark.parametrize("pose", POSES)
def test_any_other_reader_finds_the_same_points(tmp_path: Path, pose: Pose | None) -> None:
    cloud = make_cloud(pose)
    lines = put(tmp_path, cloud).read_text().splitlines()
    assert lines[:2] == ["7", "5"]
    head = [np.array(line.split(), float) for line in lines[2:10]]
    matrix = np.array(head[4:])
    np.testing.assert_array_equal(matrix[:3, :3], head[1:4])
    np.testing.assert_array_equal(matrix[3], [*head[0], 1.0])
    np.testing.assert_array_equal(matrix[:, 3], [0, 0, 0, 1])
    assert head[0].tolist() == list((0.0, 0.0, 0.0) if pose is None else pose.position)
    table = np.array([line.split() for line in lines[10:]], float)
    assert len(table) == 35
    scan = cloud.scan
    assert scan.grid is not None
    at = scan.grid.column * 5 + scan.grid.row
    world = np.column_stack((table[at, :3], np.ones(len(scan)))) @ matrix
    np.testing.assert_allclose(world[:, :3], scan.xyz, rtol=0, atol=2e-6)
    values = scan.attributes["reflectance_1063"]
    np.testing.assert_allclose(table[at, 3], values, rtol=1e-6)
    silent = np.setdiff1d(np.arange(35), at)
    assert {lines[10 + cell] for cell in silent} == {"0 0 0 0.5"}
    if pose is not None and pose.rotation == Pose((0, 0, 0)).rotation:
        np.testing.assert_allclose(table[at, :3] + pose.position, scan.xyz, rtol=0, atol=1e-6)


def test_many_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cloud = make_cloud(rows=40, columns=30)
    whole = put(tmp_path, cloud).read_bytes()
    monkeypatch.setattr("app.formats.ptx_write._CHUNK", 7)
    assert put(tmp_path, cloud).read_bytes() == whole


def test_without_what_lies_beside_the_points_and_the_intensity_stay(tmp_path: Path) -> None:
    cloud = make_cloud(POSES[3])
    path = put(tmp_path, cloud)
    for beside in (".leafscope.json", ".fields.npz"):
        path.with_name(path.name + beside).unlink()
    back = read(path)
    assert back.warnings == ()
    order = file_order(cloud)
    np.testing.assert_allclose(back.xyz, cloud.scan.xyz[order], rtol=0, atol=2e-6)
    values = cloud.scan.attributes["reflectance_1063"][order]
    np.testing.assert_allclose(back.attributes["intensity"], values, rtol=1e-6)
    assert back.pose is not None
    np.testing.assert_allclose(back.pose.rotation, TURN, rtol=0, atol=1e-15)
    assert back.pose.position == (4.5e5, 5.1e6, 300.0)


def test_without_its_columns_the_intensity_is_still_the_first_channel(tmp_path: Path) -> None:
    cloud = make_cloud()
    path = put(tmp_path, cloud)
    path.with_name("a.ptx.fields.npz").unlink()
    back = read(path)
    assert back.warnings == ("a.ptx.fields.npz is missing. Only what a.ptx itself holds was read.",)
    (channel,) = back.channels
    assert channel == replace(cloud.scan.channels[0], attribute="intensity")
    assert list(back.attributes) == ["intensity"]
    assert back.pose is None
    assert back.grid is not None
    assert cloud.scan.grid is not None
    np.testing.assert_array_equal(back.grid.no_return, cloud.scan.grid.no_return)


def test_columns_without_their_sidecar_are_not_believed(tmp_path: Path) -> None:
    path = put(tmp_path, make_cloud())
    path.with_name("a.ptx.leafscope.json").unlink()
    back = read(path)
    assert list(back.attributes) == ["intensity"]
    assert "not vouched for" in back.warnings[0]


def test_a_changed_file_takes_nothing_from_beside(tmp_path: Path) -> None:
    path = put(tmp_path, make_cloud())
    path.write_text(path.read_text().replace("0 0 0 0.5", "1 1 1 0.5", 1))
    back = read(path)
    assert "has changed since" in back.warnings[0]
    assert list(back.attributes) == ["intensity"]


def test_memory_is_claimed_for_the_columns_too(tmp_path: Path) -> None:
    path = put(tmp_path, make_cloud())
    whole = ptx.preflight(path).memory
    beside = path.with_name("a.ptx.fields.npz")
    size = beside.stat().st_size
    beside.unlink()
    assert whole - ptx.preflight(path).memory == size


def test_no_channel_and_no_columns(tmp_path: Path) -> None:
    grid = Grid(2, 2, np.array([1], np.int32), np.array([0], np.int32), np.array([0]))
    cloud = Cloud(Scan("s", np.array([[1.0, 2.0, 3.0]]), grid=grid))
    written = save(tmp_path / "a.ptx", cloud, ptx.write)
    assert [path.name for path in written] == ["a.ptx", "a.ptx.leafscope.json"]
    cells = (tmp_path / "a.ptx").read_text().splitlines()[10:]
    assert cells == ["0 0 0 0.5", "1.000000 2.000000 3.000000 0.5", "0 0 0 0.5", "0 0 0 0.5"]
    back = read(tmp_path / "a.ptx")
    assert (dict(back.attributes), back.channels, back.pose, back.warnings) == ({}, (), None, ())


def test_a_grid_of_nothing_but_silence(tmp_path: Path) -> None:
    cloud = make_cloud(POSES[3])
    back = read(put(tmp_path, cloud.subset(np.empty(0, np.int64))))
    assert len(back) == 0
    assert back.attributes["f4"].dtype == np.float32
    assert back.pose == POSES[3]


@pytest.mark.parametrize("value", [0.0, 1.0, -2047.0, 2047.0, 1.02])
def test_intensity_is_written_as_it_is(tmp_path: Path, value: float) -> None:
    cloud = make_cloud()
    cloud = replace(cloud, fields={"reflectance_1063": np.full(len(cloud.scan), value)})
    path = put(tmp_path, cloud)
    path.with_name("a.ptx.leafscope.json").unlink()
    np.testing.assert_array_equal(read(path).attributes["intensity"], value)


@pytest.mark.parametrize("value", [2047.5, -3000.0, np.nan, np.inf])
def test_other_intensities_are_refused(tmp_path: Path, value: float) -> None:
    cloud = make_cloud()
    values = np.zeros(len(cloud.scan))
    values[3] = value
    with pytest.raises(BadInput, match=r"NIR has values that PTX cannot hold.*E57 or LAZ"):
        put(tmp_path, replace(cloud, fields={"reflectance_1063": values}))
    assert os.listdir(tmp_path) == []


def test_what_is_no_range_image_is_refused(tmp_path: Path) -> None:
    cloud = make_cloud(Pose((1.0, 2.0, 3.0)))
    scan = cloud.scan
    assert scan.grid is not None
    twice = replace(scan.grid, row=scan.grid.row * 0, column=scan.grid.column * 0)
    bad, zero = scan.xyz.copy(), scan.xyz.copy()
    bad[2, 1] = np.nan
    zero[5] = (1.0, 2.0, 3.0 + 4e-7)
    cases = {
        "no rows and columns.*E57 or LAZ": replace(scan, grid=None),
        "16 points share a cell.*E57 or LAZ": replace(scan, grid=twice),
        "not finite": replace(scan, xyz=bad),
        "1 points lie at the scanner": replace(scan, xyz=zero),
    }
    for sentence, case in cases.items():
        with pytest.raises(BadInput, match=sentence):
            put(tmp_path, Cloud(case))
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("steps", [0, 1, 3, 6])
def test_cancel_leaves_nothing(tmp_path: Path, steps: int) -> None:
    seen: list[float] = []
    progress = LiveProgress(lambda f, _: seen.append(f), lambda: len(seen) > steps)
    with pytest.raises(Cancelled):
        save(tmp_path / "a.ptx", make_cloud(), ptx.write, progress=progress)
    assert os.listdir(tmp_path) == []
    assert seen == sorted(seen)


def test_words_leave_nothing(tmp_path: Path) -> None:
    cloud = make_cloud()
    with pytest.raises(BadInput, match="kind holds"):
        put(tmp_path, replace(cloud, fields={"kind": np.full(len(cloud.scan), "leaf")}))
    assert os.listdir(tmp_path) == []
