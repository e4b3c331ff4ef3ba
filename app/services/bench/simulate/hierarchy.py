"""The bounding hierarchy finds what the plain loop over all surfaces finds, bit for bit."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import silent
from app.simulate.instrument import get_instrument
from app.simulate.scanner import Echoes, trace_beams
from app.simulate.scene_building import build_scene, lay_grid
from app.simulate.scene_file import get_scene

GROUP = "hierarchy"
STEPS = {"scattered": 0.1, "branch": 0.1, "shoot": 0.05, "pulsed_leaves": 0.15, "crown": 1.0}
"""Ready scenes with steps between beams, degrees, that keep the plain loop short."""


def check_hierarchy(quick: bool) -> list[Check]:
    """Differing numbers in all columns of the echoes, for each scene; quick: not the crown."""
    names = [name for name in STEPS if not (quick and name == "crown")]
    return [_check(name, STEPS[name] * (2 if quick else 1)) for name in names]


def _check(name: str, step_deg: float) -> Check:
    file = get_scene(name)
    pulsed = get_instrument("pulsed").ranging if name == "pulsed_leaves" else None
    tool = silent(pulsed)
    scene = build_scene(file, tool.wavelengths_nm)
    grid = lay_grid(file, scene, step_deg)
    tree, plain = (
        trace_beams(scene, grid, tool, file.position, hierarchy=way) for way in (True, False)
    )
    what = f"{name}, {len(scene.materials())} surfaces: numbers that differ from the plain loop"
    return compare(GROUP, what, 0, count_differences(tree, plain), 0)


def count_differences(one: Echoes, other: Echoes) -> float:
    """Numbers that are not the same, bit for bit; inf where the returns are not as many."""
    if len(one) != len(other):
        return float("inf")
    names = [field.name for field in fields(Echoes) if field.name != "waveforms"]
    return float(sum(_differ(getattr(one, name), getattr(other, name)) for name in names))


def _differ(one: np.ndarray, other: np.ndarray) -> int:
    bits = f"u{one.dtype.itemsize}"
    return int(
        (np.ascontiguousarray(one).view(bits) != np.ascontiguousarray(other).view(bits)).sum()
    )
