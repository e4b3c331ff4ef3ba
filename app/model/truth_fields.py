"""What the fields of a simulated scan are called and measured in: the truth beside its numbers.

Their meaning in full stands in `app.simulate.truth`, which makes them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from app.model.fields import FieldKind

PREFIX = "truth_"


@dataclass(frozen=True, slots=True)
class TruthField:
    """A field of the truth as it is shown."""

    title: str
    unit: str = ""
    kind: FieldKind = "scalar"

    @property
    def numbers(self) -> bool:
        """Whether values are numbers of things, and −1 means that there is none."""
        return self.kind == "class"


_FIELDS = {
    "leaf": TruthField("True leaf", kind="class"),
    "incidence": TruthField("True incidence angle", "°", "angle"),
    "ghost": TruthField("True ghost", kind="verdict"),
    "range": TruthField("True range", "m"),
    "distance": TruthField("Distance to the nearest surface", "m"),
    "range_shift": TruthField("Range shift", "m"),
    "components": TruthField("Surfaces in the return"),
    "saturated": TruthField("Saturated", kind="flag"),
    "surface": TruthField("Surface", kind="class"),
    "surface_2": TruthField("Second surface", kind="class"),
    "surface_3": TruthField("Third surface", kind="class"),
    "hit_fraction": TruthField("Share of the beam", kind="score"),
    "hit_fraction_2": TruthField("Share of the second surface", kind="score"),
    "hit_fraction_3": TruthField("Share of the third surface", kind="score"),
    "normal_x": TruthField("True normal, x"),
    "normal_y": TruthField("True normal, y"),
    "normal_z": TruthField("True normal, z"),
    "sigma_range": TruthField("σ of the range", "m"),
}


def describe_truth(name: str) -> TruthField | None:
    """Title, unit and kind of a field of the truth; None for every other name."""
    rest = name.removeprefix(PREFIX)
    if rest == name:
        return None
    if rest in _FIELDS:
        return _FIELDS[rest]
    if rest.startswith("sigma_"):
        channel = rest.removeprefix("sigma_")
        return TruthField(f"σ of {channel}", "DN" if channel.startswith("intensity") else "")
    of_channel = re.fullmatch(r"(rho|reflectance)_(\d+)", rest)
    if of_channel:
        angle = "0°" if of_channel[1] == "rho" else "its angle"
        return TruthField(f"True reflectance at {angle}, {of_channel[2]} nm")
    return None
