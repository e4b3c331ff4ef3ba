"""What the picture shows, worked out from document and view; the renderer applies differences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.radiometry.marks import WORDS
from app.core.workflows.marks import WORDS as CORRECTION_WORDS
from app.model.fields import FieldKind, Same, Values
from app.model.project import Project
from app.model.view_state import ViewState

Part = Literal["points", "mask", "colour", "range", "overlay", "style"]
SAMPLE = 200_000
DEFAULT_MAPS: Mapping[FieldKind, str] = {
    "scalar": "cividis",
    "angle": "viridis",
    "signed angle": "delta-omega",
    "signed": "residual",
    "score": "batlow",
    "flag": "flag",
    "verdict": "verdict",
    "mark": "marks",
    "correction": "marks",
    "class": "leaves",
}


@dataclass(frozen=True, slots=True)
class ColourBar:
    """What the colours mean: title, unit, map and limits."""

    field: str
    title: str
    unit: str
    kind: FieldKind
    map: str
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Cloud:
    """One scan in the picture. `Same` values tell whether arrays have to be fetched again."""

    scan: str
    points: Same
    mask: Same
    colour: Same | None
    bar: ColourBar | None
    overlay: tuple[object, ...]
    point_size: float
    shown: int
    total: int
    missing: str = ""


@dataclass(frozen=True, slots=True)
class Scene:
    """The whole picture."""

    clouds: tuple[Cloud, ...] = ()

    @property
    def shown(self) -> int:
        """Points that are drawn when the view rests."""
        return sum(cloud.shown for cloud in self.clouds)

    @property
    def total(self) -> int:
        """Points that the scans hold."""
        return sum(cloud.total for cloud in self.clouds)


def resolve(project: Project, view: ViewState) -> Scene:
    """Work out the picture. Computes no field: what is not there yet is drawn plain."""
    return Scene(
        tuple(
            _resolve_cloud(project, view, key)
            for key, scan in project.state.scans.items()
            if not scan.closed and key not in view.hidden
        )
    )


def differences(old: Scene, new: Scene) -> dict[str, frozenset[Part]]:
    """What has to be brought to the screen, by scan; scans that went are not listed."""
    before = {cloud.scan: cloud for cloud in old.clouds}
    everything: frozenset[Part] = frozenset(
        ("points", "mask", "colour", "range", "overlay", "style")
    )
    found: dict[str, frozenset[Part]] = {}
    for cloud in new.clouds:
        parts = everything if cloud.scan not in before else _compare(before[cloud.scan], cloud)
        if parts:
            found[cloud.scan] = parts
    return found


def _compare(old: Cloud, new: Cloud) -> frozenset[Part]:
    pairs: tuple[tuple[Part, object, object], ...] = (
        ("points", old.points, new.points),
        ("mask", old.mask, new.mask),
        ("colour", old.colour, new.colour),
        ("range", old.bar, new.bar),
        ("overlay", old.overlay, new.overlay),
        ("style", old.point_size, new.point_size),
    )
    return frozenset(part for part, before, after in pairs if before != after)


def _resolve_cloud(project: Project, view: ViewState, key: str) -> Cloud:
    state = project.state.scan(key)
    catalogue = project.catalogue(key)
    values = project.known_field(key, view.colour) if view.colour in catalogue else None
    bar = _resolve_bar(project, view, key, values) if values is not None else None
    return Cloud(
        scan=key,
        points=Same(state.scan.xyz),
        mask=Same(state.deleted),
        colour=Same(values) if values is not None else None,
        bar=bar,
        overlay=_overlay(project, view, key),
        point_size=view.point_size,
        shown=state.shown,
        total=len(state.scan),
        missing=view.colour if view.colour and values is None else "",
    )


def _overlay(project: Project, view: ViewState, key: str) -> tuple[object, ...]:
    state = project.state.scan(key)
    leaves = (
        tuple((leaf.key, Same(leaf.members)) for leaf in project.state.leaves_of(key))
        if view.show_leaves
        else ()
    )
    previews = tuple((p.leaf, Same(p.members)) for p in view.previewed if p.scan == key)
    ghosts = Same(state.marks) if view.show_ghosts else None
    return (Same(state.selection), leaves, previews, ghosts, view.leaf)


def _resolve_bar(project: Project, view: ViewState, key: str, values: Values) -> ColourBar:
    spec = project.catalogue(key)[view.colour]
    chosen = view.ranges.get(view.colour)
    low, high = (chosen.low, chosen.high) if chosen else default_limits(_sample(values), spec.kind)
    name = view.maps.get(view.colour, DEFAULT_MAPS[spec.kind])
    return ColourBar(spec.name, spec.title, spec.unit, spec.kind, name, low, high)


def _sample(values: Values) -> Floats:
    # Every n-th value is enough for limits, and keeps large scans from stalling the window.
    step = max(1, len(values.values) // SAMPLE)
    return values.values[::step][values.have[::step]]


def default_limits(values: Floats, kind: FieldKind) -> tuple[float, float]:
    """Limits that show the data: fixed for angles and answers, else the middle 98 %."""
    if kind == "angle":
        return 0.0, 90.0
    if kind in ("score", "flag"):
        return 0.0, 1.0
    if kind == "verdict":
        return 0.0, 2.0
    if kind == "mark":
        return 0.0, float(len(WORDS) - 1)
    if kind == "correction":
        return 0.0, float(len(CORRECTION_WORDS) - 1)
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return 0.0, 1.0
    if kind in ("signed angle", "signed"):
        # Zero lies in the middle of the colours.
        least = 1.0 if kind == "signed angle" else 0.0
        reach = max(float(np.quantile(np.abs(finite), 0.98)), least) or 1.0
        return -reach, reach
    within = (0.0, 1.0) if kind == "class" else (0.01, 0.99)
    low, high = (float(q) for q in np.quantile(finite, within))
    return (low, high) if high > low else (low - 0.5, low + 0.5)
