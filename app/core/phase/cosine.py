"""Cosine of twice the holder angle (Hancock): reflectance or an index of a turned leaf."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import WrongUse
from app.core.phase.model import (
    RIGHT_ANGLE,
    Columns,
    Freedom,
    Parameter,
    PhaseModel,
    Reference,
    pile,
)
from app.core.units import to_degrees, to_radians

# Of the largest value: a swing of this size is rounding and has no direction.
NEGLIGIBLE = 1e-13
CLEAR = 2.5


class Cosine(PhaseModel):
    """y = A·cos(2(θ − μ)) + ν, as p·cos 2θ + q·sin 2θ + ν, so that all of it is linear.

    (A, μ) and (−A, μ + 90°) are the same curve; μ is kept in (−45°, 45°] and A signed.
    """

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns cos 2θ, sin 2θ, 1."""
        return np.cos(2 * angle), np.sin(2 * angle), np.ones(np.shape(angle))

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns −2·sin 2θ, 2·cos 2θ, 0."""
        return -2 * np.sin(2 * angle), 2 * np.cos(2 * angle), np.zeros(np.shape(angle))

    def coefficients(self, values: Mapping[str, Any]) -> Floats:
        """p, q and ν."""
        A = np.asarray(values["A"])
        twice = 2 * to_radians(np.where(A == 0.0, 0.0, values.get("mu", np.nan)))
        return pile([A * np.cos(twice), A * np.sin(twice), values["nu"]])

    def coefficient_slopes(self, values: Mapping[str, Any]) -> Floats:
        """d(p, q, ν) / d(A, μ in degrees, ν)."""
        A, twice = values["A"], 2 * to_radians(values["mu"])
        c, s, turn = np.cos(twice), np.sin(twice), to_radians(2.0)
        rows = ((c, -A * s * turn, 0 * c), (s, A * c * turn, 0 * c), (0 * c, 0 * c, 0 * c + 1))
        return np.stack([pile(row) for row in rows], axis=-2)

    def name_values(
        self, coefficients: Floats, shape: Any, fixed: Mapping[str, Any]
    ) -> dict[str, Any]:
        """A, μ and ν; μ is undetermined without any swing."""
        del shape
        p, q, nu = np.moveaxis(coefficients, -1, 0)
        if "mu" in fixed:
            twice = 2 * to_radians(fixed["mu"])
            swing = {"A": p * np.cos(twice) + q * np.sin(twice), "mu": fixed["mu"]}
        else:
            swing = _fold(p, q)
        return swing | {"nu": nu} | dict(fixed)

    def free(self, fixed: Mapping[str, float]) -> Freedom:
        """A can be fixed only with μ: alone it would tie p and q by a circle."""
        directions, offset = np.eye(3), np.zeros(3)
        if "mu" in fixed:
            twice = 2 * to_radians(fixed["mu"])
            along = np.array([np.cos(twice), np.sin(twice), 0.0])
            directions = np.column_stack((along, directions[:, 2]))
        elif "A" in fixed:
            raise WrongUse("The cosine's A can be fixed only together with mu.", "Fix mu as well.")
        if "A" in fixed:
            offset, directions = offset + fixed["A"] * along, directions[:, 1:]
        if "nu" in fixed:
            offset, directions = offset + np.array([0.0, 0.0, fixed["nu"]]), directions[:, :-1]
        endless = np.full(directions.shape[1], np.inf)
        return Freedom(offset, directions, -endless, endless)

    def accepts(self, angle: Floats) -> Bools:
        """Holder angles from −90° to 90°: they are turned both ways."""
        return np.abs(angle) <= RIGHT_ANGLE

    def remark(
        self,
        values: Mapping[str, float],
        angle: Floats,
        noise: float,
        fixed: Mapping[str, float],
    ) -> tuple[str, ...]:
        """Warns of an amplitude that scatter alone could have made."""
        expected = expect_amplitude(angle, noise) if "mu" not in fixed else 0.0
        if abs(values["A"]) > CLEAR * expected or expected == 0.0:
            return ()
        return (
            f"The scatter of the values alone would give an amplitude of about {expected:.3g}:"
            f" A = {values['A']:.3g} says little.",
        )


def _fold(p: Floats, q: Floats) -> dict[str, Floats]:
    amplitude = np.hypot(p, q)
    mu = to_degrees(np.arctan2(q, p)) / 2
    turned = np.where(mu > 45.0, -90.0, np.where(mu <= -45.0, 90.0, 0.0))
    still = amplitude <= NEGLIGIBLE
    signed = np.where(turned == 0.0, amplitude, -amplitude)
    return {"A": np.where(still, 0.0, signed), "mu": np.where(still, np.nan, mu + turned)}


def expect_amplitude(angle: Floats, noise: float) -> float:
    """Mean amplitude that a fit with free μ finds in pure noise.

    Parameters
    ----------
    angle : (n,) array
        Holder angles, radians.
    noise : float
        Standard deviation of one value.

    Returns
    -------
    float
        Mean length of a normal vector (p, q) with the covariance of the fit (Hoyt
        distribution): √(2/π)·σ₁·E(1 − σ₂²/σ₁²).
    """
    from scipy.special import ellipe

    columns = np.column_stack((np.cos(2 * angle), np.sin(2 * angle)))
    columns -= columns.mean(axis=0)
    strong, weak = np.linalg.svd(columns, compute_uv=False)
    if weak == 0.0:
        return float("inf")
    return float(np.sqrt(2 / np.pi) * noise / weak * ellipe(1 - (weak / strong) ** 2))


_HANCOCK = {
    "eucu1": (0.036, 0.144, 0.201),
    "eucu2": (0.022, 0.215, 0.241),
    "eucu3": (0.013, 0.231, 0.234),
    "euct1": (0.022, 0.025, 0.220),
    "euct2": (-0.005, 0.213, 0.319),
    "euct3": (0.058, 0.067, 0.258),
    "euct4": (0.140, 0.054, 0.245),
    "beuc1": (0.005, 0.322, 0.396),
    "beuc2": (0.024, 0.161, 0.227),
    "beuc3": (0.080, 0.260, 0.412),
    "lily1": (-0.004, 0.096, 0.144),
    "laur1": (0.038, 0.088, 0.375),
}

MODEL = Cosine(
    name="cosine",
    title="Cosine",
    formula="y = A·cos(2(θ − μ)) + ν",
    source="Hancock et al. 2017, equation 2",
    parameters=(
        Parameter("A", "value", "half the swing from 0° to 90°", (-0.5, 0.5), scales=True),
        Parameter("mu", "deg", "angle of the peak", (-44.0, 44.0), -45.0, 45.0, wraps=True),
        Parameter("nu", "value", "value at 45° from the peak", (0.1, 1.0), scales=True),
    ),
    unknown_when={"mu": "A is 0"},
    fixed_with={"A": "mu"},
    references=tuple(
        Reference(f"{leaf}, {y}", {"A": A}, "Hancock 2017, table I")
        for leaf, row in _HANCOCK.items()
        for y, A in zip(("NDI", "1545 nm", "1063 nm"), row, strict=True)
    ),
)
