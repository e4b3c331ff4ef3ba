"""The XML section of an E57 file, read with expat and nothing else.

libE57 hands it to a parser that opens external entities, recurses and expands: whatever
could use that is refused here first (no DOCTYPE, bounded depth, size and strings).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from app.core.errors import BadInput
from app.formats.guard import clean, first_line

PAGE = 1024
_PAYLOAD = PAGE - 4  # each page ends with a checksum of four bytes
_HEADER = struct.Struct("<8sIIQQQQ")
_LARGEST_XML = 64 << 20
_LONGEST_TEXT = 1 << 20
_MOST_NODES = 1_000_000
_DEEPEST = 64


@dataclass(slots=True)
class Node:
    """One element: its name with prefix, attributes, text and children."""

    name: str
    attributes: dict[str, str]
    text: str = ""
    children: list[Node] = field(default_factory=list)

    def child(self, name: str) -> Node | None:
        """The first child of that name."""
        return next((child for child in self.children if child.name == name), None)

    def find(self, *names: str) -> Node | None:
        """The node at the end of a path of names."""
        node: Node | None = self
        for name in names:
            node = node.child(name) if node is not None else None
        return node

    def number(self, *names: str) -> float | None:
        """The number at the end of a path; an empty element means 0, as E57 has it."""
        node = self.find(*names)
        if node is None:
            return None
        try:
            return float(node.text.strip() or 0)
        except ValueError:
            raise BadInput(
                f"E57: {'/'.join(names)} is no number: {clean(node.text)[:40]}."
            ) from None

    def string(self, *names: str) -> str:
        """The text at the end of a path; empty where there is none."""
        node = self.find(*names)
        return "" if node is None else clean(node.text)


def read_xml(path: Path) -> Node:
    """Check the header of the file and parse its XML section.

    Raises
    ------
    BadInput
        The file is cut off, or its XML is malformed, too large or made to do harm.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        start, length = _check_header(file.read(_HEADER.size), size, path.name)
        file.seek(start - start % PAGE)
        pages = file.read(_physical(start % PAGE + length) + 2 * PAGE)
    payload = b"".join(_payloads(pages, start % PAGE))[:length]
    return _parse(payload, path.name)


def _check_header(head: bytes, size: int, name: str) -> tuple[int, int]:
    if len(head) < _HEADER.size or size % PAGE:
        raise BadInput(f"{name} is cut off: an E57 file is made of whole pages of {PAGE} bytes.")
    _, major, minor, claimed, start, length, page = _HEADER.unpack(head)
    if (major, minor) != (1, 0):
        raise BadInput(f"{name} claims to be E57 {major}.{minor}; only 1.0 exists.")
    if page != PAGE:
        raise BadInput(f"{name}: E57 has pages of {PAGE} bytes, not of {page}.")
    if claimed != size:
        raise BadInput(f"{name} should have {claimed} bytes and has {size}: it was cut off.")
    if not 0 < length <= _LARGEST_XML:
        raise BadInput(f"{name}: an XML section of {length} bytes is impossible.")
    if not _HEADER.size <= start < size or start % PAGE >= _PAYLOAD:
        raise BadInput(f"{name}: its XML section cannot begin at byte {start}.")
    if length > logical_bytes(size - start):
        raise BadInput(f"{name}: its XML section of {length} bytes is longer than the file.")
    return start, length


def logical_bytes(physical: int) -> int:
    """Most bytes of content in that many bytes of pages."""
    return physical // PAGE * _PAYLOAD + min(physical % PAGE, _PAYLOAD)


def _physical(logical: int) -> int:
    return -(-logical // _PAYLOAD) * PAGE


def _payloads(pages: bytes, skip: int) -> Iterator[bytes]:
    for start in range(0, len(pages), PAGE):
        yield pages[start + (skip if start == 0 else 0) : start + _PAYLOAD]


def _parse(xml: bytes, name: str) -> Node:
    builder = _Builder(name)
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.text
    parser.StartDoctypeDeclHandler = builder.refuse_doctype
    parser.EntityDeclHandler = builder.refuse_doctype
    parser.XmlDeclHandler = builder.check_encoding
    try:
        parser.Parse(xml, True)
    except expat.ExpatError as error:
        raise BadInput(f"{name}: its XML section is malformed ({first_line(error)}).") from error
    return builder.root


class _Builder:
    """Makes a tree of nodes and refuses what nobody needs."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._open: list[Node] = [Node("", {})]
        self._nodes = 0

    @property
    def root(self) -> Node:
        return self._open[0].children[0]

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self._nodes += 1
        if len(self._open) > _DEEPEST:
            self._refuse(f"is nested deeper than {_DEEPEST} levels")
        if self._nodes > _MOST_NODES:
            self._refuse(f"has more than {_MOST_NODES} elements")
        node = Node(name, attributes)
        self._open[-1].children.append(node)
        self._open.append(node)

    def end(self, _: str) -> None:
        self._open.pop()

    def text(self, text: str) -> None:
        node = self._open[-1]
        if len(node.text) + len(text) > _LONGEST_TEXT:
            self._refuse(f"holds a text of more than {_LONGEST_TEXT} letters")
        node.text += text

    def refuse_doctype(self, *_: object) -> None:
        self._refuse("declares a document type or entities, which E57 never needs")

    def check_encoding(self, _: str, encoding: str | None, __: int) -> None:
        if (encoding or "utf-8").lower() != "utf-8":
            self._refuse(f"is written in {clean(encoding or '')}, not in UTF-8")

    def _refuse(self, why: str) -> NoReturn:
        raise BadInput(
            f"{self._name}: its XML section {why}.", "Leafscope does not open it, for safety."
        )
