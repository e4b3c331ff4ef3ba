"""The range of a beam that meets two surfaces, by how much of it falls on the nearer one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from app.core.arrays import Floats
from app.core.errors import WrongUse

NODES = 400
"""Steps of the tabulated share."""


@dataclass(frozen=True, slots=True)
class PhaseMixing:
    """A phase-shift scanner: one range, from the phase of both echoes together.

    Attributes
    ----------
    wavelengths : tuple of float
        Of the modulation, coarse to fine, metres.
    """

    wavelengths: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.wavelengths or not all(0.0 < w < np.inf for w in self.wavelengths):
            raise WrongUse("Phase-shift ranging needs modulation wavelengths above 0 m.")


@dataclass(frozen=True, slots=True)
class PulseMixing:
    """A pulsed scanner that reports the first return.

    Attributes
    ----------
    blend : float
        Surfaces nearer to each other than this give one return between them, metres.
    least : float
        A return with less than this share of the energy is not noticed.
    """

    blend: float
    least: float = 0.0

    def __post_init__(self) -> None:
        if not (0.0 < self.blend < np.inf and 0.0 <= self.least < 1.0):
            raise WrongUse(
                "Pulsed ranging needs a pulse longer than 0 m, and a least share from 0 to below 1."
            )


Mixing: TypeAlias = PhaseMixing | PulseMixing


def covered_share(inside: npt.ArrayLike) -> Floats:
    """Share of a beam's energy that falls on one side of a straight border.

    The beam is Gaussian and cut at its 1/e² radius, as in the simulator.

    Parameters
    ----------
    inside : array_like
        Distance of the beam's middle from the border, in radii of the beam; negative outside.

    Returns
    -------
    array
        0 from −1 downwards, ½ at 0, 1 from 1 upwards.
    """
    places, shares = _tabulate_share()
    found: Floats = np.interp(np.asarray(inside, np.float64), places, shares)
    return found


@cache
def _tabulate_share() -> tuple[Floats, Floats]:
    from scipy.special import erf

    # By the angle: the square root at the rim of the disc would spoil an even spacing.
    turn = np.linspace(-np.pi / 2, np.pi / 2, NODES + 1)
    place = np.sin(turn)
    slice_ = np.exp(-2.0 * place**2) * erf(np.sqrt(2.0) * np.cos(turn)) * np.cos(turn)
    total = np.concatenate([[0.0], np.cumsum((slice_[1:] + slice_[:-1]) / 2)])
    return place, total / total[-1]


def mixed_range(back_over_front: npt.ArrayLike, gap: float, mixing: Mixing) -> Floats:
    """How far behind the nearer surface the reported range lies.

    Parameters
    ----------
    back_over_front : array_like
        Energy that the farther surface returns over that of the nearer one, ≥ 0; inf: only the
        farther one is met.
    gap : float
        From one surface to the other along the beam, metres.
    mixing : PhaseMixing or PulseMixing

    Returns
    -------
    array
        Metres: 0 on the nearer surface, `gap` on the farther one. A phase-shift scanner may also
        report a place before the first or behind the second.
    """
    ratio = np.asarray(back_over_front, np.float64)
    front = 1.0 / (1.0 + ratio)  # share of the nearer surface; 0 where the ratio is infinite
    if isinstance(mixing, PulseMixing):
        return _blend(front, gap, mixing)
    found = np.zeros(ratio.shape)
    for number, wavelength in enumerate(mixing.wavelengths):
        cycle = wavelength / 2.0
        turn = 2.0 * np.pi * gap / cycle
        back = 1.0 - front
        phase = np.arctan2(back * np.sin(turn), front + back * np.cos(turn)) / (2.0 * np.pi)
        whole = 0.0 if number == 0 else np.round(found / cycle - phase)
        found = (phase + whole) * cycle
    return found


def _blend(front: Floats, gap: float, mixing: PulseMixing) -> Floats:
    if gap < mixing.blend:
        return gap * (1.0 - front)
    return np.where((front > 0.0) & (front >= mixing.least), 0.0, gap)
