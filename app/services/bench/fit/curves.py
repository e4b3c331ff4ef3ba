"""Lambert–Beckmann as anybody would hand it to SciPy, and curves to fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase import MODELS
from app.core.units import to_radians

BECKMANN = MODELS["lambert-beckmann"]
NAMES = tuple(p.name for p in BECKMANN.parameters)
STEPS = np.asarray(to_radians(np.arange(0.0, 81.0, 5.0)))
"""The 17 angles of the papers."""
BOUNDS = ((0.0, 0.0, 1e-3), (np.inf, 1.0, 1.0))
START = (1.0, 0.5, 0.3)
"""What one would guess: f about the largest value, the others in the middle of the printed ones."""


def draw_curve(angle: Floats, f: float, k_d: float, m: float) -> Floats:
    """The plain formula, without anything of ours."""
    t = np.tan(angle) ** 2
    beckmann = np.exp(2.5 * np.log1p(t) - t / m**2)
    return np.asarray(f * (k_d * np.cos(angle) + (1 - k_d) * beckmann))


def fit_with_scipy(
    angle: Floats, value: Floats, start: Sequence[float] = START
) -> tuple[Any, float]:
    """Parameters and rss of `scipy.optimize.curve_fit` with bounds, from one start.

    The values are divided by the largest first, as its tolerances need. NaN and infinity where
    it gives up.
    """
    from scipy.optimize import curve_fit

    scale = float(np.abs(value).max()) or 1.0
    try:
        found, _ = curve_fit(draw_curve, angle, value / scale, p0=start, bounds=BOUNDS)
    except RuntimeError:
        return np.full(3, np.nan), np.inf
    rss = float(((value / scale - draw_curve(angle, *found)) ** 2).sum()) * scale**2
    return found * np.array([scale, 1.0, 1.0]), rss


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """Noisy curves on shared angles.

    Attributes
    ----------
    true : (g, 3) array
        f, k_d and m.
    value : (g, n) array
    """

    true: Floats
    value: Floats


def make_curves(count: int, seed: int = 0, noise: float = 0.06, angle: Floats = STEPS) -> Curves:
    """Leaves as in the papers, a tenth of them without gloss; noise in shares of the value."""
    rng = np.random.default_rng(seed)
    k_d = np.where(rng.random(count) < 0.1, 1.0, rng.uniform(0.2, 0.99, count))
    true = np.column_stack((10.0 ** rng.uniform(-1, 3, count), k_d, rng.uniform(0.1, 0.6, count)))
    curves = np.array([draw_curve(angle, *row) for row in true])
    return Curves(true, curves * (1 + noise * rng.standard_normal(curves.shape)))
