"""What is known of ghosts: the surfaces around them, by name, and the words for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.ghosts import Reason, Reasons
from app.core.units import to_degrees, to_mm
from app.model.ghost_fields import take_logarithm
from app.model.leaf import Leaf
from app.model.state import ScanState

MINUS = "\N{MINUS SIGN}"
GRID_METHOD, DENSITY_METHOD = "scan grid", "density, weaker: the scan has no rows and columns"
SURFACE, OTHER = "a surface", "another surface"


@dataclass(frozen=True, slots=True)
class LeafNames:
    """Which leaf each point belongs to.

    Attributes
    ----------
    keys, names : tuple of str
    of : (n,) int32
        Place in these of the leaf of each point, -1 without one.
    """

    keys: tuple[str, ...]
    names: tuple[str, ...]
    of: AnyArray

    @classmethod
    def gather(cls, leaves: Sequence[Leaf], size: int) -> LeafNames:
        """Number the points of leaves; one in two leaves is of the later."""
        of = np.full(size, -1, np.int32)
        for place, leaf in enumerate(leaves):
            of[leaf.members.indices] = place
        keys, names = (tuple(getattr(leaf, what) for leaf in leaves) for what in ("key", "name"))
        return cls(keys, names, of)

    def name(self, member: int) -> str:
        """What a surface is called by one of its points; -1 is no point."""
        place = int(self.of[member]) if member >= 0 else -1
        return "" if place < 0 else self.names[place]


def light_for_words(state: ScanState) -> Floats | None:
    """Natural logarithm of the first channel, so that intensities can be told as a share.

    Of DN it is a share of DN, whatever the amplifier makes of power.
    """
    channels = state.scan.channels
    if not channels:
        return None
    values = np.asarray(state.scan.channel_values(channels[0].name), np.float64)
    if channels[0].kind == "dB":
        nepers: Floats = values * (np.log(10.0) / 10.0)
        return nepers
    return take_logarithm(values)


def say_length(metres: float) -> str:
    """A signed distance as people say it: −14 mm, +2.1 m."""
    sign = MINUS if metres < 0 else "+"
    size = abs(metres)
    text = f"{size:.1f} m" if size >= 0.9995 else f"{to_mm(size):.{0 if size >= 0.01 else 1}f} mm"
    return sign + text


def say_reason(reasons: Reasons, place: int, names: LeafNames, ghost: bool = True) -> str:
    """Why one point is a ghost, or none, in a sentence.

    Parameters
    ----------
    reasons : Reasons
    place : int
        Of the point in `reasons`.
    names : LeafNames
    ghost : bool
        Whether it counts as one.
    """
    parts = [_say_surfaces(reasons, place, names, ghost)]
    if reasons.light is not None and np.isfinite(reasons.light[place]):
        parts.append(f"intensity {reasons.light[place]:.2f} of expected")
    border = float(reasons.border[place])
    if np.isfinite(border):
        parts.append(f"{abs(border):.1f} beams from the border")
    return ", ".join(parts)


def _say_surfaces(reasons: Reasons, place: int, names: LeafNames, ghost: bool) -> str:
    offset = reasons.offset[place]
    first, second = (names.name(int(member)) for member in reasons.member[place])
    one = f"{first or SURFACE} ({say_length(offset[0])})"
    both = np.isfinite(offset).all()
    if both and offset[0] * offset[1] < 0.0:
        other = second or (OTHER if not first else SURFACE)
        between = f"between {one} and {other} ({say_length(offset[1])})"
    else:
        between = ""
    match Reason(int(reasons.reason[place])):
        case Reason.ALONE:
            return "alone, no surface around"
        case Reason.STEEP:
            angle = to_degrees(float(reasons.incidence[place]))
            return f"in a steep, lengthened part of {one}, seen at {angle:.0f}°"
        case Reason.WEAK:
            return f"on {one}, but nothing goes on through it"
        case Reason.BETWEEN if between:
            return between
        case Reason.ON_SURFACE if not ghost and np.isfinite(offset[0]):
            return f"on {one}"
        case Reason.ON_SURFACE if not ghost:
            return "no ghost, though no surface can be laid through what is around"
    where = "in front of" if offset[0] > 0 else "behind"
    return f"{where} {one} and all else around"
