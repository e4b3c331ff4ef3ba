"""The header of a PCD file: fields, size of the table, viewpoint, encoding."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.errors import BadInput
from app.formats.line_blocks import decode
from app.formats.number_lines import to_number
from app.model.scan import Pose

LONGEST = 1 << 16
PADDING = "_"
ENCODINGS = ("ascii", "binary", "binary_compressed")
_TYPES = {f"{kind}{size}": f"{low}{size}" for kind, low in zip("IUF", "iuf", strict=True)
          for size in (1, 2, 4, 8)}  # fmt: skip
del _TYPES["F1"], _TYPES["F2"]
_DEFAULT_VIEW = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class PcdField:
    """A field of `count` values per point."""

    name: str
    type: str
    count: int


@dataclass(frozen=True, slots=True)
class PcdHeader:
    """Everything before the data, and where the data begin (bytes, lines)."""

    fields: tuple[PcdField, ...]
    points: int
    width: int
    height: int
    view: tuple[float, ...]
    encoding: str
    offset: int
    lines: int

    @property
    def row_type(self) -> np.dtype[np.void]:
        """Numpy's type of a binary row."""
        return np.dtype([(f"p{i}", f"<{f.type}", (f.count,)) for i, f in enumerate(self.fields)])

    @property
    def pose(self) -> Pose | None:
        """The viewpoint; None where it is the default, which most writers leave in."""
        if self.view == _DEFAULT_VIEW:
            return None
        x, y, z, *quaternion = self.view
        axes = _rotate(np.array(quaternion))
        return Pose((x, y, z), (axes[0], axes[1], axes[2]))


def _rotate(q: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[tuple[float, float, float]]:
    """Rotation matrix of a quaternion w x y z, rows as tuples; the unit matrix for none."""
    length = float(np.linalg.norm(q))
    w, x, y, z = q / length if length > 0 else (1.0, 0.0, 0.0, 0.0)
    rows = [
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]
    return [(float(a), float(b), float(c)) for a, b, c in rows]


def read_pcd_header(path: Path) -> PcdHeader:
    """Parse and check the header.

    Raises
    ------
    BadInput
        No PCD header, or entries that do not fit each other.
    """
    entries, offset, lines = _read_entries(path)
    fields = _parse_fields(path, entries)
    encoding = (entries["DATA"] or [""])[0].lower()
    if encoding not in ENCODINGS:
        raise BadInput(f"{path.name}: DATA {encoding[:40]!r} is not known.")
    width, height = _count(path, entries, "WIDTH"), _count(path, entries, "HEIGHT", "1")
    points = _count(path, entries, "POINTS", str(width * height))
    if points != width * height:
        raise BadInput(f"{path.name} claims {points} points in a table of {width} × {height}.")
    view = _parse_view(path, entries.get("VIEWPOINT"))
    return PcdHeader(fields, points, width, height, view, encoding, offset, lines)


def _read_entries(path: Path) -> tuple[dict[str, list[str]], int, int]:
    with path.open("rb") as file:
        head = file.read(LONGEST)
    entries: dict[str, list[str]] = {}
    offset = 0
    for number, line in enumerate(head.split(b"\n"), 1):
        offset += len(line) + 1
        words = decode(line).split("#")[0].split()
        if not words:
            continue
        entries[words[0].upper()] = words[1:]
        if words[0].upper() == "DATA":
            return entries, offset, number
        if number == 1 and words[0].upper() not in ("VERSION", "FIELDS"):
            break
    raise BadInput(
        f"{path.name} has no PCD header that ends with DATA.",
        "If it holds plain columns, rename it to .xyz.",
    )


def _parse_fields(path: Path, entries: dict[str, list[str]]) -> tuple[PcdField, ...]:
    names = entries.get("FIELDS", [])
    sizes, kinds = entries.get("SIZE", []), entries.get("TYPE", [])
    counts = entries.get("COUNT", ["1"] * len(names))
    if not names or not len(names) == len(sizes) == len(kinds) == len(counts):
        raise BadInput(f"{path.name}: FIELDS, SIZE, TYPE and COUNT have different lengths.")
    fields = []
    for name, size, kind, count in zip(names, sizes, kinds, counts, strict=True):
        item = _TYPES.get(kind.upper() + size)
        if item is None or not count.isdecimal() or not 1 <= len(count) <= 4 or int(count) < 1:
            raise BadInput(f"{path.name}: the field {name[:40]} has no known type and count.")
        fields.append(PcdField(name, item, int(count)))
    axes = [field.name.lower() for field in fields if field.count == 1]
    kept = [field.name for field in fields if field.name != PADDING]
    if len(set(kept)) < len(kept):
        raise BadInput(f"{path.name}: two fields have the same name.")
    missing = [axis for axis in "xyz" if axes.count(axis) != 1]
    if missing:
        raise BadInput(
            f"{path.name} has no single field {missing[0]}; its fields: {', '.join(names)[:200]}."
        )
    return tuple(fields)


def _count(path: Path, entries: dict[str, list[str]], key: str, default: str = "") -> int:
    text = (entries.get(key) or [default])[0]
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise BadInput(f"{path.name}: {key} {text[:40]!r} is no number of points.")
    return int(text)


def _parse_view(path: Path, words: list[str] | None) -> tuple[float, ...]:
    if words is None:
        return _DEFAULT_VIEW
    try:
        view = tuple(to_number(word) for word in words)
    except ValueError:
        view = ()
    if len(view) != 7 or not np.isfinite(view).all():
        raise BadInput(f"{path.name}: VIEWPOINT is not seven numbers.")
    return view
