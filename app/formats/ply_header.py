"""The header of a PLY file: elements, their properties, comments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from app.core.errors import BadInput
from app.formats.line_blocks import decode

Encoding = Literal["ascii", "binary_little_endian", "binary_big_endian"]
ENCODINGS: tuple[Encoding, ...] = ("ascii", "binary_little_endian", "binary_big_endian")
LONGEST = 1 << 20
TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "bool": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "int64": "i8", "long": "i8", "uint64": "u8", "ulong": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Property:
    """A property: its type, and the type of its length where it is a list."""

    name: str
    type: str
    length_type: str | None = None


@dataclass(slots=True)
class Element:
    """An element: `count` rows of its properties."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)

    @property
    def has_lists(self) -> bool:
        """Whether rows differ in length."""
        return any(item.length_type for item in self.properties)

    def row_type(self, encoding: Encoding) -> np.dtype[np.void]:
        """Numpy's type of a binary row without lists."""
        order = ">" if encoding == "binary_big_endian" else "<"
        names = [f"p{i}" for i in range(len(self.properties))]
        return np.dtype([(n, order + p.type) for n, p in zip(names, self.properties, strict=True)])

    def smallest_row(self, encoding: Encoding) -> int:
        """Bytes that a row has at least."""
        if encoding == "ascii":
            return max(2 * len(self.properties) - 1, 1)
        return sum(np.dtype(p.length_type or p.type).itemsize for p in self.properties)


@dataclass(frozen=True, slots=True)
class PlyHeader:
    """Everything before the data, and where the data begin (bytes, lines)."""

    encoding: Encoding
    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    offset: int
    lines: int

    @property
    def vertex(self) -> Element:
        """The element that holds the points."""
        return next(element for element in self.elements if element.name == "vertex")

    @property
    def before_vertex(self) -> tuple[Element, ...]:
        """Elements whose data precede the points."""
        return self.elements[: self.elements.index(self.vertex)]


def read_ply_header(path: Path) -> PlyHeader:
    """Parse and check the header.

    Raises
    ------
    BadInput
        No PLY header, a line that means nothing, or no usable element ``vertex``.
    """
    head = _read_head(path)
    lines = decode(head).splitlines()
    encoding: Encoding | None = None
    elements: list[Element] = []
    comments = []
    for number, line in enumerate(lines[1:-1], 2):
        words = line.split()
        match words:
            case ["format", name, _] if name in ENCODINGS:
                encoding = ENCODINGS[ENCODINGS.index(name)]
            case ["comment" | "obj_info", *_]:
                comments.append(line.strip().partition(" ")[2])
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append(Element(name, _parse_count(path, count)))
            case ["property", *rest] if elements:
                elements[-1].properties.append(_parse_property(path, number, rest))
            case []:
                pass
            case _:
                raise _meaningless(path, number, line)
    if encoding is None:
        raise BadInput(f"{path.name} does not say whether it is ascii or binary.")
    _check_vertex(path, elements)
    return PlyHeader(encoding, tuple(elements), tuple(comments), len(head), len(lines))


def _read_head(path: Path) -> bytes:
    with path.open("rb") as file:
        head = file.read(LONGEST)
    if not head.startswith(b"ply"):
        raise BadInput(f"{path.name} does not begin with 'ply'.", "This is no PLY file.")
    for start, end in _find_lines(head):
        if head[start:end].strip() == b"end_header":
            return head[:end]
    raise BadInput(f"{path.name} has no end_header.", "The PLY header is cut or damaged.")


def _find_lines(head: bytes) -> Iterator[tuple[int, int]]:
    start = 0
    while start < len(head):
        end = head.find(b"\n", start) + 1 or len(head)
        yield start, end
        start = end


def _parse_count(path: Path, count: str) -> int:
    if len(count) > 18:
        raise BadInput(f"{path.name} claims {count[:20]}… rows.", "The header is damaged.")
    return int(count)


def _parse_property(path: Path, number: int, words: list[str]) -> Property:
    match words:
        case ["list", length_type, item_type, name] if length_type in TYPES and item_type in TYPES:
            return Property(name, TYPES[item_type], TYPES[length_type])
        case [item_type, name] if item_type in TYPES:
            return Property(name, TYPES[item_type])
    raise _meaningless(path, number, "property " + " ".join(words))


def _meaningless(path: Path, number: int, line: str) -> BadInput:
    return BadInput(
        f"{path.name}, line {number}: {line.strip()[:60]!r} means nothing in a PLY header.",
        "The file is damaged, or uses a type that PLY does not have.",
    )


def _check_vertex(path: Path, elements: list[Element]) -> None:
    vertices = [element for element in elements if element.name == "vertex"]
    if len(vertices) != 1:
        found = ", ".join(element.name for element in elements) or "none"
        raise BadInput(f"{path.name} has no element vertex; its elements: {found}.")
    names = [item.name for item in vertices[0].properties]
    lists = [item.name for item in vertices[0].properties if item.length_type]
    missing = {"x", "y", "z"} - {name.lower() for name in names}
    if missing:
        raise BadInput(
            f"{path.name}: its vertices have no {', '.join(sorted(missing))};"
            f" their properties: {', '.join(names)[:200] or 'none'}."
        )
    if lists:
        raise BadInput(f"{path.name}: the property {lists[0]} of its vertices is a list.")
    if len({name.lower() if name.lower() in "xyz" else name for name in names}) < len(names):
        raise BadInput(f"{path.name}: two properties of its vertices have the same name.")
