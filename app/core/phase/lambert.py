"""Lambert: a perfectly diffuse surface."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.model import Columns, Parameter, PhaseModel


class Lambert(PhaseModel):
    """I = f·cos ω."""

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Column cos ω."""
        return (np.cos(angle),)

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Column −sin ω."""
        return (-np.sin(angle),)


MODEL = Lambert(
    name="lambert",
    title="Lambert",
    formula="I = f·cos ω",
    source="Lambert's cosine law; the diffuse part of Kaasalainen et al. 2018, section 2.1",
    parameters=(
        Parameter("f", "value", "value at face-on incidence", (0.1, 1.5), lower=0.0, scales=True),
    ),
    extrapolates=True,
)
