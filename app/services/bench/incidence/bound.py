"""Errors on a plane beside the smallest that any unbiased estimator can have.

A plane m · P = 1 is seen along the unit vectors u_k of N beams at r_k = 1 / (m · u_k), with
∂r_k / ∂m = −r_k² u_k. For white noise of σ_r along the beams the Fisher information of m is

    J = σ_r⁻² Σ r_k⁴ u_k u_kᵀ

(Gaussian with mean r(m): Kay 1993, Fundamentals of Statistical Signal Processing: Estimation
Theory, section 3.9), and the variance of ω(m) is at least ∇ωᵀ J⁻¹ ∇ω (the same, section 3.8).
With c = m · u and g = |m − c u| at the beam u of the point, ω = atan2(g, c), and so
∇ω = (c e − g u) / (c² + g²), e = (m − c u) / g. In a small window this is the variance of the
slopes of a regression of 1 / r, σ_r² / (r⁴ N var(angle)), times cos⁴ω r² (for e along an axis).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.incidence import RADIUS, Estimator, incidence_angle, local_planes
from app.core.units import to_mm
from app.services.bench.incidence.scenes import STRONG, USUAL, Noise, Truth, make_plane
from app.services.bench.incidence.windows import half_windows, integrate, sum_windows
from app.services.bench.results import ResultTable, Value

MIDDLES = (20.0, 35.0, 50.0, 65.0, 75.0)
"""Degrees at which the planes are met in their middles."""
LEAST, MOST = 15.0, 80.0
SIDE, QUICK_SIDE = 400, 120
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
LIMITS: dict[Estimator, float] = {"window": 1.03, "adaptive": 1.15}
NOTE = (
    "rms of error / bound over all points with a whole window, true ω 15 to 80°; the bound is that "
    "of the very window that was used. Known cells: the reported number of cells is the window's."
)


@dataclass(frozen=True, slots=True, eq=False)
class Against:
    """Errors over bounds of one estimator under one noise, plane by plane."""

    estimator: Estimator
    noise: Noise
    ratios: dict[float, Floats]
    known: float

    @property
    def whole(self) -> float:
        """Root mean square over all planes."""
        return rms(np.concatenate(list(self.ratios.values())))


def rms(values: Floats) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def bound_of_windows(truth: Truth, sigma: float, width: Floats, count: Floats) -> Floats:
    """Smallest σ of ω for each point's window, (n,) radians; NaN where it is not whole.

    Parameters
    ----------
    truth : Truth
        A plane, `truth.xyz` without noise.
    sigma : float
        Metres, of the range.
    width : (n,) metres
        Half-widths used.
    count : (n,)
        Cells used; a window of another number of cells is not what was used.
    """
    away = np.linalg.norm(truth.xyz - truth.scanner, axis=1)
    beams = (truth.xyz - truth.scanner) / away[:, None]
    image = np.zeros((truth.grid.rows, truth.grid.columns, len(PAIRS) + 1))
    products = [away**4 * beams[:, a] * beams[:, b] for a, b in PAIRS]
    image[truth.grid.row, truth.grid.column] = np.stack([*products, np.ones(len(away))], axis=1)
    high, wide = half_windows(truth, width)
    sums = sum_windows(integrate(image), truth, high, wide)
    whole = (sums[:, -1] == (2 * high + 1) * (2 * wide + 1)) & (sums[:, -1] == count)
    information = np.empty((int(whole.sum()), 3, 3))
    for k, (a, b) in enumerate(PAIRS):
        information[:, a, b] = information[:, b, a] = sums[whole, k] / sigma**2
    gradient = turn_of_plane(beams, away)[whole]
    variance = np.einsum("ni,nij,nj->n", gradient, np.linalg.inv(information), gradient)
    bound = np.full(len(away), np.nan)
    bound[whole] = np.sqrt(variance)
    return bound


def turn_of_plane(beams: Floats, away: Floats) -> Floats:
    """∇ω by m at each point, (n, 3); m by least squares through the noise-free points."""
    plane = np.linalg.lstsq(beams, 1.0 / away, rcond=None)[0]
    along = beams @ plane
    across = plane - along[:, None] * beams
    steep = np.linalg.norm(across, axis=1)
    turned = along[:, None] * across / steep[:, None] - steep[:, None] * beams
    return np.asarray(turned / (along**2 + steep**2)[:, None])


def _within(truth: Truth) -> Bools:
    return np.asarray((truth.omega >= LEAST) & (truth.omega <= MOST))


def measure_against(
    estimator: Estimator, noise: Noise, quick: bool = False, radius: float = RADIUS
) -> Against:
    """Errors over bounds on planes at all angles."""
    ratios: dict[float, Floats] = {}
    known = []
    for seed, middle in enumerate(MIDDLES):
        truth = make_plane(middle, QUICK_SIDE if quick else SIDE)
        xyz = truth.add_noise(noise, seed)
        planes = local_planes(
            xyz, truth.scanner, radius=radius, grid=truth.grid, estimator=estimator
        )
        error = incidence_angle(xyz, planes.normals, truth.scanner) - np.deg2rad(truth.omega)
        width, count = planes.width.astype(np.float64), planes.count.astype(np.float64)
        bound = bound_of_windows(truth, noise.sigma, width, count)
        chosen = _within(truth) & np.isfinite(bound)
        known.append(chosen.sum() / max(int(_within(truth).sum()), 1))
        off = np.where(np.isnan(error), np.pi / 2, error)
        ratios[middle] = off[chosen] / bound[chosen]
    return Against(estimator, noise, ratios, float(np.mean(known)))


def measure_bound(quick: bool = False) -> tuple[list[Against], ResultTable]:
    """Both estimators under both white noises, and their table."""
    noises = (USUAL,) if quick else (USUAL, STRONG)
    found = [measure_against(name, noise, quick) for name in LIMITS for noise in noises]
    rows = [row for against in found for row in _tell(against)]
    return found, ResultTable("incidence_bound", "Errors over the Cramér-Rao bound", rows, NOTE)


def _tell(against: Against) -> list[dict[str, Value]]:
    parts = [(f"{middle:g}°", ratio) for middle, ratio in against.ratios.items()]
    parts.append(("15 to 80°", np.concatenate(list(against.ratios.values()))))
    return [
        {
            "method": against.estimator,
            "sigma_mm": round(to_mm(against.noise.sigma), 3),
            "plane at": name,
            "points": len(ratio),
            "known cells": round(against.known, 3),
            "rms error / bound": round(rms(ratio), 4),
            "median error / median of a normal error at the bound": round(
                float(np.median(np.abs(ratio))) / 0.67449, 4
            ) if len(ratio) else float("nan"),
            "limit": LIMITS[against.estimator],
        }
        for name, ratio in parts
    ]  # fmt: skip
