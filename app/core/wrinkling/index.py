"""How wrinkled a leaf is: tilt of its parts beyond noise and beyond a smooth bend.

A wrinkle tilts a part of the leaf by a small angle, which changes cos ω by that angle times
sin ω. So, with c = cos ω_I at each point,

1. a polynomial of the third degree over the leaf's plane is fitted to c: the plane, a bend, a
   twist and a curl (a cylinder bent by ±35° leaves less than 0.4°);
2. what is left, r, has the variance σ_c² + τ² sin²ω where τ is the wanted spread of tilts;
3. the median of r² / (σ_c² + τ² sin²ω) is that of a squared normal deviate, 0.4549, where
   τ² = median((r² / 0.4549 − σ_c²) / sin²ω), and 0 where that is negative.

The median keeps a few borders and ghosts from counting, the subtraction keeps noise from
counting. τ is the wrinkle index. A plane wave of amplitude A (in tilt) has an index of about A.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput

MEDIAN_OF_SQUARE = 0.454936423119572
DEGREES = ((3, 40), (2, 20), (1, 8))
"""Degree of the polynomial, and blocks of footprint size that it needs."""
LEAST_POINTS = 30
LEAST_TILT = float(np.sin(np.deg2rad(3.0)))
ROUNDS, HUBER, SMALLEST = 8, 1.345, 1e-15
TRIALS = 400
LEVEL = 0.95


@dataclass(frozen=True, slots=True)
class WrinkleIndex:
    """Spread of the tilts of a leaf's parts, radians.

    Attributes
    ----------
    value : float
    low, high : float
        95 % interval, from blocks of footprint size drawn with replacement.
    degree : int
        Of the polynomial that was taken for the leaf's shape.
    blocks, points : int
    """

    value: float
    low: float
    high: float
    degree: int
    blocks: int
    points: int


def find_index(
    omega: Floats,
    noise: Floats,
    flat: Floats,
    footprint: float,
    seed: int = 0,
    trials: int = TRIALS,
) -> WrinkleIndex:
    """The wrinkle index of one leaf.

    Parameters
    ----------
    omega : (n,) radians
        Angles from intensity of valid points; NaN is left out.
    noise : (n,) radians
        Their errors that differ from point to point (`PointAngles.parts['noise']`).
    flat : (n, 2) metres
        Places of the points in the leaf's plane.
    footprint : float
        Size of a block, metres: what lies closer is one measurement.
    seed : int
        Of the draws.
    trials : int

    Raises
    ------
    BadInput
        Fewer than thirty points, or than eight blocks.
    """
    known = np.isfinite(omega) & np.isfinite(noise) & np.isfinite(flat).all(axis=1)
    omega, noise, flat = omega[known], noise[known], flat[known]
    if len(omega) < LEAST_POINTS:
        raise BadInput(
            f"A wrinkle index needs {LEAST_POINTS} points with a valid angle; the leaf has "
            f"{len(omega)}.",
            "Scan it from nearer, or with a finer step.",
        )
    block = _number_blocks(flat, footprint)
    blocks = int(block.max()) + 1
    degree = next((degree for degree, least in DEGREES if blocks >= least), 0)
    if degree == 0:
        raise BadInput(
            f"A wrinkle index needs {DEGREES[-1][1]} footprints beside one another; the leaf has "
            f"{blocks}.",
            "Scan it from nearer.",
        )
    excess = _find_excess(omega, noise, flat, degree, blocks)
    value, trial = _take_medians(excess, block, blocks, seed, trials)
    tail = 50.0 * (1.0 - LEVEL)
    low, high = np.percentile(trial, [tail, 100.0 - tail]) if trials else (np.nan, np.nan)
    return WrinkleIndex(value, float(low), float(high), degree, blocks, len(omega))


def _number_blocks(flat: Floats, footprint: float) -> Ints:
    if not footprint > 0.0:
        raise BadInput("Blocks of a leaf have a size above 0 m.", "Give the beam of the scanner.")
    cell = np.floor((flat - flat.min(axis=0)) / footprint).astype(np.int64)
    _, block = np.unique(cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1], return_inverse=True)
    return np.asarray(block, np.int64)


def fit_bend(cosine: Floats, flat: Floats, degree: int) -> Floats:
    """The smooth shape of a leaf in cos ω: a polynomial fitted against outliers (Huber)."""
    place = flat - flat.mean(axis=0)
    size = np.abs(place).max(axis=0)
    u, v = (place / np.where(size > 0.0, size, 1.0)).T
    columns = np.stack(
        [u**i * v**j for i in range(degree + 1) for j in range(degree + 1 - i)], axis=1
    )
    weight = np.ones(len(u))
    fitted = np.zeros(len(u))
    for _ in range(ROUNDS):
        weighted = columns * weight[:, None]
        # Ten columns of numbers within ±1: their normal equations are good to 1e-10.
        factors = np.linalg.pinv(weighted.T @ columns) @ (weighted.T @ cosine)
        fitted = columns @ factors
        rest = np.abs(cosine - fitted)
        scale = float(np.median(rest)) / np.sqrt(MEDIAN_OF_SQUARE)
        if scale <= SMALLEST:
            break
        weight = np.minimum(1.0, HUBER * scale / np.maximum(rest, SMALLEST))
    return np.asarray(fitted, np.float64)


def _find_excess(omega: Floats, noise: Floats, flat: Floats, degree: int, blocks: int) -> Floats:
    """τ² that each point alone would speak for; half of them are larger than the index'."""
    cosine, sine = np.cos(omega), np.sin(omega)
    sigma = noise * sine
    fitted = fit_bend(cosine, flat, degree)
    terms = (degree + 1) * (degree + 2) // 2
    spare = blocks / max(blocks - terms, 1)
    tilt = np.maximum(np.sqrt(np.maximum(1.0 - np.clip(fitted, -1.0, 1.0) ** 2, 0.0)), LEAST_TILT)
    rest = (cosine - fitted) ** 2 * spare
    return np.asarray((rest / MEDIAN_OF_SQUARE - sigma**2) / tilt**2, np.float64)


def _take_medians(
    excess: Floats, block: Ints, blocks: int, seed: int, trials: int
) -> tuple[float, Floats]:
    """The index, and those of draws of whole blocks: medians in which a block counts often."""
    order = np.argsort(excess, kind="stable")
    ranked, whose = excess[order], block[order]
    random = np.random.default_rng(seed)
    places = np.empty(trials, np.int64)
    for trial in range(trials):
        drawn = np.bincount(random.integers(0, blocks, blocks), minlength=blocks)
        running = np.cumsum(drawn[whose])
        places[trial] = np.searchsorted(running, 0.5 * running[-1])
    trial_values = np.sqrt(np.maximum(ranked[np.minimum(places, len(ranked) - 1)], 0.0))
    return float(np.sqrt(max(np.median(excess), 0.0))), trial_values
