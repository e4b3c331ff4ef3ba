"""The layout of a text file of points, guessed from its first lines or given by the user."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.core.errors import BadInput, UnclearLayout
from app.formats.line_blocks import decode
from app.formats.number_lines import Kind, split_cells, to_number
from app.formats.options import ReadOptions

HEAD = 1 << 16
HINT = "Name the columns with --columns x,y,z,… (- leaves one out)."
_SEPARATORS = (";", "\t", ",", None)
_WORDS = {"tab": "\t", "\\t": "\t", "space": None, "": None, " ": None, "comma": ",",
          "semicolon": ";"}  # fmt: skip
_WITHOUT_NAMES = {
    4: ("x", "y", "z", "intensity"),
    6: ("x", "y", "z", "red", "green", "blue"),
    7: ("x", "y", "z", "intensity", "red", "green", "blue"),
}
_MOST_COLUMNS = 4096


@dataclass(frozen=True, slots=True)
class TextLayout:
    """How a text file is read; each part can be corrected through `ReadOptions`.

    Attributes
    ----------
    separator : str or None
        One character; None for any white space.
    header_lines : int
        Lines before the first point.
    columns : tuple of str
        A name for each column; ``-`` is left out.
    kinds : tuple of {'f8', 'text'}
        What each column holds.
    claimed : int or None
        Points that a count line promises.
    warnings : tuple of str
    """

    separator: str | None
    header_lines: int
    columns: tuple[str, ...]
    kinds: tuple[Kind, ...]
    claimed: int | None = None
    warnings: tuple[str, ...] = ()

    @property
    def axes(self) -> tuple[int, int, int]:
        """Columns of x, y and z."""
        names = [_axis(name) for name in self.columns]
        return names.index("x"), names.index("y"), names.index("z")

    def describe(self) -> dict[str, str]:
        """The layout as a user reads it."""
        names = {None: "white space", "\t": "tab", ",": "comma", ";": "semicolon"}
        return {
            "separator": names.get(self.separator, repr(self.separator)),
            "header_lines": str(self.header_lines),
            "columns": ", ".join(self.columns),
        }


@dataclass(frozen=True, slots=True)
class TextRows:
    """Where the points of a text file begin, and its first rows as cells.

    Attributes
    ----------
    separator : str or None
    header_lines : int
    cells : list of rows, each a list of str
    width : int
        Cells that most rows have.
    before : list of str
        Lines above the points.
    """

    separator: str | None
    header_lines: int
    cells: list[list[str]]
    width: int
    before: list[str]


def find_rows(path: Path, options: ReadOptions) -> TextRows:
    """Find the rows of a file, from its first 64 kB and what the user gave.

    Raises
    ------
    UnclearLayout
        No rows of three numbers or more; the sentence says what was found.
    """
    try:
        lines = _read_lines(path)
        forced = options.separator is not None
        separators = [_to_separator(options.separator)] if forced else list(_SEPARATORS)
        start, separator = _find_rows(path, lines, separators, options.header_lines)
    except BadInput as error:
        raise UnclearLayout(error.what, error.hint, str(path)) from error
    cells = [_split(line, separator) for line in lines[start:] if line.strip()]
    before = [line for line in lines[:start] if line.strip()]
    return TextRows(separator, start, cells, _common_width(cells), before)


def find_layout(path: Path, options: ReadOptions) -> TextLayout:
    """Layout of a file, from its first 64 kB and what the user gave.

    Raises
    ------
    UnclearLayout
        No columns of numbers, or names that do not tell x, y and z once each; the
        sentence says what was found.
    """
    rows = find_rows(path, options)
    claimed = _take_count(rows.before)
    try:
        columns, warnings = _name_columns(
            path, rows.before, rows.separator, rows.width, options, claimed
        )
        kinds = _find_kinds(rows.cells, rows.width, columns)
        layout = TextLayout(rows.separator, rows.header_lines, columns, kinds, claimed, warnings)
        _check_axes(path, layout)
    except BadInput as error:
        raise UnclearLayout(error.what, error.hint, str(path)) from error
    return layout


def _read_lines(path: Path) -> list[str]:
    with path.open("rb") as file:
        head = file.read(HEAD)
        complete = not file.read(1)
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise BadInput(f"{path.name} is UTF-16 text.", "Save it as UTF-8.")
    if b"\0" in head:
        raise BadInput(f"{path.name} is no text file.")
    lines = decode(head).split("\n")
    return lines if complete or len(lines) == 1 else lines[:-1]


def _to_separator(text: str | None) -> str | None:
    given = (text or "").lower()
    separator = _WORDS.get(given, given)
    if separator is not None and (
        len(separator) != 1 or separator.isalnum() or separator in '+-."\r\n'
    ):
        raise BadInput(f"{text!r} cannot separate columns.", "Give , ; tab or space.")
    return separator


def _find_rows(
    path: Path, lines: Sequence[str], separators: Sequence[str | None], skip: int | None
) -> tuple[int, str | None]:
    """First line with points, and what stands between its cells."""
    first = skip or 0
    for index, line in enumerate(lines[first:], first):
        counts = [(_count_numbers(line, separator), separator) for separator in separators]
        most = max(count for count, _ in counts)
        if most >= 3:
            chosen = next(separator for count, separator in counts if count == most)
            return (index if skip is None else skip), chosen
    if any(re.fullmatch(r"\s*-?\d+,\d+([\s;]+-?\d+,\d+){2,}.*", line) for line in lines):
        raise BadInput(
            f"{path.name} writes numbers with a decimal comma.", "Save it with decimal points."
        )
    found = next((line.strip() for line in lines if line.strip()), "nothing")
    raise BadInput(
        f"{path.name} holds no line of three numbers or more; it begins with {found[:60]!r}.",
        "Give --separator if there are columns.",
    )


def _count_numbers(line: str, separator: str | None) -> int:
    """Cells that are numbers; 0 where other cells outnumber them."""
    cells = _split(line, separator)
    if {"x", "y", "z"} <= {_axis(cell) for cell in cells}:  # a header that names wavelengths
        return 0
    numbers = sum(1 for cell in cells if cell and _is_number(cell))
    return numbers if 2 * numbers >= len(cells) else 0


def _split(line: str, separator: str | None) -> list[str]:
    try:
        return split_cells(line, separator)
    except ValueError:  # quotes that do not fit
        return []


def _is_number(cell: str) -> bool:
    try:
        to_number(cell)
    except ValueError:
        return False
    return True


def _common_width(rows: Sequence[Sequence[str]]) -> int:
    """Most common number of cells; an empty one at the end of the line is none."""
    widths = Counter(len(row) - (row[-1] == "") for row in rows[:1000] if row)
    return widths.most_common(1)[0][0] if widths else 0


def _take_count(before: list[str]) -> int | None:
    """The count line, removed from the lines before the points; None where there is none."""
    if before and re.fullmatch(r"\s*\d{1,18}\s*", before[-1]):
        return int(before.pop())
    return None


def _name_columns(
    path: Path,
    before: Sequence[str],
    separator: str | None,
    width: int,
    options: ReadOptions,
    claimed: int | None,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    if width < 3:
        raise BadInput(f"{path.name}: most lines have fewer than three columns.", HINT)
    if width > _MOST_COLUMNS:
        raise BadInput(f"{path.name} has {width} columns.", f"At most {_MOST_COLUMNS} are read.")
    if options.columns is not None:
        if len(options.columns) != width:
            raise BadInput(
                f"{len(options.columns)} columns were named and {path.name} has {width}.", HINT
            )
        return options.columns, ()
    names = _find_names(before, separator, width)
    if names is not None:
        return names, ()
    if any(_is_header(line) for line in before[-1:]):
        found = before[-1].strip()[:80]
        raise BadInput(
            f"{path.name}: the header {found!r} does not name the {width} columns.", HINT
        )
    return _default_names(path, width, claimed)


def _find_names(before: Sequence[str], separator: str | None, width: int) -> tuple[str, ...] | None:
    """Names on the last line before the points that has as many cells as they have."""
    for line in reversed(before):
        text = re.sub(r"^\s*(//|#|%)\s*", "", line)
        for candidate in (separator, *_SEPARATORS):
            cells = _split(text, candidate)
            if len(cells) == width + 1 and not cells[-1]:
                cells.pop()
            if len(cells) == width and not all(_is_number(cell) for cell in cells[:3]):
                return tuple(_clean(cell) or f"column_{i}" for i, cell in enumerate(cells, start=1))
    return None


def _is_header(line: str) -> bool:
    return not line.lstrip().startswith(("#", "//", "%"))


def _clean(name: str) -> str:
    """A name without control characters, and without the guard of our own CSV writer."""
    name = "".join(letter for letter in name if letter.isprintable())[:200].strip()
    return name[1:] if re.match(r"'[=+\-@]", name) else name


def _default_names(
    path: Path, width: int, claimed: int | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    if path.suffix.lower() == ".pts" or claimed is not None:
        names = _WITHOUT_NAMES.get(width)
        if names is not None:
            return names, ()
    names = ("x", "y", "z", *(f"column_{i}" for i in range(4, width + 1)))
    sentence = f"{path.name} names no columns: the first three of {width} are taken as x, y, z."
    return names, (sentence,) if width > 3 else ()


def _find_kinds(
    rows: Sequence[Sequence[str]], width: int, columns: Sequence[str]
) -> tuple[Kind, ...]:
    """Text where most cells are none that reads as a number."""
    sample = [row for row in rows[:1000] if len(row) >= width]
    kinds: list[Kind] = []
    for index in range(width):
        words = sum(1 for row in sample if not _is_number(row[index]))
        kinds.append("text" if 2 * words > len(sample) else "f8")
    return tuple("text" if name == "-" else kind for kind, name in zip(kinds, columns, strict=True))


def _axis(name: str) -> str:
    """x, y or z where the name says so, with or without a unit in brackets."""
    bare = re.sub(r"\s*[(\[].*[)\]]$", "", name).lower()
    return bare if bare in ("x", "y", "z") else ""


def _check_axes(path: Path, layout: TextLayout) -> None:
    names = [name for name in layout.columns if name != "-"]
    shown = ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
    axes = Counter(_axis(name) for name in names)
    missing = [axis for axis in "xyz" if not axes[axis]]
    if missing:
        raise BadInput(
            f"{path.name} names no {' and no '.join(missing)} among its columns: {shown}.", HINT
        )
    twice = [name for name, count in Counter(names).items() if count > 1]
    twice += [axis for axis in "xyz" if axes[axis] > 1]
    if twice:
        raise BadInput(f"{path.name} names {twice[0]} twice: {shown}.", HINT)
    if any(layout.kinds[axis] == "text" for axis in layout.axes):
        raise BadInput(f"{path.name}: x, y or z is not a column of numbers: {shown}.", HINT)
