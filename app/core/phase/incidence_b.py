"""Incidence correction with one factor b (Junttila)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.model import (
    RIGHT_ANGLE,
    Columns,
    Freedom,
    Parameter,
    PhaseModel,
    Reference,
    pile,
)
from app.core.units import to_degrees

LEAST_BRACKET = 0.25
SOURCE = "Junttila et al. 2016, equation 6"


class IncidenceB(PhaseModel):
    """I = a·(1 − b·(1 − cos ω)), as a·1 + a·b·(cos ω − 1)."""

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns 1, cos ω − 1."""
        return np.ones(np.shape(angle)), np.cos(angle) - 1.0

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns 0, −sin ω."""
        return np.zeros(np.shape(angle)), -np.sin(angle)

    def coefficients(self, values: Mapping[str, Any]) -> Floats:
        """A and a·b; without any a there is no b, and no product either."""
        a = np.asarray(values["a"])
        b = np.where(a == 0.0, 0.0, values.get("b", np.nan))
        return pile([a, a * b])

    def coefficient_slopes(self, values: Mapping[str, Any]) -> Floats:
        """d(a, a·b) / d(a, b)."""
        a, b = np.asarray(values["a"]), np.asarray(values["b"])
        return np.stack([pile([0 * a + 1, 0 * a]), pile([b, a])], axis=-2)

    def name_values(
        self, coefficients: Floats, shape: Any, fixed: Mapping[str, Any]
    ) -> dict[str, Any]:
        """A and b; without any a there is no b."""
        del shape
        a, product = np.moveaxis(coefficients, -1, 0)
        with np.errstate(all="ignore"):
            b = product / a
        return {"a": a, "b": np.where(np.isfinite(b), b, np.nan)} | dict(fixed)

    def free(self, fixed: Mapping[str, float]) -> Freedom:
        """Either parameter can be fixed, or both."""
        a, b = fixed.get("a"), fixed.get("b")
        if a is not None and b is not None:
            offset, directions = (a, a * b), np.empty((2, 0))
        elif a is not None:
            offset, directions = (a, 0.0), np.array([[0.0], [1.0]])
        elif b is not None:
            offset, directions = (0.0, 0.0), np.array([[1.0], [b]])
        else:
            offset, directions = (0.0, 0.0), np.eye(2)
        endless = np.full(directions.shape[1], np.inf)
        return Freedom(np.array(offset), directions, -endless, endless)

    def reach(self, values: Mapping[str, float]) -> float:
        """Angle at which the bracket has fallen to 0.25."""
        return find_reach(values["b"])

    def remark(
        self,
        values: Mapping[str, float],
        angle: Floats,
        noise: float,
        fixed: Mapping[str, float],
    ) -> tuple[str, ...]:
        """Warns where the correction would explode within the fitted angles."""
        del noise, fixed
        limit = find_reach(values["b"])
        if not angle.max() > limit:
            return ()
        return (
            f"Beyond {to_degrees(limit):.1f}° the bracket 1 − b(1 − cos ω) is below"
            f" {LEAST_BRACKET}: points there are marked, not corrected.",
        )


def find_reach(b: float, least_bracket: float = LEAST_BRACKET) -> float:
    """Angle, radians, at which 1 − b(1 − cos ω) has fallen to `least_bracket`; at most 90°."""
    drop = 1.0 - least_bracket
    return float(np.arccos(1.0 - drop / b)) if b > drop else RIGHT_ANGLE


def _cite(sample: str, b: float) -> Reference:
    return Reference(sample, {"b": b}, SOURCE)


MODEL = IncidenceB(
    name="incidence-b",
    title="Incidence correction",
    formula="I = a·(1 − b·(1 − cos ω))",
    source=SOURCE,
    parameters=(
        Parameter("a", "value", "value at face-on incidence", (0.1, 1.5), scales=True),
        Parameter("b", "1", "1 is Lambertian, less is flatter, more is steeper", (0.1, 2.3)),
    ),
    extrapolates=True,
    unknown_when={"b": "a is 0"},
    references=(
        _cite("lime, FARO 1550 nm", 1.78),
        _cite("birch, FARO 1550 nm", 2.3),
        _cite("maple, FARO 1550 nm", 1.74),
        _cite("spruce, FARO 1550 nm", 0.58),
        _cite("pine, FARO 1550 nm", 0.82),
        _cite("lime, Leica 690 nm", 0.82),
        _cite("birch, Leica 690 nm", 0.71),
        _cite("maple, Leica 690 nm", 0.75),
        _cite("spruce, Leica 690 nm", 0.25),
        _cite("pine, Leica 690 nm", 0.82),
    ),
)
