"""Which returns a receiver notices, and how far off their ranges are."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal, TypeAlias, get_args

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import WrongUse
from app.simulate.limits import check_choice, check_not_negative, check_positive, check_share

BRIGHT = 0.9
"""Reflectance at which `Receiver.range_noise` is stated."""
FAINT = 1e-6
"""Echo below which the range noise grows no more."""

Correlation: TypeAlias = Literal["white", "filtered"]


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
        Weakest reflectance times share of the beam that gives a return, at any range: how far
        the instrument sees is said by `farthest`, as data sheets do.
    correlation : str
        Range noise of neighbours: ``white``, or ``filtered``: averaged over 3 × 3 cells of the
        grid and rescaled, so that σ stays as stated.
    dropout : float
        Share of the returns lost at random.
    nearest, farthest : float
        Ranges between which there are returns, metres.
    reference : float, optional
        Range at which `range_noise` is stated, metres; σ then follows the received power, which
        falls with the square of the range. Without it σ depends on the reflectance alone.
    """

    range_noise: float = 0.0
    range_noise_power: float = float(np.log(2) / np.log(9))
    intensity_noise: float = 0.0
    threshold: float = 0.01
    correlation: Correlation = "white"
    dropout: float = 0.0
    nearest: float = 0.0
    farthest: float = inf
    reference: float | None = None

    def __post_init__(self) -> None:
        check_not_negative("The range noise", self.range_noise)
        check_not_negative("The power of the range noise", self.range_noise_power)
        check_share("The intensity noise", self.intensity_noise)
        check_share("The threshold of a return", self.threshold)
        check_choice("The correlation of the range noise", self.correlation, get_args(Correlation))
        check_share("The share of returns lost", self.dropout)
        check_not_negative("The nearest range", self.nearest)
        if self.reference is not None:
            check_positive("The range at which the range noise is stated", self.reference)
        if not self.nearest < self.farthest:
            raise WrongUse(
                f"Ranges cannot lie between {self.nearest:g} and {self.farthest:g} m.",
                "Give a farthest range beyond the nearest one.",
            )


def range_sigma(echo: Floats, distance: Floats, receiver: Receiver) -> Floats:
    """σ of the range of each return, (n,) metres.

    The power received is that of an ideal instrument, echo · (reference / distance)², down to
    the scanner itself: optics that hold back light near by are no part of it.

    Parameters
    ----------
    echo : (n,) array
        Noise-free reflectance × share of the beam, in the channel that measures the range.
    distance : (n,) array
        Noise-free range, metres.
    receiver : Receiver
    """
    weakest = max(receiver.threshold, FAINT)
    weaker = BRIGHT / np.maximum(echo, weakest)
    if receiver.reference is not None:
        weaker = weaker * (distance / receiver.reference) ** 2
    return np.asarray(receiver.range_noise * weaker**receiver.range_noise_power, np.float64)


def draw_noise(
    shape: tuple[int, int], cells: Ints, correlation: Correlation, random: np.random.Generator
) -> Floats:
    """Noise of unit variance for each return, (n,).

    Filtered noise is the mean of white noise over 3 × 3 cells, × 3: neighbours along a row or
    a column correlate by 2/3, diagonal ones by 4/9. The mean is taken over all cells of the
    grid and a rim around it, whether they gave a return or not, so that a cell's noise does
    not depend on the returns; several returns of one cell share it.

    Parameters
    ----------
    shape : (rows, columns)
    cells : (n,) int array
        Cell of each return, row · columns + column.
    correlation : str
    random : Generator
    """
    if correlation == "white":
        return random.standard_normal(len(cells))
    rows, columns = shape
    field = random.standard_normal((rows + 2, columns + 2))
    field = field[:-2] + field[1:-1] + field[2:]
    field = field[:, :-2] + field[:, 1:-1] + field[:, 2:]
    return np.asarray(field.ravel()[cells] / 3)


def choose_returns(
    distance: Floats, echo: Floats, receiver: Receiver, random: np.random.Generator
) -> Bools:
    """Returns that the receiver notices, (n,): strong enough, within its ranges, not lost.

    Parameters
    ----------
    distance : (n,) array
        Noise-free range, metres.
    echo : (n,) array
        As for `range_sigma`.
    receiver : Receiver
    random : Generator
        Drawn from only when the receiver has dropouts.
    """
    within = (distance >= receiver.nearest) & (distance <= receiver.farthest)
    kept: Bools = within & (echo >= receiver.threshold)
    if receiver.dropout:
        kept &= random.random(len(kept)) >= receiver.dropout
    return kept
