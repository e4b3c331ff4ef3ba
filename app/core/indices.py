"""Named spectral indices, the channels that they want, and their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from app.core.arrays import Floats
from app.core.errors import MissingChannel


@dataclass(frozen=True, slots=True)
class NamedIndex:
    """An index of two channels, in the words of its paper.

    Attributes
    ----------
    name, title, formula : str
        `formula` is written with the roles as names.
    roles : (str, str)
        First and second channel of the formula.
    wanted_nm : tuple of (float, float)
        Wavelengths of the two roles; several pairs are alternatives of equal worth.
    tolerance_nm : float
        A channel farther than this from the wanted wavelength does not count.
    normalised : bool
        (first − second) / (first + second) if true, first / second if not.
    source : str
    """

    name: str
    title: str
    formula: str
    roles: tuple[str, str]
    wanted_nm: tuple[tuple[float, float], ...]
    tolerance_nm: float
    normalised: bool
    source: str


# NDVI and WI: the 8 channels of the HSL lie 40 to 100 nm apart, so "nearest" may be far.
# The other three are made for the common 1064, 1545 to 1550 and 690 nm lasers; 20 nm takes
# these in and keeps 690 nm off the red edge, where reflectance triples within 30 nm.
_HSL_NM = 40.0
_LASER_NM = 20.0
_KAASALAINEN = "Kaasalainen et al. 2018, doi 10.1098/rsfs.2017.0033"
_JUNTTILA = "Junttila et al. 2016, doi 10.3390/rs9010008"

_ALL = (
    NamedIndex(
        "ndi",
        "Normalised difference index",
        "(r1063 - r1545) / (r1063 + r1545)",
        ("r1063", "r1545"),
        ((1063.0, 1545.0),),
        _LASER_NM,
        True,
        "Hancock et al. 2017, doi 10.1109/TGRS.2017.2652140",
    ),
    NamedIndex(
        "ndvi",
        "Normalised difference vegetation index",
        "(nir - red) / (nir + red)",
        ("nir", "red"),
        ((795.0, 691.0), (818.0, 666.0)),
        _HSL_NM,
        True,
        _KAASALAINEN,
    ),
    NamedIndex(
        "wi",
        "Water index",
        "r900 / r970",
        ("r900", "r970"),
        ((900.0, 970.0),),
        _HSL_NM,
        False,
        _KAASALAINEN,
    ),
    NamedIndex(
        "lri",
        "Laser ratio index",
        "i1550 / i690",
        ("i1550", "i690"),
        ((1550.0, 690.0),),
        _LASER_NM,
        False,
        _JUNTTILA,
    ),
    NamedIndex(
        "nldi",
        "Normalised laser difference index",
        "(i690 - i1550) / (i690 + i1550)",
        ("i690", "i1550"),
        ((690.0, 1550.0),),
        _LASER_NM,
        True,
        _JUNTTILA,
    ),
)
NAMED: dict[str, NamedIndex] = {index.name: index for index in _ALL}


def match_channels(index: NamedIndex, wavelengths: Mapping[str, float | None]) -> dict[str, str]:
    """Choose the nearest channel for each role of an index.

    Parameters
    ----------
    index : NamedIndex
    wavelengths : mapping of channel name to nm
        None where unknown. Of two channels at the same distance the earlier one wins, so a
        caller that prefers reflectance to raw values puts it first.

    Returns
    -------
    dict of role to channel name
        Two different channels; of several wanted pairs the one with the smallest sum of
        distances.

    Raises
    ------
    MissingChannel
        Says which wavelength is missing and which channels there are.
    """
    known = [(name, nm) for name, nm in wavelengths.items() if nm is not None]
    best: tuple[float, tuple[str, str]] | None = None
    for wanted in index.wanted_nm:
        first, second = (_within(known, nm, index.tolerance_nm) for nm in wanted)
        for (far_1, name_1), (far_2, name_2) in product(first, second):
            if name_1 != name_2 and (best is None or far_1 + far_2 < best[0]):
                best = (far_1 + far_2, (name_1, name_2))
    if best is None:
        raise _missing(index, wavelengths)
    return dict(zip(index.roles, best[1], strict=True))


def _within(
    known: list[tuple[str, float]], wanted: float, tolerance: float
) -> list[tuple[float, str]]:
    return [(abs(nm - wanted), name) for name, nm in known if abs(nm - wanted) <= tolerance]


def _missing(index: NamedIndex, wavelengths: Mapping[str, float | None]) -> MissingChannel:
    pairs = " or ".join(" and ".join(f"{nm:g}" for nm in pair) for pair in index.wanted_nm)
    there = ", ".join(
        f"{name} ({'wavelength unknown' if nm is None else f'{nm:g} nm'})"
        for name, nm in wavelengths.items()
    )
    gaps = [_gap(index, pair, wavelengths) for pair in index.wanted_nm]
    return MissingChannel(
        f"{index.name} needs two channels near {pairs} nm (within {index.tolerance_nm:g} nm): "
        f"{min(gaps, key=len)}; channels here: {there or 'none'}.",
        "Name the wavelengths of the channels, or write a formula of your own.",
    )


def _gap(
    index: NamedIndex, pair: tuple[float, float], wavelengths: Mapping[str, float | None]
) -> str:
    known = [(name, nm) for name, nm in wavelengths.items() if nm is not None]
    lacking = [f"{nm:g} nm" for nm in pair if not _within(known, nm, index.tolerance_nm)]
    if len(lacking) == len(pair):
        return "both are missing"
    return f"{lacking[0]} is missing" if lacking else "one channel cannot be both"


def evaluate(index: NamedIndex, values: Mapping[str, Floats]) -> Floats:
    """Values of an index, for points or for means of samples.

    Parameters
    ----------
    index : NamedIndex
    values : mapping of role to array of any one shape
        On a linear scale (see `warn_about_kinds`).

    Returns
    -------
    float64 array of that shape
        NaN where an input is NaN, and where the denominator is zero or negative: there the
        index does not exist. Never ±inf.
    """
    first, second = (np.asarray(values[role], dtype=np.float64) for role in index.roles)
    with np.errstate(all="ignore"):
        top, bottom = (first - second, first + second) if index.normalised else (first, second)
        result = np.where(bottom > 0.0, top / bottom, np.nan)
    return np.where(np.isfinite(result), result, np.nan)


def warn_about_kinds(what: str, kinds: Mapping[str, str]) -> str:
    """Say in a sentence why an index of these channels may mean nothing.

    Parameters
    ----------
    what : str
        Name of the index or formula, for the sentence.
    kinds : mapping of channel name to {'DN', 'dB', 'linear', 'reflectance'}

    Returns
    -------
    str
        Empty when all channels are on one linear scale.
    """
    decibels = [name for name, kind in kinds.items() if kind == "dB"]
    raw = [name for name, kind in kinds.items() if kind == "DN"]
    parts = []
    if decibels:
        parts.append(f"{', '.join(decibels)} in dB, which is logarithmic")
    if raw:
        parts.append(f"{', '.join(raw)} in raw DN, which may be logarithmic")
    if not parts and len(set(kinds.values())) > 1:
        mixed = ", ".join(f"{name} ({kind})" for name, kind in kinds.items())
        return f"{what} mixes channels of different scales: {mixed}; calibrate them alike."
    if not parts:
        return ""
    return (
        f"{what} compares amounts of light and needs linear values, but takes "
        f"{' and '.join(parts)}; calibrate to reflectance first."
    )
