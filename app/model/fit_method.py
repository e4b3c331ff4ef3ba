"""How a curve is fitted: to what, and with which loss."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from app.core.errors import WrongUse

FitTo = Literal["points", "bins", "edge"]
FitLoss = Literal["squares", "huber", "tukey"]
RIGHT_ANGLE_DEG = 90.0


class Method(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a curve is fitted to, and how.

    Attributes
    ----------
    to : {'points', 'bins', 'edge'}
        Single points, means per step of the angle, or the upper edge of the points.
    loss : {'squares', 'huber', 'tukey'}
        Of points; bins are fitted by squares, an edge by its quantile.
    tau : float
        Share of the points below the edge.
    width : float
        Of a bin, degrees.
    angles : (float, float)
        Degrees between which pairs are fitted, the lower one included.
    """

    to: FitTo = "points"
    loss: FitLoss = "squares"
    tau: float = 0.95
    width: float = 5.0
    angles: tuple[float, float] = (0.0, RIGHT_ANGLE_DEG)

    def __post_init__(self) -> None:
        # Written so that a NaN fails.
        if not 0.0 < self.tau < 1.0:
            raise WrongUse(f"A quantile lies between 0 and 1, not at {self.tau:g}.")
        if not 0.0 < self.width <= RIGHT_ANGLE_DEG:
            raise WrongUse(f"Bins are wider than 0° and up to 90° wide, not {self.width:g}°.")
        low, high = self.angles
        if not 0.0 <= low < high <= RIGHT_ANGLE_DEG:
            raise WrongUse(
                f"Angles to fit rise within 0° to 90°; {low:g}° to {high:g}° do not.",
            )
        if self.loss != "squares" and self.to != "points":
            raise WrongUse(
                f"The loss {self.loss} is of single points, not of {self.to}.",
                "Fit points with it, or take squares.",
            )

    def as_dict(self) -> dict[str, Any]:
        """Plain values, as JSON has them."""
        return {**msgspec.structs.asdict(self), "angles": list(self.angles)}

    @property
    def by_squares(self) -> bool:
        """Whether it is a least-squares fit, for which criteria and profiles are defined."""
        return self.to != "edge" and self.loss == "squares"


WHOLE_SCAN = Method("bins", angles=(0.0, 80.0))
"""Of fits to a whole scan: the steepest angles hold little but borders."""


def usual_method(leaves: tuple[str, ...]) -> Method:
    """How a fit is made where nothing is said: points of leaves, means of a whole scan."""
    return Method() if leaves else WHOLE_SCAN
