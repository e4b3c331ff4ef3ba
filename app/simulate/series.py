"""One value of a scene varied: angles of a stage, hours of drying, ranges of a panel, seeds."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from app.core.errors import WrongUse
from app.simulate.scene_file import Document, SceneFile, SeriesTable

MOST_STEPS = 10_000


@dataclass(frozen=True, slots=True)
class Series:
    """A path in a scene file, and the values that it takes one after the other."""

    path: str
    values: tuple[Any, ...]


def vary(document: Document, path: str, value: Any) -> Document:
    """A copy of a scene's document with one value changed; the document stays as it is.

    Parameters
    ----------
    document : dict
        As `scene_file.load_document` gives it; the result is for `scene_file.decode_scene`,
        which refuses keys and values that do not fit.
    path : str
        Keys and places joined by dots, such as ``hours``, ``part.0.angle_deg``; in place of
        ``part.0`` the part's name: ``stage.angle_deg``.
    value : object

    Raises
    ------
    WrongUse
        The path leads nowhere.
    """
    keys = path.split(".")
    names = _name_parts(document)
    if keys[0] and keys[0] in names:
        keys = ["part", str(names.index(keys[0])), *keys[1:]]
    elif len(keys) > 1 and keys[0] not in SceneFile.__struct_fields__:
        known = ", ".join(name for name in names if name) or "none has a name"
        raise WrongUse(
            f"{path!r} leads nowhere: there is no part {keys[0]!r}.",
            f"Parts by name: {known}; or say part.0, part.1 …",
        )
    varied: Document = _set(document, keys, value, path)
    return varied


def parse_settings(texts: Iterable[str]) -> tuple[tuple[str, Any], ...]:
    """Paths and values of texts such as ``stage.angle_deg=30`` and ``instrument=salca``.

    Raises
    ------
    WrongUse
        A text has no ``=``, or its value is not like one in a scene file.
    """
    return tuple((path, _read_value(value, text)) for text in texts for path, value in [_cut(text)])


def parse_series(text: str) -> Series:
    """A series such as ``stage.angle_deg=0:85:5`` (both ends) or ``hours=0,3,6``.

    Raises
    ------
    WrongUse
        It has no ``=``, no values, or more than 10 000.
    """
    path, values = _cut(text)
    return Series(path, _read_values(values, text))


def series_of(table: SeriesTable) -> Series:
    """The series that a scene file carries."""
    if isinstance(table.values, str):
        return Series(table.path, _read_values(table.values, f"{table.path}={table.values}"))
    return Series(table.path, table.values)


def _name_parts(document: Document) -> list[Any]:
    parts = document.get("part")
    if not isinstance(parts, list):
        return []
    return [part.get("name") if isinstance(part, dict) else None for part in parts]


def _set(node: Any, keys: list[str], value: Any, path: str) -> Any:
    """The node with the value at `keys`; only what lies on the way is copied."""
    if not keys:
        return value
    key, rest = keys[0], keys[1:]
    if isinstance(node, dict) and key:
        return {**node, key: _set(node.get(key, {}), rest, value, path)}
    if isinstance(node, list) and key.isdecimal() and int(key) < len(node):
        place = int(key)
        return [*node[:place], _set(node[place], rest, value, path), *node[place + 1 :]]
    here = f"one of {len(node)} by its number from 0" if isinstance(node, list) else "a value"
    raise WrongUse(f"{path!r} leads nowhere: where it says {key!r} there is {here}.")


def _cut(text: str) -> tuple[str, str]:
    path, sign, value = text.partition("=")
    if not sign or not path.strip() or not value.strip():
        raise WrongUse(f"{text!r} does not say what is to be what.", "Write PATH=VALUE.")
    return path.strip(), value.strip()


def _read_value(value: str, text: str) -> Any:
    """A value as TOML writes it; a bare word is text."""
    try:
        table = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError) as error:
        if value.replace("_", "").isalnum():
            return value
        raise WrongUse(f"{text!r} has no value like those of a scene file.") from error
    if list(table) != ["value"]:
        raise WrongUse(f"{text!r} says more than one value.")
    return table["value"]


def _read_values(values: str, text: str) -> tuple[Any, ...]:
    pieces = values.split(":")
    if len(pieces) == 3:
        return _count_up(pieces, text)
    if len(pieces) == 1:
        found = tuple(_read_value(piece.strip(), text) for piece in values.split(","))
        if len(found) <= MOST_STEPS:
            return found
    raise WrongUse(
        f"{text!r} is no series of 1 to {MOST_STEPS} values.",
        "Write start:stop:step, or values with commas between them.",
    )


def _count_up(pieces: list[str], text: str) -> tuple[float, ...]:
    """Start, start + step … up to the stop, whole numbers where they are whole."""
    try:
        start, stop, step = map(float, pieces)
    except ValueError as error:
        raise WrongUse(f"{text!r} has no numbers.", "Write start:stop:step.") from error
    steps = (stop - start) / step if step else float("nan")
    if not 0 <= steps < MOST_STEPS:
        raise WrongUse(
            f"{text!r} makes no series of 1 to {MOST_STEPS} values.",
            "Write start:stop:step, with a step from start towards stop.",
        )
    # Half a millionth of a step: 0:0.3:0.1 is to reach its end.
    found = (round(start + k * step, 12) for k in range(int(steps + 5e-7) + 1))
    return tuple(int(value) if value.is_integer() else value for value in found)
