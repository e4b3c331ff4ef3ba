"""Channels recognised by the names and the values of attributes."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from app.core.arrays import AnyArray
from app.model.scan import Channel, ChannelKind

# CloudCompare writes "scalar_" before every name of a PLY property.
_NAME = re.compile(
    r"(?:scalar_)?(?P<quantity>intensity|reflectance|amplitude|rho)"
    r"(?:[ _-]*(?P<number>\d+(?:\.\d+)?)(?: *nm)?)?(?P<decibel> *[(\[]?db[)\]]?)?",
    re.IGNORECASE,
)
_SHORTEST_NM, _LONGEST_NM = 300.0, 2600.0
_LOOKS = 100_000  # values that are looked at to tell what an attribute holds


def recognise_channels(attributes: Mapping[str, AnyArray]) -> tuple[Channel, ...]:
    """Channels among the attributes of a scan, in their order.

    A name such as ``reflectance_1063``, ``Intensity``, ``scalar_Intensity`` or
    ``Amplitude`` makes a channel; a trailing number from 300 to 2600 is its wavelength
    in nm. An attribute with one value throughout holds no measurement and makes none.

    Parameters
    ----------
    attributes : mapping of str to (n,) arrays

    Returns
    -------
    tuple of Channel
        ``reflectance`` where a reflectance lies mostly in 0 to 1.5; ``dB`` where an
        amplitude or reflectance is in decibel, as RIEGL writes them; else ``DN``.
    """
    found = (_recognise(name, values) for name, values in attributes.items())
    return tuple(channel for channel in found if channel is not None)


def name_constants(attributes: Mapping[str, AnyArray]) -> tuple[str, ...]:
    """Sentences about attributes that are called intensity but hold one value throughout."""
    return tuple(
        f"{name[:1].upper()}{name[1:]} is {values[0]:g} throughout: it holds no measurement."
        for name, values in attributes.items()
        if _NAME.fullmatch(name.strip())
        and len(values) > 1
        and values.dtype.kind in "iuf"
        and _is_constant(values)
    )


def _recognise(name: str, values: AnyArray) -> Channel | None:
    match = _NAME.fullmatch(name.strip())
    if match is None or values.dtype.kind not in "iuf" or _is_constant(values):
        return None
    return Channel(
        name=name,
        attribute=name,
        wavelength_nm=_wavelength(match["number"]),
        kind=_kind(match["quantity"].lower(), match["decibel"] is not None, values),
    )


def _wavelength(number: str | None) -> float | None:
    if number is None or not _SHORTEST_NM <= float(number) <= _LONGEST_NM:
        return None
    return float(number)


def _is_constant(values: AnyArray) -> bool:
    finite = values[np.isfinite(values)]
    return finite.size == 0 or bool(finite.min() == finite.max())


def _kind(quantity: str, decibel: bool, values: AnyArray) -> ChannelKind:
    if decibel:
        return "dB"
    if quantity == "intensity":
        return "DN"
    with np.errstate(invalid="ignore"):  # signalling NaN, as damaged files hold
        sample = values[:: max(1, len(values) // _LOOKS)].astype(np.float64)
    sample = sample[np.isfinite(sample)]
    if quantity == "amplitude":
        return "dB" if np.abs(sample).max(initial=0.0) < 150.0 else "DN"
    if np.mean((sample >= 0.0) & (sample <= 1.5)) > 0.9:
        return "reflectance"
    # Reflectance above that is in decibel where it goes below zero, else per cent or counts.
    return "dB" if np.mean(sample < 0.0) > 0.1 else "DN"
