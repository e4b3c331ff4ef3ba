"""What an instrument writes down for a return: reflectance, or the numbers of its amplifier."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import ClassVar, Literal, TypeAlias

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import WrongUse
from app.simulate.limits import check_not_negative, check_positive
from app.simulate.range_effect import NoEffect, RangeEffect, sample_strength
from app.simulate.receiver import Receiver

DARK = 1e-12
"""Reflectance below which a logarithm stays as it is."""

Kind: TypeAlias = Literal["reflectance", "DN"]


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """What an instrument recorded of each return.

    Attributes
    ----------
    values : (n, channels), reflectance or DN
    sigma : (n, channels), σ of the value in its own unit: noise, and the quantum / √12
    saturated : (n, channels), the value stands at the upper end of the scale
    """

    values: Floats
    sigma: Floats
    saturated: Bools


@dataclass(frozen=True, slots=True)
class Digitiser:
    """The end of the chain: electronic noise, steps and the two ends of the scale, in DN.

    Attributes
    ----------
    dark, saturated : float
        Lowest and highest DN.
    quantum : float
        DN between two values; 0: not rounded.
    electronic_noise : float
        σ, DN, whatever the strength of the return.
    """

    dark: float
    saturated: float
    quantum: float = 1.0
    electronic_noise: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.dark) and isfinite(self.saturated) and self.dark < self.saturated):
            raise WrongUse(
                f"A scale cannot run from {self.dark:g} to {self.saturated:g} DN.",
                "Give a saturated DN above the dark one.",
            )
        check_not_negative("The quantum of a DN", self.quantum)
        check_not_negative("The electronic noise", self.electronic_noise)

    def digitise(self, signal: Floats, random: np.random.Generator) -> tuple[Floats, Bools]:
        """DN of a signal, and where it saturates."""
        if self.electronic_noise:
            signal = signal + self.electronic_noise * random.standard_normal(signal.shape)
        if self.quantum:
            signal = np.round(signal / self.quantum) * self.quantum
        return np.clip(signal, self.dark, self.saturated), signal >= self.saturated

    def sigma(self, signal_sigma: Floats) -> Floats:
        """σ of the DN of a signal with the given σ."""
        own = self.electronic_noise**2 + self.quantum**2 / 12
        return np.asarray(np.sqrt(signal_sigma**2 + own))


@dataclass(frozen=True, slots=True)
class Ideal:
    """Reports the apparent reflectance itself, whatever the range."""

    kind: ClassVar[Kind] = "reflectance"


@dataclass(frozen=True, slots=True)
class Linear:
    """ρ = a · DN + b (science 1.3: Leica HDS6100); a and b per channel."""

    a: tuple[float, ...]
    b: tuple[float, ...]
    scale: Digitiser
    range_effect: RangeEffect = field(default_factory=NoEffect)

    kind: ClassVar[Kind] = "DN"

    def __post_init__(self) -> None:
        _check_channels(a=self.a, b=self.b)
        for slope in self.a:
            check_positive("The slope a of a linear detector", slope)

    def respond(self, effective: Floats, channel: int) -> Floats:
        """DN of an effective reflectance, without noise and not clipped."""
        return np.asarray((effective - self.b[channel]) / self.a[channel])

    def slope(self, effective: Floats, channel: int) -> Floats:
        """Derivative of `respond`."""
        return np.full(np.shape(effective), 1 / self.a[channel])


@dataclass(frozen=True, slots=True)
class Logarithmic:
    """ρ = 10^((DN − a1) / a0) (science 1.3: FARO); a0 and a1 per channel.

    a0 is DN per decade, a1 the DN of ρ = 1.
    """

    a0: tuple[float, ...]
    a1: tuple[float, ...]
    scale: Digitiser
    range_effect: RangeEffect = field(default_factory=NoEffect)

    kind: ClassVar[Kind] = "DN"

    def __post_init__(self) -> None:
        _check_channels(a0=self.a0, a1=self.a1)
        for decade in self.a0:
            check_positive("The a0 of a logarithmic detector", decade)

    def respond(self, effective: Floats, channel: int) -> Floats:
        """DN of an effective reflectance, without noise and not clipped."""
        light = np.maximum(effective, DARK)
        return np.asarray(self.a0[channel] * np.log10(light) + self.a1[channel])

    def slope(self, effective: Floats, channel: int) -> Floats:
        """Derivative of `respond`."""
        return np.asarray(self.a0[channel] / (np.log(10) * np.maximum(effective, DARK)))


@dataclass(frozen=True, slots=True)
class Salca:
    """DN = (m ρ + c) (1 − e^(−k ρ)) (science 1.4: Hancock A3); m, c and k per channel."""

    m: tuple[float, ...]
    c: tuple[float, ...]
    k: tuple[float, ...]
    scale: Digitiser
    range_effect: RangeEffect = field(default_factory=NoEffect)

    kind: ClassVar[Kind] = "DN"

    def __post_init__(self) -> None:
        _check_channels(m=self.m, c=self.c, k=self.k)
        for value in (*self.m, *self.c, *self.k):
            check_positive("A parameter m, c or k of the SALCA response", value)

    def respond(self, effective: Floats, channel: int) -> Floats:
        """DN of an effective reflectance, without noise and not clipped."""
        rise = -np.expm1(-self.k[channel] * effective)
        return np.asarray((self.m[channel] * effective + self.c[channel]) * rise)

    def slope(self, effective: Floats, channel: int) -> Floats:
        """Derivative of `respond`."""
        m, c, k = self.m[channel], self.c[channel], self.k[channel]
        fall = np.exp(-k * effective)
        return np.asarray(m * (1 - fall) + (m * effective + c) * k * fall)


Amplifier: TypeAlias = Linear | Logarithmic | Salca
Detector: TypeAlias = Ideal | Amplifier


def count_channels(detector: Detector) -> int | None:
    """Channels that a detector is described for; None: any number."""
    if isinstance(detector, Linear):
        return len(detector.a)
    if isinstance(detector, Logarithmic):
        return len(detector.a0)
    return len(detector.m) if isinstance(detector, Salca) else None


def scale_of(detector: Detector) -> tuple[float | None, float | None]:
    """Lowest and highest DN of a detector; None for one that reports reflectance itself."""
    if isinstance(detector, Ideal):
        return None, None
    return detector.scale.dark, detector.scale.saturated


def tabulate_strength(detector: Detector, channels: int, farthest: float) -> Floats:
    """Range effect of a detector on the lattice of `range_effect.sample_strength`.

    Returns
    -------
    (channels, k) array
        (channels, 0) for a detector without a range effect: light then falls by 1 / d², and the
        instrument takes that out again.
    """
    if isinstance(detector, Ideal) or isinstance(detector.range_effect, NoEffect):
        return np.empty((channels, 0))
    return sample_strength(detector.range_effect, channels, farthest)


def record(
    echo: Floats,
    distance: Floats,
    detector: Detector,
    receiver: Receiver,
    random: np.random.Generator,
    echo_sigma: Floats | None = None,
) -> Recorded:
    """What the instrument writes down for each return.

    Parameters
    ----------
    echo : (n, channels) array
        Noise-free apparent reflectance × share of the beam: what an ideal instrument reports.
    distance : (n,) array
        Noise-free range, metres.
    detector : Detector
        An amplifier sees echo · f(distance) / f(reference), with its range effect f.
    receiver : Receiver
        Its intensity noise is in proportion to the echo; no noisy echo is below zero.
    random : Generator
    echo_sigma : (n, channels) array, optional
        σ of scatter that `echo` has already, as of a noisy waveform; it enters the σ that is
        told, and the values not once more.

    Raises
    ------
    WrongUse
        The detector has other channels, or its range effect is not known at a distance.
    """
    share = receiver.intensity_noise
    spread = share * echo if echo_sigma is None else np.hypot(share * echo, echo_sigma)
    noisy = np.maximum(echo * (1 + share * random.standard_normal(echo.shape)), 0.0)
    if isinstance(detector, Ideal):
        return Recorded(noisy, spread, np.zeros(echo.shape, bool))
    if echo.shape[1] != count_channels(detector):
        raise WrongUse(
            f"The detector has {count_channels(detector)} channels, the scene {echo.shape[1]}.",
            "Build the scene for the wavelengths of the instrument.",
        )
    signal, sigma = np.empty(echo.shape), np.empty(echo.shape)
    for k in range(echo.shape[1]):
        strength = detector.range_effect.strength(distance, k)
        effective = echo[:, k] * strength
        signal[:, k] = detector.respond(noisy[:, k] * strength, k)
        sigma[:, k] = detector.slope(effective, k) * strength * spread[:, k]
    values, saturated = detector.scale.digitise(signal, random)
    return Recorded(values, detector.scale.sigma(sigma), saturated)


def _check_channels(**parameters: tuple[float, ...]) -> None:
    """Raise `WrongUse` unless all are finite and there is one of each per channel, at least one."""
    names = " and ".join(parameters)
    lengths = {len(values) for values in parameters.values()}
    if len(lengths) != 1 or 0 in lengths:
        raise WrongUse(
            f"The detector has {names} for different numbers of channels, or for none.",
            "Give one of each per channel.",
        )
    if not all(isfinite(value) for values in parameters.values() for value in values):
        raise WrongUse(f"The detector's {names} must be finite numbers.", "Correct them.")
