"""What a surface sends back in each channel, and the noise that the receiver adds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats

BRIGHT = 0.9
"""Reflectance at which `Receiver.range_noise` is stated."""


@dataclass(frozen=True, slots=True)
class Gloss:
    """Lambert–Beckmann reflectance of one channel (science: Kaasalainen 2018, section 2.1).

    The default k_d = 1 is Lambertian, and `m` then plays no part.
    """

    rho: float
    k_d: float = 1.0
    m: float = 1.0


Material = tuple[Gloss, ...]
"""One `Gloss` per channel."""


@dataclass(frozen=True, slots=True)
class Receiver:
    """Noise and sensitivity.

    Attributes
    ----------
    range_noise : float
        σ of the range on a surface of 90 % reflectance, metres.
    range_noise_power : float
        σ grows with (0.9 / ρ)^power. LS880: 2.6 mm at 90 % and 5.2 mm at 10 %: 0.315.
    intensity_noise : float
        σ of a reflectance, as a fraction of it.
    threshold : float
        Weakest reflectance times share of the beam that gives a return.
    """

    range_noise: float = 0.0
    range_noise_power: float = float(np.log(2) / np.log(9))
    intensity_noise: float = 0.0
    threshold: float = 0.01


def add_range_noise(
    distance: Floats, echo: Floats, receiver: Receiver, random: np.random.Generator
) -> Floats:
    """Ranges with white noise that grows where the `echo` (reflectance × share) is weak."""
    scale = (BRIGHT / np.maximum(echo, receiver.threshold)) ** receiver.range_noise_power
    return distance + receiver.range_noise * scale * random.standard_normal(distance.shape)


def add_intensity_noise(echo: Floats, receiver: Receiver, random: np.random.Generator) -> Floats:
    """Reflectances, (n, channels), with noise in proportion; never below zero."""
    noisy = echo * (1 + receiver.intensity_noise * random.standard_normal(echo.shape))
    return np.maximum(noisy, 0.0)
