"""What a calibration may fit: responses, range effects, and the names that the papers gave them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from app.core.errors import WrongUse

RangeScale = Literal["additive", "multiplicative"]


@dataclass(frozen=True, slots=True)
class Part:
    """A response or a range effect that can be fitted.

    Attributes
    ----------
    name : str
    title, formula, source : str
    needs : str
        What the table must hold.
    """

    name: str
    title: str
    formula: str
    source: str
    needs: str


@dataclass(frozen=True, slots=True)
class CalibrationModel:
    """A response, and a range effect or none (all panels at one range, or taken out already)."""

    response: Part
    range_effect: Part | None

    @property
    def name(self) -> str:
        """``response``, ``response+range`` or, without a response, ``range``."""
        if self.range_alone and self.range_effect:
            return self.range_effect.name
        return self.response.name + (f"+{self.range_effect.name}" if self.range_effect else "")

    @property
    def range_scale(self) -> RangeScale:
        """Behind a logarithm weaker light is a shift (Balduzzi 2011), else a factor."""
        return "additive" if self.response.name in ("log", "none") else "multiplicative"

    @property
    def range_alone(self) -> bool:
        """Whether numbers stay numbers, as at the reference range."""
        return self.response is NO_RESPONSE

    @property
    def fits_curve(self) -> bool:
        """Whether the range effect is a curve through levels."""
        return self.range_effect is not None and self.range_effect.name in CURVES

    @property
    def fits_range(self) -> bool:
        """Whether the range effect has parameters of its own."""
        return self.range_effect is not None and self.range_effect.name != "inverse-square"


RESPONSES = {
    part.name: part
    for part in (
        Part(
            "log",
            "Logarithmic response",
            "ρ = 10^((DN − a1) / a0)",
            "Junttila et al. 2016, equation 3",
            "panels of two or more reflectances",
        ),
        Part(
            "linear",
            "Linear response",
            "ρ = a · DN + b",
            "Junttila et al. 2016, 2.5",
            "panels of two or more reflectances",
        ),
        Part(
            "proportional",
            "Proportional response",
            "DN = gain · ρ",
            "Kaasalainen et al. 2018, 2.2",
            "one panel or more",
        ),
        Part(
            "salca",
            "SALCA's response",
            "DN = (m·x + c) · (1 − e^(−k·x)), x = ρ · power · f(range)",
            "Hancock et al. 2017, equation A3",
            "panels of three or more reflectances, below and above the knee",
        ),
    )
}
NO_RESPONSE = Part(
    "none",
    "Range effect alone",
    "I_c = DN − F(range), as at the reference range",
    "Balduzzi et al. 2011, equation 7",
    "one panel or more, at three or more ranges",
)
CURVES = ("polynomial", "spline")
"""Range effects that may be fitted alone."""
RANGE_EFFECTS = {
    part.name: part
    for part in (
        Part(
            "inverse-square",
            "Inverse square of the range",
            "f = (d_ref / d)²",
            "Balduzzi et al. 2011, equation 2",
            "nothing more",
        ),
        Part(
            "polynomial",
            "Piecewise polynomial over range",
            "f99(d), order 1 or 2 between ranges",
            "Balduzzi et al. 2011, equation 7",
            "panels at three or more ranges",
        ),
        Part(
            "spline",
            "Monotone spline over range",
            "PCHIP through levels at ranges",
            "Fritsch and Butland 1984",
            "panels at three or more ranges",
        ),
        Part(
            "analytic",
            "Analytic range effect, outer power",
            "g = d^(−a) · (1 − e^(−k2·d))^k3, f = g / g(d_ref)",
            "Hancock et al. 2017, equation A5",
            "panels at four or more ranges, and a fixed panel in every scan",
        ),
        Part(
            "analytic-inner",
            "Analytic range effect, inner power",
            "g = d^(−a) · (1 − e^(−k2·d^k3)), f = g / g(d_ref)",
            "Hancock et al. 2017, equation A5, its other reading",
            "panels at four or more ranges, and a fixed panel in every scan",
        ),
    )
}
PAPERS: Mapping[str, str] = {
    "balduzzi": "log+polynomial",
    "junttila-log": "log",
    "junttila-linear": "linear",
    "kaasalainen": "proportional+spline",
    "hancock": "salca+analytic",
}
LEAST_PANELS = {"none": 1, "log": 2, "linear": 2, "proportional": 1, "salca": 3}
"""Reflectances that a response needs."""
LEAST_RANGES = {"polynomial": 3, "spline": 3, "analytic": 4, "analytic-inner": 4}
"""Ranges that a range effect needs."""


def choose_model(text: str) -> CalibrationModel:
    """The model of a name: RESPONSE, RESPONSE+RANGE, a curve over range, or a paper.

    Raises
    ------
    WrongUse
        There is no such model.
    """
    wanted = text.strip().lower()
    if wanted in CURVES:
        return CalibrationModel(NO_RESPONSE, RANGE_EFFECTS[wanted])
    response, _, effect = PAPERS.get(wanted, wanted).partition("+")
    if response not in RESPONSES or (effect and effect not in RANGE_EFFECTS):
        raise WrongUse(
            f"There is no calibration model {text!r}.",
            f"Give a response ({', '.join(RESPONSES)}), with a range effect if there is one "
            f"(+{', +'.join(RANGE_EFFECTS)}), the range effect alone ({', '.join(CURVES)}), or a "
            f"paper: {', '.join(PAPERS)}.",
        )
    return CalibrationModel(RESPONSES[response], RANGE_EFFECTS[effect] if effect else None)
