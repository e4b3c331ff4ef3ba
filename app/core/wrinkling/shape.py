"""The shape of a distribution of Δω in one word, and the rule behind it."""

from __future__ import annotations

from typing import Literal

from app.core.wrinkles import Distribution

Shape = Literal["unimodal", "skewed", "several modes", "too few points"]
LEAST = 30
SKEWED = 0.5
RULE = (
    "several modes: more than one peak of the smoothed distribution stands out by 10 % of the "
    "highest (wrinkles); skewed: one peak, and a skewness beyond ±0.5 (a simple bend); unimodal: "
    "one peak and no such skewness; fewer than 30 angles are given no word"
)


def name_shape(spread: Distribution) -> Shape:
    """One word for a distribution, by `RULE`."""
    if spread.count < LEAST:
        return "too few points"
    if len(spread.modes) > 1:
        return "several modes"
    return "skewed" if abs(spread.skewness) > SKEWED else "unimodal"
