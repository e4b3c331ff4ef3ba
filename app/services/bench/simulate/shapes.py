"""Crossings and normals of curved leaves, against a root finder and finite differences."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import LEAF, THIN, send, silent
from app.simulate.beam import grid_of_field
from app.simulate.surfaces import Leaf

GROUP = "leaf shapes"
CENTRE = (2.0, 0.01, -0.02)
SAMPLES = 4001
STEP = 1e-6
SHAPES: dict[str, dict[str, float | tuple[float, float]]] = {
    "flat": {},
    "bent": {"curvature": 12.0, "bend_direction": 0.4},
    "bent away": {"curvature": -9.0, "bend_direction": 1.2},
    "wrinkled": {
        "curvature": 3.0,
        "wrinkle_height": 0.002,
        "wrinkle_lengths": (0.025, 0.035),
        "wrinkle_phases": (0.3, 1.0),
    },
    "wrinkled in short waves": {
        "wrinkle_height": 0.0015,
        "wrinkle_lengths": (0.012, 10.0),
        "wrinkle_phases": (0.5, 1.57),
    },
}
NORMALS = {"face-on": (-1.0, 0.2, 0.1), "grazing": (-0.25, 1.0, 0.1)}


def check_shapes(quick: bool) -> list[Check]:
    """Each shape face-on and grazing."""
    step = 0.3 if quick else 0.05
    found: list[Check] = []
    for shape, numbers in SHAPES.items():
        for attitude, normal in NORMALS.items():
            leaf = Leaf(CENTRE, (0, 0.3, 1), normal, 0.09, 0.06, LEAF, 0.3, **numbers)  # type: ignore[arg-type]
            found += _check_leaf(f"{shape} leaf, {attitude}:", leaf, step)
    return found


def _check_leaf(what: str, leaf: Leaf, step_deg: float) -> list[Check]:
    grid = grid_of_field(step_deg, (-2.0, 2.6), (-2.2, 1.2))
    echo = send([leaf], silent(bundle=THIN), grid)
    beams = grid.directions.reshape(-1, 3)
    surface = LocalSurface(leaf)
    expected = np.array([surface.cross(beam) for beam in beams])
    found = np.full(len(beams), np.inf)
    found[echo.cell] = echo.distance
    met = np.isfinite(expected) & np.isfinite(found)
    # A beam through the very rim may be in by one sum and out by the other.
    missed = (np.isfinite(expected) != np.isfinite(found)).sum()
    normal = np.full((len(beams), 3), np.nan)
    normal[echo.cell] = echo.normal
    wanted = surface.normals(beams[met], expected[met])
    turned = np.rad2deg(np.linalg.norm(np.cross(wanted, normal[met]), axis=1))
    return [
        compare(GROUP, f"{what} beams that meet it in one way only", 0, missed, 0, "beams"),
        compare(GROUP, f"{what} first crossing", expected[met], found[met], 1e-7, "m"),
        compare(GROUP, f"{what} normal", np.zeros(met.sum()), turned, 1e-3, "°"),
    ]


@dataclass(frozen=True)
class LocalSurface:
    """A leaf as its docstring tells it, in plain numpy."""

    leaf: Leaf

    def height(self, x: Floats, y: Floats) -> Floats:
        """Height over the leaf's plane."""
        leaf = self.leaf
        s = x * np.cos(leaf.bend_direction) + y * np.sin(leaf.bend_direction)
        c = leaf.curvature
        bend = (1 - np.sqrt(np.maximum(1 - (c * s) ** 2, 0.0))) / c if c else 0 * s
        (along, across), (first, second) = leaf.wrinkle_lengths, leaf.wrinkle_phases
        wave = np.sin(2 * np.pi * x / along + first) * np.sin(2 * np.pi * y / across + second)
        return np.asarray(bend + leaf.wrinkle_height * wave)

    def inside(self, x: Floats, y: Floats) -> Bools:
        """Within the outline."""
        s = 2 * x / self.leaf.length
        half = self.leaf.width / 2 * (1 - self.leaf.taper * s)
        return np.asarray((np.abs(s) < 1) & (np.abs(y) <= half * np.sqrt(np.maximum(1 - s * s, 0))))

    def cross(self, beam: Floats) -> float:
        """Distance of the first crossing of a beam from the origin; inf without one."""
        from scipy.optimize import brentq

        frame = self.leaf.frame()
        start, direction = frame @ -np.array(self.leaf.centre), frame @ beam

        def above(away: Floats) -> Floats:
            x, y, z = start[:, None] + direction[:, None] * np.atleast_1d(away)
            return np.asarray(z - self.height(x, y))

        middle = float(np.array(self.leaf.centre) @ beam)
        away = np.linspace(middle - 0.08, middle + 0.08, SAMPLES)
        over = above(away)
        for k in np.flatnonzero(np.sign(over[1:]) != np.sign(over[:-1])):
            root = brentq(lambda t: above(t)[0], away[k], away[k + 1], xtol=1e-12)
            x, y, _ = start + direction * root
            if self.inside(np.array(x), np.array(y)):
                return float(root)
        return np.inf

    def normals(self, beams: Floats, away: Floats) -> Floats:
        """Unit normals by central differences, facing the origin."""
        frame = self.leaf.frame()
        x, y, _ = frame @ (beams * away[:, None] - np.array(self.leaf.centre)).T
        slope_x = (self.height(x + STEP, y) - self.height(x - STEP, y)) / (2 * STEP)
        slope_y = (self.height(x, y + STEP) - self.height(x, y - STEP)) / (2 * STEP)
        local = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=1)
        normal = local / np.linalg.norm(local, axis=1)[:, None] @ frame
        return np.asarray(normal * -np.sign((normal * beams).sum(axis=1))[:, None])
