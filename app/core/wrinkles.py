"""Wrinkles: angles from intensity against the plane of the leaf (Balduzzi 2011)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput

SIGN_OF_DELTA = (
    "Δω = ω from intensity − ω of the leaf's plane: 0 lies on the plane (green), "
    "negative is turned towards the beam, face-on (yellow, red), "
    "positive is turned towards edge-on (blue, purple)."
)

BIN = np.deg2rad(1.0)
_SMALLEST_BANDWIDTH = np.deg2rad(2.0)
_SMALLEST_PEAK = 0.1


def delta_omega(omega_intensity: Floats, omega_plane: float) -> Floats:
    """Δω = ω_I − ω_LSR of every point, in radians; for the sign see `SIGN_OF_DELTA`."""
    return np.asarray(omega_intensity, dtype=np.float64) - omega_plane


@dataclass(frozen=True, slots=True, eq=False)
class Distribution:
    """How the Δω of a leaf are spread; all angles in radians.

    Attributes
    ----------
    edges : (b + 1,)
        Borders of the bins, whole multiples of 1°, so that leaves can be laid over one another.
    fraction : (b,)
        Part of the points in each bin; the sum is 1.
    smooth : (b,)
        The same, smoothed; the modes are its peaks.
    count, undefined : int
        Points with and without an angle.
    mean, median, sd, skewness : float
        Skewness is m₃ / m₂^1.5; NaN when all values are equal.
    quantiles : 5, 25, 75 and 95 %
    modes : tuple of float
        Angles of the peaks, the highest first. One skewed peak: simple curvature; several:
        wrinkles.
    """

    edges: Floats
    fraction: Floats
    smooth: Floats
    count: int
    undefined: int
    mean: float
    median: float
    sd: float
    skewness: float
    quantiles: tuple[float, float, float, float]
    modes: tuple[float, ...]


def distribution(delta: Floats) -> Distribution:
    """Describe the Δω of a leaf.

    The histogram (bins of 1°) is smoothed by a Gaussian of Silverman's width,
    0.9 · min(sd, IQR/1.34) · n^(−1/5), at least 2° (below that intensity resolves nothing).
    A mode is a peak of the result that stands out by 10 % of the highest one.

    Parameters
    ----------
    delta : (n,) array
        Radians; NaN is counted and left out.

    Returns
    -------
    Distribution

    Raises
    ------
    BadInput
        No value is finite.
    """
    known = delta[np.isfinite(delta)]
    if not len(known):
        raise BadInput("No point of this leaf has a Δω.", "Fit the leaf's intensity first.")
    q5, q25, median, q75, q95 = (
        float(q) for q in np.quantile(known, [0.05, 0.25, 0.5, 0.75, 0.95])
    )
    mean, sd = float(known.mean()), float(known.std())
    edges, fraction = _histogram(known)
    spread = min(sd, (q75 - q25) / 1.34)
    bandwidth = max(0.9 * spread * len(known) ** -0.2, _SMALLEST_BANDWIDTH)
    smooth, modes = _find_modes(edges, fraction, bandwidth)
    return Distribution(
        edges=edges,
        fraction=fraction,
        smooth=smooth,
        count=len(known),
        undefined=len(delta) - len(known),
        mean=mean,
        median=median,
        sd=sd,
        skewness=_skewness(known),
        quantiles=(q5, q25, q75, q95),
        modes=modes,
    )


def _histogram(values: Floats) -> tuple[Floats, Floats]:
    first, last = np.floor(values.min() / BIN), np.floor(values.max() / BIN) + 1
    edges = np.arange(first, last + 1) * BIN
    # Indexed by the same division as the edges, so that no value falls off an end.
    place = (np.floor(values / BIN) - first).astype(np.int64)
    return edges, np.bincount(place, minlength=len(edges) - 1) / len(values)


def _find_modes(
    edges: Floats, fraction: Floats, bandwidth: float
) -> tuple[Floats, tuple[float, ...]]:
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    margin = int(np.ceil(4 * bandwidth / BIN)) + 1
    padded = np.pad(fraction, margin)
    smooth = gaussian_filter1d(padded, bandwidth / BIN, mode="constant")
    peaks, _ = find_peaks(smooth, prominence=_SMALLEST_PEAK * smooth.max())
    order = peaks[np.argsort(-smooth[peaks], kind="stable")]
    modes = edges[0] + (order - margin + 0.5) * BIN
    return smooth[margin:-margin], tuple(float(mode) for mode in modes)


def _skewness(values: Floats) -> float:
    rest = values - values.mean()
    spread = float(np.mean(rest**2))
    # Rounding leaves a spread of 1e-33 where all values are equal.
    if spread <= (1e-12 * float(np.abs(values).max())) ** 2:
        return float("nan")
    return float(np.mean(rest**3) / spread**1.5)
