"""The four ways to an angle that must all be stable, and how far two answers lie apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.incidence import RADIUS, Estimator, incidence_angle, local_planes
from app.core.units import to_degrees
from app.services.bench.stability.patches import Patch


@dataclass(frozen=True, slots=True)
class Way:
    """An estimator, with the scan grid or without."""

    name: str
    estimator: Estimator
    grid: bool

    def angles(self, patch: Patch, radius: float = RADIUS, points: Ints | None = None) -> Floats:
        """Angles of incidence, degrees; NaN where there is none, 180 where it faces away."""
        planes = local_planes(
            patch.xyz, patch.scanner, points, radius, patch.grid if self.grid else None,
            estimator=self.estimator,
        )  # fmt: skip
        xyz = patch.xyz if points is None else patch.xyz[points]
        omega: Floats = to_degrees(incidence_angle(xyz, planes.normals, patch.scanner))
        with np.errstate(invalid="ignore"):
            along = ((xyz - patch.scanner) * planes.normals).sum(axis=1)
            omega[along > 1e-9 * np.linalg.norm(xyz - patch.scanner, axis=1)] = 180.0
        return omega


WAYS = (
    Way("adaptive", "adaptive", True),
    Way("robust", "robust", True),
    Way("window", "window", True),
    Way("ball on the grid", "ball", True),
    Way("ball in voxels", "ball", False),
)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Largest deviation, degrees, and how many angles were compared."""

    worst: float
    compared: int


@dataclass(frozen=True, slots=True)
class Case:
    """Something that must not change an angle, or must not give a wrong one.

    Attributes
    ----------
    group, name : str
    limit : float
        Degrees.
    run : callable
        (way, side of the scan in cells) → `Outcome`
    """

    group: str
    name: str
    limit: float
    run: Callable[[Way, int], Outcome]


def compare(found: Floats, expected: Floats, most: float = 1.0) -> Outcome:
    """Largest difference; infinite where an angle is missing in one of the two only.

    Parameters
    ----------
    found, expected : (n,) degrees
    most : float
        Share of the angles that is looked at, those that differ least.
    """
    both = np.isfinite(found) & np.isfinite(expected)
    if (np.isfinite(found) != np.isfinite(expected)).any() or not both.any():
        return Outcome(np.inf, len(found))
    return Outcome(float(np.quantile(np.abs(found - expected)[both], most)), int(both.sum()))


def compare_known(found: Floats, expected: Floats) -> Outcome:
    """Largest difference where an angle was found; a missing one is no mistake here."""
    known = np.isfinite(found)
    return Outcome(float(np.abs(found - expected)[known].max(initial=0.0)), len(found))


def expect_none(found: Floats) -> Outcome:
    """No angle at all is right; any other is wrong by 90°."""
    return Outcome(90.0 if np.isfinite(found).any() else 0.0, len(found))
