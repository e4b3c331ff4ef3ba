"""Fourier series of second order: a smooth interpolant without physics."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.model import Columns, Parameter, PhaseModel

SLOWEST, FASTEST = 1.1, 4.5
TRIALS = 171


class Fourier2(PhaseModel):
    """I = a₀ + Σ_{k=1,2} a_k·cos(kwω) + b_k·sin(kwω)."""

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns 1, cos wω, sin wω, cos 2wω, sin 2wω."""
        turn = shape * angle
        one = np.ones(np.shape(turn))
        return one, np.cos(turn), np.sin(turn), np.cos(2 * turn), np.sin(2 * turn)

    def basis_by_shape(self, angle: Floats, shape: Any) -> Columns:
        """Columns by w."""
        return _turn(shape * angle, angle)

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns by ω."""
        return _turn(shape * angle, shape)

    def search(self, angle: Floats) -> Floats:
        """Even steps of w."""
        return np.broadcast_to(np.linspace(SLOWEST, FASTEST, TRIALS), (*angle.shape[:-1], TRIALS))


def _turn(turn: Any, speed: Any) -> Columns:
    return (
        np.zeros(np.shape(turn)),
        -speed * np.sin(turn),
        speed * np.cos(turn),
        -2 * speed * np.sin(2 * turn),
        2 * speed * np.cos(2 * turn),
    )


def _harmonic(name: str, meaning: str) -> Parameter:
    return Parameter(name, "value", meaning, (-0.5, 0.5), scales=True)


MODEL = Fourier2(
    name="fourier-2",
    title="Fourier, 2nd order",
    formula="I = a0 + a1·cos(wω) + b1·sin(wω) + a2·cos(2wω) + b2·sin(2wω), ω in radians",
    source="Kaasalainen et al. 2018; w within about a quarter to one period over 0–80°",
    parameters=(
        _harmonic("a0", "mean level"),
        _harmonic("a1", "cosine of the first harmonic"),
        _harmonic("b1", "sine of the first harmonic"),
        _harmonic("a2", "cosine of the second harmonic"),
        _harmonic("b2", "sine of the second harmonic"),
        Parameter("w", "1", "angular frequency", (SLOWEST, FASTEST), lower=SLOWEST, upper=FASTEST),
    ),
    shape="w",
)
