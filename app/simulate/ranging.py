"""How a scanner makes ranges out of the echoes of one beam; slow and plain, to test against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.simulate.limits import check_choice, check_not_negative, check_positive, check_share
from app.simulate.waveform import Waveform, find_returns, sample_waveform

__all__ = [
    "WAVELENGTHS",
    "PhaseShift",
    "Pick",
    "Pulsed",
    "Ranging",
    "Waveform",
    "count_octaves",
    "phase_range",
    "pulsed_ranges",
]

WAVELENGTHS = (76.8, 9.6, 1.2)
"""Modulation wavelengths, metres, coarse to fine. Each is unambiguous over half its length."""

MOST_RETURNS = 15
"""Returns per beam that a LAS file can number."""

Pick: TypeAlias = Literal["first", "strongest", "last", "all"]


@dataclass(frozen=True, slots=True)
class PhaseShift:
    """One range per beam, from the phase of all its echoes together.

    Attributes
    ----------
    wavelengths : tuple of float
        Modulation wavelengths, coarse to fine, metres; each is the one before divided by a
        power of two. Ranges are unambiguous over half of the first.
    """

    wavelengths: tuple[float, ...] = WAVELENGTHS

    def __post_init__(self) -> None:
        if not self.wavelengths:
            raise WrongUse("Phase-shift ranging needs a modulation wavelength.", "Give one.")
        for wavelength in self.wavelengths:
            check_positive("A modulation wavelength", wavelength)
        count_octaves(self.wavelengths)

    @property
    def unambiguous(self) -> float:
        """Range at which the reported one starts again at 0, metres."""
        return self.wavelengths[0] / 2


@dataclass(frozen=True, slots=True)
class Pulsed:
    """Returns of a short pulse.

    Attributes
    ----------
    pulse : float
        Pulse length as range, c·τ/2 of the full width at half maximum, metres.
    blend : float
        Surfaces closer along the beam than this give one return, at their energy-weighted
        mean range; metres.
    pick : str
        Which of a beam's returns are reported: first, strongest, last or all.
    least : float
        A return with less than this share of the energy that the beam brings back is not
        noticed.
    most : int
        Returns per beam at most, when all are reported: the strongest.
    waveform : Waveform, optional
        Returns are then found in a digitised record: surfaces blend where their pulses overlap,
        and `least` is a share of the highest sample.
    """

    pulse: float
    blend: float
    pick: Pick = "first"
    least: float = 0.05
    most: int = 5
    waveform: Waveform | None = None

    def __post_init__(self) -> None:
        check_positive("The length of a pulse", self.pulse)
        check_not_negative("The distance over which returns blend", self.blend)
        check_choice("The return that is picked", self.pick, get_args(Pick))
        check_share("The least share of a return", self.least)
        if not 1 <= self.most <= MOST_RETURNS:
            raise WrongUse(f"A beam cannot have {self.most} returns.", f"Give 1 to {MOST_RETURNS}.")


Ranging: TypeAlias = PhaseShift | Pulsed


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
        Metres.
    energies : (n,) array
        Energy received from each.
    wavelengths : tuple of float
        Coarse to fine, metres.

    Returns
    -------
    float
        Metres, from 0 to below half of the coarsest wavelength: farther surfaces fold back.
    """
    away, weights = np.asarray(distances, float), np.asarray(energies, float)
    found = 0.0
    for number, wavelength in enumerate(wavelengths):
        cycle = wavelength / 2
        turns = float(np.angle(weights @ np.exp(2j * np.pi * away / cycle))) / (2 * np.pi)
        whole = 0.0 if number == 0 else np.round(found / cycle - turns)
        found = (turns + whole) * cycle
    folded = float(found % (wavelengths[0] / 2))
    # −1e-17 folds to the limit itself, which is 0 again.
    return folded if folded < wavelengths[0] / 2 else 0.0


def pulsed_ranges(
    distances: Floats, energies: Floats, pulsed: Pulsed, noise: Floats | None = None
) -> list[tuple[float, float]]:
    """Returns, (range, energy), that a pulsed scanner reports for the echoes of one beam.

    Echoes in order of distance join the one before when they are nearer to it than
    `pulsed.blend`, and returns with less than `pulsed.least` of the energy of all are dropped;
    with a waveform, see `find_returns`. Then those of `pulsed.pick` are taken.

    Parameters
    ----------
    distances : (n,) array
        Metres, in any order.
    energies : (n,) array
        Energy received from each; those without any are no echoes.
    pulsed : Pulsed
    noise : (samples,) array, optional
        Standard normal numbers for the samples of the waveform.

    Returns
    -------
    list of (float, float)
        In order of range; empty when nothing came back.
    """
    away, weights = np.asarray(distances, float), np.asarray(energies, float)
    away, weights = away[weights > 0], weights[weights > 0]
    if len(away) == 0:
        return []
    if pulsed.waveform is None:
        ranges, sums = _blend(away, weights, pulsed)
    else:
        record = sample_waveform(away, weights, pulsed.pulse, pulsed.waveform, noise)
        ranges, sums = find_returns(*record, pulsed.pulse, pulsed.least, pulsed.waveform)
    return _pick(list(zip(ranges.tolist(), sums.tolist(), strict=True)), pulsed)


def _blend(distances: Floats, energies: Floats, pulsed: Pulsed) -> tuple[Floats, Floats]:
    """Mean range and energy of each noticed group of neighbours nearer than the blend."""
    order = np.argsort(distances, kind="stable")
    away, weights = distances[order], energies[order]
    starts = np.concatenate([[0], np.flatnonzero(np.diff(away) >= pulsed.blend) + 1])
    sums = np.add.reduceat(weights, starts)
    noticed = sums >= pulsed.least * sums.sum()
    return (np.add.reduceat(weights * away, starts) / sums)[noticed], sums[noticed]


def _pick(returns: list[tuple[float, float]], pulsed: Pulsed) -> list[tuple[float, float]]:
    if pulsed.pick == "first":
        return returns[:1]
    if pulsed.pick == "last":
        return returns[-1:]
    strongest = sorted(returns, key=lambda item: -item[1])
    return sorted(strongest[: 1 if pulsed.pick == "strongest" else pulsed.most])
