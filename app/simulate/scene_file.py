"""Scenes as small TOML files, read strictly: what a file says is what is built."""

from __future__ import annotations

import math
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from app.core.errors import BadInput, WrongUse
from app.core.units import group_digits
from app.simulate.parts import KINDS, AnyPart
from app.simulate.parts.part import Point
from app.simulate.ready_files import find_ready, read_start
from app.simulate.wind import Wind

LARGEST_FILE = 1 << 20
MOST_SURFACES = 200_000

Document = dict[str, Any]
"""A scene file as TOML tells it."""


class Field(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A field of view: lowest and highest angle each way, degrees."""

    azimuth_deg: tuple[
        Annotated[float, Meta(ge=-360, le=360)], Annotated[float, Meta(ge=-360, le=360)]
    ]
    elevation_deg: tuple[
        Annotated[float, Meta(ge=-90, le=90)], Annotated[float, Meta(ge=-90, le=90)]
    ]

    def __post_init__(self) -> None:
        for name in ("azimuth_deg", "elevation_deg"):
            low, high = getattr(self, name)
            if not low < high:
                raise ValueError(f"`{name}` is turned round: {low:g} to {high:g}")
        if self.azimuth_deg[1] - self.azimuth_deg[0] > 360:
            raise ValueError("`azimuth_deg` spans more than a full circle")


class SeriesTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The series that a scene is for: see `app.simulate.series`.

    `values` are a list, or text such as ``0:85:5``.
    """

    path: str
    values: str | tuple[float | str, ...]


class SceneFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A scene as it is written down.

    Attributes
    ----------
    name, description : str
    seed : int
        Of everything that is drawn at random in it.
    instrument : str
        Name of the preset that it is scanned with, unless another is asked for.
    position : point
        Of the scanner, world metres.
    step_deg : float, optional
        Step between beams; the instrument's unless given.
    field : Field or "fit"
        ``fit``: around all parts but walls and ground.
    margin_deg : float
        Rim around a fitted field.
    hours : float
        Since the leaves were cut; they dry.
    wind : Wind, optional
    part : tuple of parts
    series : SeriesTable, optional
    """

    name: Annotated[str, Meta(min_length=1, max_length=100)]
    part: Annotated[tuple[AnyPart, ...], Meta(min_length=1, max_length=10_000)]
    description: Annotated[str, Meta(max_length=1000)] = ""
    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)] = 0
    instrument: str = "two_colour"
    position: Point = (0.0, 0.0, 1.6)
    step_deg: Annotated[float, Meta(gt=0, le=90)] | None = None
    field: Field | Literal["fit"] = "fit"
    margin_deg: Annotated[float, Meta(ge=0, le=90)] = 0.3
    hours: Annotated[float, Meta(ge=0, le=100_000)] = 0.0
    wind: Wind | None = None
    series: SeriesTable | None = None


def list_scenes() -> tuple[str, ...]:
    """Names of the ready scenes, sorted."""
    return tuple(sorted(find_ready("scenes")))


def get_scene(name: str) -> SceneFile:
    """The ready scene of that name; raises `WrongUse` with the names there are."""
    return decode_scene(load_document(name), name)


def read_scene(path: Path) -> SceneFile:
    """Read a scene file.

    Raises
    ------
    BadInput
        The file cannot be read, is too large or no TOML, or a key is unknown, missing or out of
        range.
    """
    return decode_scene(load_document(path), path.name)


def load_document(source: str | Path) -> Document:
    """A scene as TOML tells it, by the name of a ready scene or by its file.

    Raises
    ------
    WrongUse
        There is no ready scene of that name.
    BadInput
        The file cannot be read, is too large or no TOML.
    """
    if isinstance(source, Path):
        return _load(source)
    scenes = find_ready("scenes")
    if source not in scenes:
        raise WrongUse(f"There is no scene {source!r}.", f"Scenes: {', '.join(sorted(scenes))}.")
    return _load(scenes[source])


def decode_scene(document: Document, origin: str) -> SceneFile:
    """Check and type a document; `origin` is the file that errors name.

    Raises
    ------
    BadInput
        A key is unknown, missing or out of range, or the scene is too large.
    """
    for path in _find_endless(document, ""):
        raise BadInput(f"{origin}: {path} is not a finite number.", "Correct it there.")
    try:
        scene = msgspec.convert(document, SceneFile, strict=True)
    except (msgspec.ValidationError, OverflowError) as error:
        raise _explain(str(error), document, origin) from error
    _check_names(scene, origin)
    count = sum(part.count_surfaces() for part in scene.part)
    if count > MOST_SURFACES:
        raise BadInput(
            f"{origin} asks for {group_digits(count)} surfaces; "
            f"{group_digits(MOST_SURFACES)} are the most.",
            "Ask for fewer leaves.",
        )
    return scene


def _load(file: Traversable) -> Document:
    content = read_start(file, LARGEST_FILE, "scene")
    if len(content) > LARGEST_FILE:
        raise BadInput(f"{file.name} is larger than 1 MB, too large for a scene.", "Shorten it.")
    try:
        return tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{file.name} is not a TOML file: {error}.", "Correct it there.") from error


def _find_endless(value: Any, path: str) -> Iterator[str]:
    """Paths of NaN and infinity, which no bound keeps out."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _find_endless(item, f"{path}.{key}".lstrip("."))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _find_endless(item, f"{path}.{index}")
    elif isinstance(value, float) and not math.isfinite(value):
        yield path


def _check_names(scene: SceneFile, origin: str) -> None:
    """Part names are handles of series: each stands for one part and for nothing else."""
    names = Counter(part.name for part in scene.part if part.name)
    for name, count in names.items():
        if count > 1:
            raise BadInput(f"{origin}: {count} parts are named {name!r}.", "Name each differently.")
        if name in SceneFile.__struct_fields__ or not re.fullmatch(r"[^\W\d]\w*", name):
            raise BadInput(
                f"{origin}: a part cannot be named {name!r}.",
                "Use a word of letters, digits and _ that is no key of the scene.",
            )


def _explain(message: str, document: Document, origin: str) -> BadInput:
    """What msgspec says of a path such as `$.part[0].length`, as a sentence."""
    text, _, place = message.partition(" - at `$")
    path = re.sub(r"\[(\d+|\.\.\.)\]", r".\1", place.rstrip("`")).lstrip(".")
    where = f"{origin}: {path}" if path else origin
    for theirs, ours in _WORDS.items():
        text = text.replace(theirs, ours)
    return BadInput(f"{where}: {text}.", _hint(text, path, document))


_WORDS = {
    "Object contains unknown field": "unknown key",
    "Object missing required field": "missing key",
    "Invalid enum value": "unknown value",
    "Invalid value": "unknown value",
    "Number out of range": "the number is out of range",
    "Expected": "expected",
    "`array`": "a list",
    "`object`": "a table",
    "`float`": "a number",
    "`int`": "a whole number",
    "`str`": "text",
    "`bool`": "true or false",
}


def _hint(text: str, path: str, document: Document) -> str:
    """The keys or kinds there are, where one is wrong."""
    part = re.fullmatch(r"part\.(\d+)(\.kind)?", path)
    if part and part.group(2):
        return f"Kinds: {', '.join(KINDS)}."
    if "unknown key" not in text and "missing key" not in text:
        return "Correct it there."
    if part:
        kind = KINDS.get(document["part"][int(part.group(1))].get("kind"))
        if kind is None:
            return f"Say its `kind`: {', '.join(KINDS)}."
        return f"Keys of {kind.__struct_config__.tag}: {', '.join(kind.__struct_fields__)}."
    return f"Keys of a scene: {', '.join(SceneFile.__struct_fields__)}." if not path else ""
