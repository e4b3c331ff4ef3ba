"""Plans in words: what a user types of leaves and ranges, and what comes out as a sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence

from app.core.errors import WrongUse
from app.core.units import MM_PER_M
from app.services.planning import Plan, RangePlan, beam_facts

LARGEST_LEAF_MM = 10_000.0
ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)
SLACK = 1e-9

WHY = {
    "footprint": "the footprint is too long for the leaf",
    "full hits": "too few beams fall wholly on the leaf",
    "ghosts": "too many of its points are ghosts",
}


def parse_leaf(text: str) -> tuple[float, float]:
    """Length and width of a leaf in metres from ``80x45`` (mm), in either order.

    The longer side is the length: a plan takes a leaf turned about it, the worst case.

    Raises
    ------
    WrongUse
        Not two positive numbers.
    """
    try:
        sides = [float(part) for part in text.lower().replace("×", "x").split("x")]
    except ValueError:
        sides = []
    if len(sides) != 2 or not all(0.0 < side <= LARGEST_LEAF_MM for side in sides):
        raise WrongUse(
            f"A leaf is given by its two sides in mm, e.g. 80x45, not {text!r}.",
            f"Both lie above 0, up to {LARGEST_LEAF_MM:g} mm.",
        )
    return max(sides) / MM_PER_M, min(sides) / MM_PER_M


def parse_span(text: str, name: str, about: int = 20) -> tuple[float, ...]:
    """Numbers of ``LOW:HIGH``, ``LOW:HIGH:STEP`` or a single one; rising, with both ends.

    Without a step, a round one that gives at most `about` numbers.

    Raises
    ------
    WrongUse
        Something else.
    """
    try:
        parts = [float(part) for part in text.split(":")]
    except ValueError:
        parts = []
    if len(parts) == 1 and math.isfinite(parts[0]):
        return (parts[0],)
    if len(parts) not in (2, 3) or not all(map(math.isfinite, parts)) or parts[0] > parts[1]:
        raise WrongUse(
            f"{name} takes LOW:HIGH, LOW:HIGH:STEP or one number, not {text!r}.",
            "LOW must not be above HIGH.",
        )
    low, high = parts[:2]
    step = parts[2] if len(parts) == 3 else choose_step(high - low, about)
    if not step > 0.0 and high > low:
        raise WrongUse(f"{name} needs a step above 0, not {step:g}.")
    return spread(low, high, step)


def choose_step(room: float, about: int) -> float:
    """A round step of which at most `about` fit into a room, both ends counted."""
    if room <= 0.0:
        return 1.0
    least = room / max(about - 1, 1)
    decade = 10.0 ** math.floor(math.log10(least))
    return next(decade * part for part in ROUND if decade * part >= least * (1.0 - SLACK))


def spread(low: float, high: float, step: float) -> tuple[float, ...]:
    """Numbers from low to high; the last step is shorter where it does not fit."""
    if high <= low:
        return (low,)
    if (high - low) / step > 10_000:
        raise WrongUse(f"A step of {step:g} from {low:g} to {high:g} is too fine for a plan.")
    count = math.floor((high - low) / step + SLACK)
    inner = [round(low + k * step, 9) for k in range(count + 1)]
    return (*inner, high) if high - inner[-1] > SLACK * high else (*inner[:-1], high)


def tell_range(row: RangePlan) -> str:
    """``Up to 63 degrees usable at 4.0 m; the footprint then is 45 % of the leaf's width …``."""
    share = f"{row.footprint_share:.0%}".replace("%", " %")
    if row.largest_deg is None:
        return (
            f"Not usable at {row.range_m:.1f} m, even at 0 degrees: {WHY[row.bound]} "
            f"({tell_measure(row)})."
        )
    return (
        f"Up to {math.floor(row.largest_deg + SLACK)} degrees usable at {row.range_m:.1f} m; the "
        f"footprint then is {share} of the leaf's width. Beyond, {WHY[row.bound]} "
        f"({tell_measure(row)})."
    )


def tell_measure(row: RangePlan) -> str:
    """The number that binds, at the angle that is told."""
    if row.bound == "footprint":
        return f"{row.footprint_mm:.1f} mm"
    if row.bound == "full hits":
        return f"{row.full_hits:.0f} full hits"
    return f"{100.0 * row.ghosts:.0f} % ghosts"


def tell_limits(plan: Plan) -> str:
    """What counts as usable."""
    limits = plan.order.limits
    return (
        f"Usable: footprint up to {100 * limits.footprint:g} % of the leaf's width, at least "
        f"{limits.full_hits:g} full hits, at most {100 * limits.ghosts:g} % ghosts."
    )


def describe_tool_line(plan: Plan) -> str:
    """The instrument in a line."""
    facts = beam_facts(plan.order)
    title, ranging = str(facts["instrument"]), str(facts["ranging"])
    said = "" if ranging in title else f", {ranging}"
    return (
        f"{title}: {facts['exit_diameter_mm']:.4g} mm at exit, half divergence "
        f"{facts['half_divergence_deg']:.4g}°, step {facts['step_deg']:.4g}°{said}"
    )


def describe_leaf(plan: Plan) -> str:
    """The leaf in a few words, saying which side is which."""
    long, wide = sorted((plan.order.length, plan.order.width), reverse=True)
    return f"leaf {long * MM_PER_M:.4g} mm long and {wide * MM_PER_M:.4g} mm wide"


def list_assumptions(plan: Plan) -> Sequence[str]:
    """What a plan takes for granted."""
    behind, contrast = plan.order.behind, plan.order.contrast
    bright = "as bright as it is" if contrast == 1.0 else f"{contrast:g} times as bright"
    back = (
        "nothing stands behind it"
        if behind is None
        else f"something stands {behind:g} m behind it, {bright}"
    )
    return (
        "The leaf is a flat, matt ellipse, turned about its length (the worst case), near the "
        f"horizon of the scanner; {back}.",
        "Points: beams whose middle is on the leaf. Full hits: beams wholly on it. Ghosts: ranges "
        "more than 6 mm off every surface, as a share of the leaf's points and ghosts.",
        "The divergence is HALF of the full one.",
    )
