"""Phase-shift ranging: one range from the phase of all echoes of a beam together."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse

WAVELENGTHS = (76.8, 9.6, 1.2)
"""Modulation wavelengths, metres, coarse to fine. Each is unambiguous over half its length."""


def count_octaves(wavelengths: tuple[float, ...]) -> Ints:
    """How often each wavelength is half of the one before, (n,) int64; 0 for the first.

    Raises
    ------
    WrongUse
        A wavelength is not the one before divided by a power of two.
    """
    ratio = np.log2(np.divide(wavelengths[:-1], wavelengths[1:]))
    whole = np.rint(ratio)
    if (np.abs(ratio - whole) > 1e-9).any() or (whole < 1).any():
        raise WrongUse(
            f"Modulation wavelengths {wavelengths} do not halve from coarse to fine.",
            "Each must be the one before divided by 2, 4, 8 and so on.",
        )
    return np.concatenate([[0], whole]).astype(np.int64)


def phase_range(
    distances: Floats, energies: Floats, wavelengths: tuple[float, ...] = WAVELENGTHS
) -> float:
    """Range that a phase-shift scanner reports for several echoes in one beam.

    The receiver sees Σ E exp(i 4π d / Λ). The phase of the coarsest Λ gives a first range; each
    finer Λ replaces it by its own within the cycle that the coarser one picked. Two surfaces
    more than a quarter of the finest Λ apart can so give a range between them, before or
    behind them: a ghost.

    Parameters
    ----------
    distances : (n,) array
        Metres, within half of the coarsest wavelength.
    energies : (n,) array
        Energy received from each.
    wavelengths : tuple of float
        Coarse to fine, metres.

    Returns
    -------
    float
        Metres.
    """
    from app.core.kernels.simulate import unwrap

    waves = np.asarray(wavelengths, float)
    phases = 4 * np.pi * np.asarray(distances, float)[None, :] / waves[:, None]
    weights = np.asarray(energies, float)
    return float(unwrap(np.cos(phases) @ weights, np.sin(phases) @ weights, waves))
