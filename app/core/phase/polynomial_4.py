"""Polynomial of fourth degree: Balduzzi's I(ω), good only within the fitted angles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.model import Columns, Parameter, PhaseModel
from app.core.units import to_radians

USABLE_TO = float(to_radians(60.0))


class Polynomial4(PhaseModel):
    """I = Σ p_k·ω^k, k = 0 to 4."""

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns ω⁰ to ω⁴."""
        return np.ones(np.shape(angle)), angle, angle**2, angle**3, angle**4

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns 0, 1, 2ω, 3ω², 4ω³."""
        one = np.ones(np.shape(angle))
        return 0 * one, one, 2 * angle, 3 * angle**2, 4 * angle**3

    def remark(
        self,
        values: Mapping[str, float],
        angle: Floats,
        noise: float,
        fixed: Mapping[str, float],
    ) -> tuple[str, ...]:
        """Warns of angles at which the paper found the curve unusable."""
        del values, noise, fixed
        if not angle.max() > USABLE_TO:
            return ()
        return ("Angles beyond 60° are in the fit: the polynomial is unusable beyond 55 to 60°.",)


def _term(k: int) -> Parameter:
    unit = "value" if k == 0 else "value/rad" if k == 1 else f"value/rad^{k}"
    return Parameter(f"p{k}", unit, f"factor of ω^{k}, ω in radians", (-0.5, 0.5), scales=True)


MODEL = Polynomial4(
    name="polynomial-4",
    title="Polynomial, 4th degree",
    formula="I = p0 + p1·ω + p2·ω² + p3·ω³ + p4·ω⁴, ω in radians",
    source="Balduzzi et al. 2011, section 2.3",
    parameters=tuple(_term(k) for k in range(5)),
)
