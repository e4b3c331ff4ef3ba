"""Lommel–Seeliger with a Lambert part: a dark, multiply scattering layer."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.model import Columns, Parameter, PhaseModel


class LommelSeeliger(PhaseModel):
    """S = c·cos ω + d·cos²ω: the general law where light and view are the same beam."""

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns cos ω, cos²ω."""
        cosine = np.cos(angle)
        return cosine, cosine**2

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns −sin ω, −sin 2ω."""
        return -np.sin(angle), -np.sin(2 * angle)


MODEL = LommelSeeliger(
    name="lommel-seeliger",
    title="Lommel–Seeliger + Lambert",
    formula="S = c·cos ω + d·cos²ω",
    source="Junttila et al. 2016, equation 5, with ε = τ = ω",
    parameters=(
        Parameter("c", "value", "weight of the Lommel–Seeliger part", (0.1, 1.0), scales=True),
        Parameter("d", "value", "weight of the Lambert part", (-0.5, 1.0), scales=True),
    ),
    extrapolates=True,
)
