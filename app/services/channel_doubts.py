"""Where a channel was guessed from its name alone, and what helps."""

from __future__ import annotations

import numpy as np

from app.model.scan import Scan

LARGEST_SHARE = 1.5
"""Reflectance of a white panel, with room for its gloss."""
_LOOKS = 100_000


def doubt_channel(scan: Scan) -> str:
    """A sentence where the first channel, taken as DN, looks like a share of light; else "".

    DN counts as the output of a logarithmic amplifier. PTX and E57 scale all light to 0 to 1,
    whatever it was.
    """
    if not scan.channels or scan.channels[0].kind != "DN":
        return ""
    channel = scan.channels[0]
    values = scan.attributes[channel.attribute]
    if values.dtype.kind != "f":
        return ""
    some = values[:: max(1, len(values) // _LOOKS)]
    some = some[np.isfinite(some)]
    if not len(some) or some.min() < 0.0 or some.max() > LARGEST_SHARE:
        return ""
    nm = f"{channel.wavelength_nm:g}" if channel.wavelength_nm else "NM"
    return (
        f"{channel.name} lies within 0 and {LARGEST_SHARE:g} and is taken as DN of a logarithmic "
        f"amplifier. If it is a reflectance, say so: --channel {channel.attribute}={nm}:"
        f"reflectance; if it is proportional to power: --channel {channel.attribute}={nm}:linear."
    )
