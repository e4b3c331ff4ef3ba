"""Text: the layout that is guessed, corrected and refused; rows against a naive parser."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import text
from app.formats.options import ReadOptions
from app.formats.text_layout import find_layout

PLAIN = ReadOptions()


def put(tmp_path: Path, content: str, name: str = "a.txt") -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode())
    return path


@pytest.mark.parametrize(
    ("content", "separator", "header_lines", "columns"),
    [
        ("1 2 3\n4 5 6\n", None, 0, "x y z"),
        ("X,Y,Z,Intensity\r\n1,2,3,4\r\n", ",", 1, "X Y Z Intensity"),
        ('"X","Y","Z"\n1 2 3\n', None, 1, "X Y Z"),
        ("//X,Y,Z,R\n2\n1,2,3,4\n5,6,7,8\n", ",", 2, "X Y Z R"),
        ("# made by hand\n# x y z\n1 2 3\n", None, 2, "x y z"),
        ("# made by hand, mostly\n1\t2\t3\n", "\t", 1, "x y z"),
        ("x;y;z;Reflectance (dB)\n1;2;3;-4\n", ";", 1, "x y z Reflectance (dB)"),
        ("x,y,z,500,600,700,800\n1,2,3,4,5,6,7\n", ",", 1, "x y z 500 600 700 800"),
        ("2\n1 2 3 4\n1 2 3 4\n", None, 1, "x y z intensity"),
        ("1 2 3 4\n1 2 3 4\n", None, 0, "x y z column_4"),
        ("1,2,3,\n4,5,6,\n", ",", 0, "x y z"),
        ("X [m],Y [m],Z [m]\n1,2,3\n", ",", 1, "X [m] Y [m] Z [m]"),
        ("\ufeffx,y,z\n1,2,3\n", ",", 1, "x y z"),
        ("x,y,z,'=a\n1,2,3,4\n", ",", 1, "x y z =a"),
        ("x,y,z,species\n1,2,3,oak\n1,2,3,ash\n", ",", 1, "x y z species"),
    ],
)
def test_guess(
    tmp_path: Path, content: str, separator: str | None, header_lines: int, columns: str
) -> None:
    layout = find_layout(put(tmp_path, content), PLAIN)
    assert layout.separator == separator
    assert layout.header_lines == header_lines
    assert " ".join(layout.columns) == columns


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("Just a letter to a friend.\n", "no line of three numbers.*'Just a letter"),
        ("", "begins with 'nothing'"),
        ("x,y\n1,2\n", "no line of three numbers"),
        ("x,y,i\n1,2,3\n", "names no z among its columns: x, y, i.*--columns"),
        ("X,Y,X\n1,2,3\n", "no z"),
        ("x,y,z,i,i\n1,2,3,4,5\n", "names i twice"),
        ("x,y,z,X\n1,2,3,4\n", "names x twice"),
        ("x,y,z\n1,2,3,4\n", "'x,y,z' does not name the 4 columns"),
        ("1,5 2,5 3,5\n", "decimal comma"),
        ("1,5;2,5;3,5\n", "decimal comma"),
        ("1 2 3\0\n", "no text file"),
    ],
)
def test_sentences(tmp_path: Path, content: str, sentence: str) -> None:
    path = put(tmp_path, content)
    with pytest.raises(BadInput, match=sentence):
        text.preflight(path)
    with pytest.raises(BadInput, match=sentence):
        text.read(path, PLAIN, QUIET)


def test_utf16_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes("x y z\n1 2 3\n".encode("utf-16"))
    with pytest.raises(BadInput, match="UTF-16"):
        text.preflight(path)


def test_the_user_corrects_the_layout(tmp_path: Path) -> None:
    path = put(tmp_path, "1 2 3 4\n5 6 7 8\n9 10 11 12\n")
    options = ReadOptions(header_lines=1, columns=("row", "-", "y", "x"))
    with pytest.raises(BadInput, match="no z"):
        text.read(path, options, QUIET)
    options = ReadOptions(header_lines=1, columns=("z", "-", "y", "x"), separator="space")
    (scan,) = text.read(path, options, QUIET)
    assert scan.xyz.tolist() == [[8, 7, 5], [12, 11, 9]]
    assert scan.attributes == {}
    with pytest.raises(BadInput, match=r"3 columns were named and a\.txt has 4"):
        text.read(path, ReadOptions(columns=("x", "y", "z")), QUIET)
    with pytest.raises(BadInput, match="cannot separate"):
        text.read(path, ReadOptions(separator="\n"), QUIET)


def test_ragged_rows_are_counted_and_named(tmp_path: Path) -> None:
    path = put(tmp_path, "x y z\n1 2 3\n\n4 5\n6 7 8\n")
    (scan,) = text.read(path, PLAIN, QUIET)
    assert scan.xyz.tolist() == [[1, 2, 3], [6, 7, 8]]
    assert scan.warnings == (
        "a.txt: lines left out because they are no row of 3 columns: 1; first line 4: '4 5'.",
    )


def test_mostly_ragged_file_is_refused(tmp_path: Path) -> None:
    path = put(tmp_path, "x y z\n" + "1 2 3\n" * 1000 + "4 5\n" * 1001)
    with pytest.raises(BadInput, match="first line 1002: '4 5'"):
        text.read(path, PLAIN, QUIET)


def test_empty_cells_are_nan_and_words_are_numbered(tmp_path: Path) -> None:
    path = put(tmp_path, "x,y,z,i,kind\n1,2,3,,leaf\n1,2,3,4,wood\n1,2,3,5,leaf\n")
    (scan,) = text.read(path, PLAIN, QUIET)
    np.testing.assert_array_equal(scan.attributes["i"], [np.nan, 4, 5])
    assert scan.attributes["kind"].tolist() == [0, 1, 0]
    assert scan.metadata["words of kind"] == "0 = leaf; 1 = wood"


def test_wrong_count_line_is_said(tmp_path: Path) -> None:
    (scan,) = text.read(put(tmp_path, "3\n1 2 3\n4 5 6\n", "a.pts"), PLAIN, QUIET)
    assert scan.warnings == ("a.pts announces 3 points and holds 2.",)


FLOATS = st.floats(width=64)


@given(
    rows=st.lists(st.tuples(FLOATS, FLOATS, FLOATS, FLOATS), min_size=1, max_size=8),
    separator=st.sampled_from([",", ", ", ";", "\t", " ", "   "]),
    header=st.booleans(),
    end=st.sampled_from(["\n", "\r\n"]),
    every=st.integers(1, 3),
)
def test_against_the_numbers_written(
    tmp_path_factory: pytest.TempPathFactory,
    rows: list[tuple[float, ...]],
    separator: str,
    header: bool,
    end: str,
    every: int,
) -> None:
    lines = [separator.join("XYZi")] if header else []
    lines += [separator.join(map(repr, row)) for row in rows]
    path = put(tmp_path_factory.mktemp("text"), end.join(lines))
    (scan,) = text.read(path, ReadOptions(every_nth=every), QUIET)
    values = np.array(rows)[::every]
    np.testing.assert_array_equal(scan.xyz, values[:, :3])
    np.testing.assert_array_equal(scan.attributes["i" if header else "column_4"], values[:, 3])


@given(st.text(alphabet="xyz0123456789.,;\t -+e\"'#/\r\n\\nait_é\0", max_size=200))
def test_noise(tmp_path_factory: pytest.TempPathFactory, content: str) -> None:
    path = put(tmp_path_factory.mktemp("noise"), content)
    try:
        text.read(path, PLAIN, QUIET)
    except BadInput:
        return


@given(st.binary(max_size=200))
def test_binary_noise(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.mktemp("noise") / "a.xyz"
    path.write_bytes(b"1 2 3\n" + content)
    try:
        text.read(path, PLAIN, QUIET)
    except BadInput:
        return


REFUSED = {"text__badheader.txt", "text__text.txt"}


@pytest.mark.data
def test_edge_cases(shared_data: Path) -> None:
    files = [*shared_data.glob("edge_cases/text__*"), *shared_data.glob("edge_cases/pts__*")]
    refused = set()
    for path in files:
        try:
            (scan,) = text.read(path, PLAIN, QUIET)
        except BadInput:
            refused.add(path.name)
        else:
            assert scan.valid.all()
    assert refused == REFUSED


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "points"),
    [
        ("forest_vz400i_single_scan/pc_tree.txt", 75812),
        ("larch_leaf_wood_labelled/larch_training_leaf.txt", 4474),
        ("edge_cases/text__utm17_3.txt", 10),
    ],
)
def test_real_files(shared_data: Path, name: str, points: int) -> None:
    (scan,) = text.read(shared_data / name, PLAIN, QUIET)
    assert len(scan) == points
