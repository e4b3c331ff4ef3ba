"""Blocks of lines and their numbers, against the plainest of parsers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.formats import line_blocks
from app.formats.line_blocks import LineReader, count_lines
from app.formats.number_lines import parse_block

CELLS = st.sampled_from(
    ["1", "-2.5", "1e300", "nan", "inf", "", "x", "1_0", "0x1", "3.", ".5", "9" * 30, "٣", '"7"']
)


@pytest.mark.parametrize("separator", [",", None, "\t", ";"])
@given(rows=st.lists(st.lists(CELLS, min_size=1, max_size=4), max_size=6), crlf=st.booleans())
def test_against_a_naive_parser(separator: str | None, rows: list[list[str]], crlf: bool) -> None:
    end = "\r\n" if crlf else "\n"
    text = "".join((separator or " ").join(row) + end for row in rows)
    parsed = parse_block(text.encode(), ["f8"] * 3, separator)
    good, bad = [], []
    for index, line in enumerate(text.split("\n")):
        numbers = naive_row(line, separator)
        if numbers is not None and len(numbers) == 3:
            good.append(numbers)
        elif line.strip():
            bad.append(index)
    np.testing.assert_array_equal(np.column_stack(parsed.columns), np.reshape(good, (-1, 3)))
    assert parsed.bad == bad


def naive_row(line: str, separator: str | None) -> list[float] | None:
    cells = [cell.strip().strip('"') for cell in line.strip("\r\n").split(separator)]
    if len(cells) == 4 and not cells[-1]:
        cells.pop()
    if any("_" in cell or not cell.isascii() for cell in cells):
        return None
    try:
        return [float(cell or "nan") for cell in cells]
    except ValueError:
        return None


def test_integers_of_64_bits_stay_exact() -> None:
    block = b"9223372036854775807 18446744073709551615 0.1\n-9223372036854775808 0 1e3\n"
    columns = parse_block(block, ["i8", "u8", "f8"], None).columns
    assert columns[0].tolist() == [2**63 - 1, -(2**63)]
    assert columns[1].tolist() == [2**64 - 1, 0]


def test_integer_out_of_range_is_a_bad_line() -> None:
    assert parse_block(b"1 2\n9223372036854775808 2\n1.5 2\n3.0 2\n", ["i8", "f8"], None).bad == [
        1,
        2,
    ]


@given(
    lines=st.lists(st.text("ab\r ", max_size=9), max_size=30),
    ends=st.booleans(),
    block=st.integers(1, 20),
    wanted=st.lists(st.integers(1, 9), max_size=5),
)
def test_blocks_give_every_byte_once(
    tmp_path_factory: pytest.TempPathFactory,
    lines: list[str],
    ends: bool,
    block: int,
    wanted: list[int],
) -> None:
    path = tmp_path_factory.mktemp("lines") / "lines.txt"
    data = ("\n".join(lines) + ("\n" if ends else "")).encode()
    path.write_bytes(data)
    before, line_blocks.BLOCK = line_blocks.BLOCK, block
    try:
        with LineReader(path) as reader:
            got = b""
            for count in wanted:
                reader.peek()
                part = b"".join(reader.blocks(count))
                ended = part.count(b"\n")
                assert ended == count or (ended < count and got + part == data)
                got += part
                assert got == data[: len(got)]
            got += b"".join(reader.blocks())
            assert reader.lines_read == count_lines(path)
    finally:
        line_blocks.BLOCK = before
    assert got == data


def test_endless_line_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "zeros.txt"
    path.write_bytes(b"0" * (5 << 20))
    with pytest.raises(BadInput, match="line 1 is longer"), LineReader(path) as reader:
        list(reader.blocks())
