"""What every step of a calibration can do: forward, back, and how it depends on its numbers."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import msgspec
import numpy as np

from app.core.arrays import Floats


def _make_tag(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name).lower()


class Step(
    msgspec.Struct, frozen=True, tag_field="step", tag=_make_tag, forbid_unknown_fields=True
):
    """One effect between the light that a surface sends back and the number in the file.

    Signals x (nearer to light) and y (nearer to the number) are (n,) arrays; distances are
    (n,) metres, or one for all. Nothing is raised for a value that a step cannot give, or for
    a distance outside its interval: the result is NaN there.
    """

    free: ClassVar[tuple[str, ...]] = ()
    title: ClassVar[str] = ""
    source: ClassVar[str] = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters that a fit may change."""
        return self.free

    def values(self) -> Floats:
        """Values of these parameters, (k,)."""
        return np.array([getattr(self, name) for name in self.names], float)

    def with_values(self, values: Floats) -> Any:
        """The same step with other values of its parameters, (k,)."""
        return msgspec.structs.replace(
            self, **dict(zip(self.names, map(float, values), strict=True))
        )

    def respond(self, x: Floats, distance: Floats) -> Floats:
        """Forward: y of x, (n,)."""
        raise NotImplementedError

    def invert(self, y: Floats, distance: Floats) -> Floats:
        """Back: x of y, (n,)."""
        raise NotImplementedError

    def slope(self, x: Floats, distance: Floats) -> Floats:
        """Derivative of y by x, (n,)."""
        raise NotImplementedError

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        """Derivative of y by each parameter, (k, n)."""
        raise NotImplementedError

    def range_slope(self, x: Floats, distance: Floats) -> Floats:
        """Derivative of y by the distance, per metre, (n,)."""
        return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(distance)))


def spread(values: Floats, x: Floats, distance: Floats) -> Floats:
    """`values` in the shape that x and the distance have together."""
    values = np.asarray(values, float)
    shape = np.broadcast_shapes(np.shape(x), np.shape(distance))
    return values if values.shape == shape else np.broadcast_to(values, shape).copy()
