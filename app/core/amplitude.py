"""How far a value swings with the holder angle, and what scatter alone would give (Hancock)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.fitting import fit
from app.core.phase.cosine import expect_amplitude

LEVEL = 0.05


@dataclass(frozen=True, slots=True)
class Amplitude:
    """Amplitude of y = A·cos(2(θ − μ)) + ν (Hancock 2017, equation 2).

    Attributes
    ----------
    value : float
        A, signed: half the swing from 0° to 90°.
    mu_deg : float
        Angle of the peak; NaN without a swing.
    mean : float
        Of the values themselves.
    noise : float
        Standard deviation of a value about the curve.
    from_noise : float
        Mean |A| that this noise alone would give.
    interval : (float, float)
        Of A, 95 %, by Student's t; NaN where it is not determined.
    p : float
        Probability of such an amplitude without any swing; exact for normal noise. t test with a
        given μ, F test with a free one.
    n : int
    """

    value: float
    mu_deg: float
    mean: float
    noise: float
    from_noise: float
    interval: tuple[float, float]
    p: float
    n: int

    @property
    def exceeds_noise(self) -> bool:
        """Whether noise alone gives such an amplitude in fewer than 5 % of all cases."""
        return self.p < LEVEL


def measure_amplitude(angle: Floats, value: Floats, mu_deg: float | None = None) -> Amplitude:
    """Fit the cosine and compare its amplitude with noise.

    Parameters
    ----------
    angle : (n,) array
        Holder angle, radians.
    value : (n,) array
        Reflectance or index; pairs that are not finite are left out.
    mu_deg : float or None
        Angle of the peak, degrees, where it is known: for an index, that of the leaf's 1063 nm.

    Raises
    ------
    BadInput
        Too few different angles.
    """
    used = np.isfinite(angle) & np.isfinite(value)
    angle, value = angle[used], value[used]
    result = fit("cosine", angle, value, fixed={} if mu_deg is None else {"mu": mu_deg})
    free = 3 if mu_deg is None else 2
    noise = float(np.sqrt(result.rss / (result.n - free)))
    found = result.values
    if mu_deg is None:
        from_noise, p = expect_amplitude(angle, noise), _test_both(value, result.rss)
        sigma = result.parameters["A"].sd
    else:
        wave = np.cos(2.0 * (angle - np.deg2rad(mu_deg)))
        sigma = noise / float(np.sqrt(((wave - wave.mean()) ** 2).sum()))
        from_noise, p = sigma * float(np.sqrt(2.0 / np.pi)), _test_one(found["A"], sigma, result.n)
    return Amplitude(
        found["A"],
        found["mu"],
        float(value.mean()),
        noise,
        from_noise,
        _find_interval(found["A"], sigma, result.n - free),
        p,
        int(result.n),
    )


def _find_interval(amplitude: float, sigma: float | None, spare: int) -> tuple[float, float]:
    from scipy.stats import t

    reach = float("nan") if sigma is None else sigma * float(t.isf(LEVEL / 2.0, spare))
    return amplitude - reach, amplitude + reach


def _test_one(amplitude: float, sigma: float, n: int) -> float:
    from scipy.stats import t

    if sigma == 0.0:
        return 0.0 if amplitude else 1.0
    return float(2.0 * t.sf(abs(amplitude) / sigma, n - 2))


def _test_both(value: Floats, rss: float) -> float:
    from scipy.stats import f

    explained = max(float(((value - value.mean()) ** 2).sum()) - rss, 0.0)
    if rss == 0.0:
        return 0.0 if explained else 1.0
    return float(f.sf(explained / 2.0 / (rss / (len(value) - 3)), 2, len(value) - 3))
