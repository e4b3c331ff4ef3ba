"""PTX against a naive parser, against damage, and on real files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput, Cancelled
from app.core.progress import QUIET, LiveProgress
from app.formats import ptx
from app.formats.options import ReadOptions

TURNED = ["2 3 4", "0 1 0", "-1 0 0", "0 0 1", "0 1 0 0", "-1 0 0 0", "0 0 1 0", "2 3 4 1"]
NUMBERS = st.sampled_from(["0", "1.5", "-2", "0.25", "1e3", "nan", "inf"])
PLAIN = ReadOptions()


def write_scan(columns: int, rows: int, cells: list[str]) -> str:
    return "\n".join([str(columns), str(rows), *TURNED, *cells, ""])


def put(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "scan.ptx"
    path.write_text(text)
    return path


@dataclass
class Cells:
    columns: int
    rows: int
    lines: list[str]


@st.composite
def grids(draw: st.DrawFn) -> Cells:
    columns, rows = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    width = draw(st.sampled_from([4, 7]))
    cell = st.one_of(
        st.just("0 0 0 0.5" + " 1 2 3" * (width == 7)),
        st.lists(NUMBERS, min_size=width, max_size=width).map(" ".join),
    )
    count = columns * rows
    return Cells(columns, rows, draw(st.lists(cell, min_size=count, max_size=count)))


@given(scans=st.lists(grids(), min_size=1, max_size=3), every=st.integers(1, 3))
def test_against_a_naive_parser(
    tmp_path_factory: pytest.TempPathFactory, scans: list[Cells], every: int
) -> None:
    text = "".join(write_scan(s.columns, s.rows, s.lines) for s in scans)
    path = put(tmp_path_factory.mktemp("ptx"), text)
    got = ptx.read(path, ReadOptions(every_nth=every), QUIET)
    header = ptx.preflight(path)
    assert header.scans == len(got) == len(scans)
    assert header.points == sum(len(s.lines) for s in scans)
    for scan, expected in zip(got, scans, strict=True):
        points, empty = [], []
        for index, line in enumerate(expected.lines):
            x, y, z, *rest = map(float, line.split())
            column, row = divmod(index, expected.rows)
            if x == y == z == 0.0:
                empty.append(row * expected.columns + column)
            else:
                # x' = 2 - y, y' = 3 + x, z' = 4 + z: a quarter turn about z
                points.append((row, column, 2.0 - y, 3.0 + x, 4.0 + z, *rest))
        points = points[::every]
        assert scan.grid is not None
        assert (scan.grid.rows, scan.grid.columns) == (expected.rows, expected.columns)
        assert scan.grid.no_return.tolist() == empty
        assert scan.grid.row.tolist() == [p[0] for p in points]
        assert scan.grid.column.tolist() == [p[1] for p in points]
        finite = [p for p in points if np.isfinite(p[2:5]).all()]
        want = np.array([p[2:5] for p in finite]).reshape(-1, 3)
        np.testing.assert_allclose(scan.xyz[scan.valid], want)
        for name, i in (("intensity", 5), ("red", 6), ("green", 7), ("blue", 8)):
            if name in scan.attributes:
                np.testing.assert_array_equal(scan.attributes[name], [p[i] for p in points])


def test_pose_is_the_matrix(tmp_path: Path) -> None:
    (scan,) = ptx.read(put(tmp_path, write_scan(1, 1, ["1 0 0 0.5"])), PLAIN, QUIET)
    assert scan.pose is not None
    assert scan.pose.position == (2.0, 3.0, 4.0)
    assert scan.pose.known_by == "file"
    rotation = np.array(scan.pose.rotation)
    np.testing.assert_allclose(rotation @ [1, 0, 0] + scan.pose.position, scan.xyz[0])


def test_default_position_far_from_the_points_is_unknown(tmp_path: Path) -> None:
    unit = ["0 0 0", "1 0 0", "0 1 0", "0 0 1", "1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"]
    text = "\n".join(["1", "1", *unit, "637012.24 849028.31 431.66 0.03", ""])
    (scan,) = ptx.read(put(tmp_path, text), PLAIN, QUIET)
    assert scan.pose is None
    assert "1061 km" in scan.warnings[0]


def test_scaling_matrix_is_said(tmp_path: Path) -> None:
    text = write_scan(1, 1, ["1 0 0 0.5"]).replace("0 0 1 0\n", "0 0 2 0\n")
    (scan,) = ptx.read(put(tmp_path, text), PLAIN, QUIET)
    assert any("no rotation" in warning for warning in scan.warnings)


GOOD = write_scan(2, 2, ["1 2 3 0.5", "2 2 3 0.6", "0 0 0 0.5", "3 2 3 0.7"])


@pytest.mark.parametrize("line", range(10))
@pytest.mark.parametrize(
    "value", ["0", "1", "3", "2147483648", "9" * 30, "9" * 5000, "-1", "x", "", "1.5", "nan", "²"]
)
def test_changed_header_line(tmp_path: Path, line: int, value: str) -> None:
    lines = GOOD.split("\n")
    lines[line] = value
    path = put(tmp_path, "\n".join(lines))
    for options in (PLAIN, ReadOptions(recover=True)):
        for action in (
            lambda o: ptx.preflight(path, o).points,
            lambda o: sum(map(len, ptx.read(path, o, QUIET))),
        ):
            try:
                points = action(options)
            except BadInput:
                continue
            assert points <= 4


@pytest.mark.parametrize("size", range(1, len(GOOD) - 1))
def test_cut_file(tmp_path: Path, size: int) -> None:
    path = put(tmp_path, GOOD[:size])
    complete = GOOD[:size].count("\n") - 10
    try:
        (scan,) = ptx.read(path, ReadOptions(recover=True), QUIET)
    except BadInput:
        assert complete <= 0
        return
    assert any("ends early" in warning for warning in scan.warnings) or size >= len(GOOD) - 4
    assert scan.grid is not None
    assert len(scan) + len(scan.grid.no_return) >= complete
    assert scan.grid.rows * scan.grid.columns <= 4
    if size < len(GOOD) - 10:
        with pytest.raises(BadInput, match="--recover"):
            ptx.preflight(path)


def test_damaged_cell_is_named_by_its_line(tmp_path: Path) -> None:
    path = put(tmp_path, GOOD.replace("2 2 3 0.6", "2 2 oops 0.6"))
    with pytest.raises(BadInput, match=r"line 12: '2 2 oops 0.6'"):
        ptx.read(path, PLAIN, QUIET)


@given(st.binary(max_size=200))
def test_noise(tmp_path_factory: pytest.TempPathFactory, noise: bytes) -> None:
    path = tmp_path_factory.mktemp("noise") / "scan.ptx"
    path.write_bytes(GOOD.encode()[: len(noise)] + noise)
    for options in (PLAIN, ReadOptions(recover=True)):
        try:
            ptx.read(path, options, QUIET)
        except BadInput:
            continue


@pytest.mark.parametrize("content", ["", "\n \n"])
def test_empty_file_is_said(tmp_path: Path, content: str) -> None:
    path = put(tmp_path, content)
    with pytest.raises(BadInput, match="holds no scan"):
        ptx.preflight(path)
    with pytest.raises(BadInput, match="holds no scan"):
        ptx.read(path, PLAIN, QUIET)


def test_content_is_recognised_without_the_suffix() -> None:
    assert ptx.matches(GOOD.encode(), Path("a.dat"))
    assert not ptx.matches(b"10\n1 2 3 4\n", Path("a.pts"))


def test_cancel(tmp_path: Path) -> None:
    cancelled = LiveProgress(lambda *_: None, lambda: True)
    with pytest.raises(Cancelled):
        ptx.read(put(tmp_path, GOOD), PLAIN, cancelled)


@pytest.mark.data
def test_truth_scene_keeps_the_order_of_its_truth(shared_data: Path) -> None:
    (scan,) = ptx.read(shared_data / "truth_scenes" / "pulsed.ptx", PLAIN, QUIET)
    with np.load(shared_data / "truth_scenes" / "pulsed_truth.npz") as truth:
        assert scan.grid is not None
        np.testing.assert_array_equal(scan.grid.row, truth["row"])
        np.testing.assert_array_equal(scan.grid.column, truth["col"])


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "sizes"),
    [("1.2-with-color", [1065]), ("no-color", [15]), ("multiple-and-transform", [4, 4])],
)
def test_edge_cases(shared_data: Path, name: str, sizes: list[int]) -> None:
    scans = ptx.read(shared_data / "edge_cases" / f"ptx__{name}.ptx", PLAIN, QUIET)
    assert [len(scan) for scan in scans] == sizes
    for scan in scans:  # all three hold the same points, each in its own frame
        np.testing.assert_allclose(scan.xyz[0], [637012.24, 849028.31, 431.66])
