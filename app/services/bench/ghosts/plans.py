"""What is scanned: leaves before walls, crowns, and scans in which no point is a ghost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from app.services.bench.ghosts.truth import Group

NOISE = 0.0007
"""Metres, in the scene that the issue's figures of peers come from."""


@dataclass(frozen=True, slots=True)
class Plan:
    """How a scene is made: its parts and field of view, the instrument and the step."""

    name: str
    group: Group
    instrument: str
    step: float
    document: dict[str, Any]
    noise: float | None = None
    quick_step: float = 0.06
    slow: bool = False


def _field(side: float, rise: float) -> dict[str, Any]:
    return {"azimuth_deg": [-side, side], "elevation_deg": [-rise, rise]}


def _scatter(
    count: int, ranges: tuple[float, float], side: float, rise: float, steepest: float = 88.0
) -> dict[str, Any]:
    """Leaves as large, and as steep, as those of the other simulator's scenes."""
    return {
        "kind": "scatter", "count": count, "ranges": ranges, "steepest_deg": steepest,
        "azimuth_deg": [-side, side], "elevation_deg": [-rise, rise],
        "leaves": {"length": [0.055, 0.085], "width": [0.03, 0.06]},
    }  # fmt: skip


def _wall(away: float) -> dict[str, Any]:
    return {"kind": "wall", "range": away, "width": 12, "height": 12}


def _crown(away: float, radius: float, count: int) -> dict[str, Any]:
    """A crown whose middle stands a little above the scanner."""
    return {
        "kind": "crown", "centre": [away, 0, 1.6 + 0.6 * radius], "radius": radius,
        "half_height": 1.1 * radius, "trunk": 0.9 * radius, "count": count,
    }  # fmt: skip


def _ground(away: float) -> dict[str, Any]:
    return {"kind": "wall", "centre": [away, 0, 0], "width": 16, "height": 16, "level": True}


_WIDE = {"field": _field(14.5, 11.2), "part": [_scatter(250, (1.6, 4.5), 14, 10.7), _wall(6.0)]}
_DENSE = {"field": _field(8.5, 6.5), "part": [_scatter(250, (1.8, 4.2), 8, 6, 70), _wall(5.5)]}
_CLOSE = {"field": _field(7.5, 5.8), "part": [_scatter(90, (2.2, 2.42), 7.2, 5.5), _wall(2.6)]}
_CLOSER = {"field": _field(8.5, 6.5), "part": [_scatter(60, (3.0, 3.15), 8, 6), _wall(3.24)]}
_SMALL = {"part": [_crown(4.0, 0.6, 700), _ground(4.0)]}
_LARGE = {"part": [_crown(10.0, 2.0, 10_000), _ground(10.0)]}
_WALLED = {"part": [_crown(3.0, 0.5, 450), _wall(4.5)]}
_SINGLE = {"part": [{"kind": "leaf", "tilt_deg": 55, "curvature": 9, "wrinkle_height": 0.001}]}
_ROW = {"part": [{"kind": "leaf_row", "tilts_deg": [0, 15, 30, 45, 60, 75], "spacing": 0.1}]}

PLANS = (
    # What the figures of peers come from: 2 million points, 250 leaves, one channel in DN.
    Plan("leaves before a wall", "phase shift", "ls880", 0.018, _WIDE, NOISE),
    Plan("dense leaves, fine step", "phase shift", "two_colour", 0.012, _DENSE, None, 0.04),
    Plan("dense leaves, coarse step", "phase shift", "two_colour", 0.036, _DENSE),
    Plan("crown before a wall, 3 m", "crown", "two_colour", 0.018, _WALLED),
    Plan("crown, 4 m", "crown", "two_colour", 0.018, _SMALL),
    Plan("crown, 10 m", "crown", "two_colour", 0.018, _LARGE, slow=True),
    Plan("pulsed, close", "pulsed, close", "pulsed", 0.018, _CLOSE),
    Plan("pulsed, closer", "pulsed, close", "pulsed", 0.018, _CLOSER),
    Plan("pulsed leaves, apart", "pulsed, apart", "pulsed", 0.018, _DENSE),
    Plan("pulsed crown, 4 m", "pulsed, apart", "pulsed", 0.018, _SMALL),
    Plan("one leaf", "clean", "two_colour", 0.018, _SINGLE),
    Plan("six leaves side by side", "clean", "two_colour", 0.018, _ROW),
)
