"""What may be claimed of angles from intensity: three cases, told apart.

The case follows from what is known of curve and offset, and every result carries it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from app.core.wrinkling.curve import KnownCurve
from app.core.wrinkling.offset import Offset

Case = Literal["known", "species", "levelled"]
SENTENCES: dict[Case, str] = {
    "known": (
        "Curve and offset are known for this leaf: the angle ω from intensity and Δω are claimed, "
        "each with its error."
    ),
    "species": (
        "The curve is that of the species, and this leaf may be brighter or darker by "
        "{scatter:.0f} %: ω is claimed within its interval only, and one error is shared by the "
        "whole leaf. Differences inside the leaf are surer than ω itself."
    ),
    "levelled": (
        "The offset is set so that the leaf's mean angle is that of its plane: only differences "
        "Δω inside the leaf are claimed, not ω itself."
    ),
}
OWN_SENTENCE = (
    "The curve was fitted to this leaf's own local planes, so that its mean agrees with them: only "
    "differences Δω inside the leaf are claimed, not ω itself."
)


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A curve, what is added to it, and what may be claimed by them.

    Attributes
    ----------
    case : {'known', 'species', 'levelled'}
    curve : KnownCurve
    offset : Offset or None
        None: nothing for sure; where `case` is 'levelled', found for each leaf.
    scatter : Offset or None
        Reflectance of leaves about the curve's; None: this leaf's own is known.
    scatter_share : float
        The same as a share of the reflectance, to be told.
    own : bool
        The curve was fitted to this leaf's own planes: it is level with them already.
    """

    case: Case
    curve: KnownCurve
    offset: Offset | None = None
    scatter: Offset | None = None
    scatter_share: float = 0.0
    own: bool = False

    @property
    def sentence(self) -> str:
        """What may be claimed, to be shown beside every result."""
        if self.own:
            return OWN_SENTENCE
        return SENTENCES[self.case].format(scatter=100.0 * self.scatter_share)
