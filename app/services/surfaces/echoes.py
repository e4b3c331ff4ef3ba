"""Power received from every point, as far as a scan's channels tell it."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.model.scan import Channel, Scan


def find_echo(scan: Scan) -> tuple[Floats | None, bool]:
    """Power received, (n,) in any unit, or None; and whether ranges scaled it.

    A reflectance is power times range squared; so are intensities from 0 to 1, as PTX has them.
    A logarithm of the power, or numbers of an unknown response, tell no shares.
    """
    for channel in scan.channels:
        values = scan.channel_values(channel.name)
        if channel.kind == "linear":
            return values, False
        if channel.kind == "reflectance" or _is_share(channel, values):
            square = ((scan.xyz - scan.scanner("the area of leaves")) ** 2).sum(axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.where(square > 0.0, values / square, np.nan), True
    return None, False


def _is_share(channel: Channel, values: Floats) -> bool:
    if channel.kind != "DN":
        return False
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and bool(((finite >= 0.0) & (finite <= 1.0)).all() & (finite % 1).any())
