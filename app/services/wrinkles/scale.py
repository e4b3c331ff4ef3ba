"""What the numbers of a channel are: linear or logarithmic, and where they end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.errors import WrongUse
from app.core.radiometry.log_response import Decibel
from app.core.wrinkling.offset import Scale
from app.model.scan import Channel, Scan
from app.services.beams import name_instrument
from app.simulate.detector import Linear, Logarithmic, scale_of
from app.simulate.instrument import Instrument
from app.simulate.virtual_scan import find_instrument


@dataclass(frozen=True, slots=True)
class ChannelScale:
    """Numbers of a channel.

    Attributes
    ----------
    scale : {'linear', 'log'}
    per_decade : float or None
        DN or dB per factor of ten of a logarithmic scale; None: nobody told.
    saturated : float or None
        Highest number of the instrument.
    told : bool
        False where a logarithmic scale is only supposed.
    """

    scale: Scale
    per_decade: float | None = None
    saturated: float | None = None
    told: bool = True


def find_scale(channel: Channel, scan: Scan, instrument: str | None = None) -> ChannelScale:
    """The scale of a channel, from its kind and from the instrument.

    Raises
    ------
    WrongUse
        There is no such instrument, or its numbers are neither a multiple nor a logarithm of
        reflectance.
    """
    tool = name_instrument(scan) if instrument is None else find_instrument(instrument)
    if channel.kind == "dB":
        return ChannelScale("log", Decibel().a0)
    if channel.kind in ("linear", "reflectance"):
        return ChannelScale("linear")
    if tool is None:
        return ChannelScale("log", None, None, told=False)
    detector = tool.detector
    saturated = scale_of(detector)[1]
    if isinstance(detector, Logarithmic):
        return ChannelScale("log", detector.a0[_place(channel, tool)], saturated)
    if isinstance(detector, Linear) and not any(detector.b):
        return ChannelScale("linear", None, saturated)
    raise WrongUse(
        f"DN of {tool.title} are neither a multiple nor a logarithm of reflectance.",
        "Calibrate the channel first (--profile NAME).",
    )


def _place(channel: Channel, tool: Instrument) -> int:
    if channel.wavelength_nm is None or len(tool.wavelengths_nm) == 1:
        return 0
    return int(np.argmin(np.abs(np.array(tool.wavelengths_nm) - channel.wavelength_nm)))
