"""The scans that ghost networks learn from: every kind of scene by many instruments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from app.services.bench.ghosts.plans import PLANS, Plan
from app.services.bench.ghosts.scenes import scan_plan
from app.services.bench.ghosts.truth import Scene

PHASE_SHIFT = ("two_colour", "ls880", "ls880_filtered", "x330", "hds6100")
STEPS = (0.014, 0.018, 0.018, 0.018, 0.025, 0.036)
"""Degrees; that of most scanners of leaves counts three times."""
NOISES = (None, 0.0004, 0.0007, 0.0015, 0.003)
"""Metres at 90 % reflectance; None: the instrument's own."""
ROUNDS = 4
CROWNS = 3
"""Lessons on each crown per round: they are the hardest."""
OWN = 0.4
"""Share of the lessons by the instrument, and with the noise, of the plan."""
LAST_SEED = 20
MOST_BEAMS = 700_000
CUT = 0.6
"""Of the field of view, where there would be more beams."""


@dataclass(frozen=True, slots=True)
class Lesson:
    """A plan with an instrument, noise and step, and the seed of its leaves."""

    plan: Plan
    step: float
    seed: int

    def scan(self) -> Scene:
        """Simulate it."""
        return scan_plan(self.plan, self.seed, self.step)


def list_lessons(rounds: int = ROUNDS, seed: int = 1) -> Iterator[Lesson]:
    """Every plan, each round by another instrument, at another step and noise.

    Seeds of the leaves are those of development, 1 to 20; what networks are judged by has
    others (`scenes.FIRST_SEED`).
    """
    random = np.random.default_rng(seed)
    count = 0
    for _ in range(rounds):
        for plan in PLANS:
            for _ in range(CROWNS if "crown" in plan.name else 1):
                count += 1
                step = float(random.choice(STEPS))
                yield Lesson(_fit(_vary(plan, random), step), step, 1 + count % LAST_SEED)


def _vary(plan: Plan, random: np.random.Generator) -> Plan:
    """The plan by another instrument and with other noise, or as it is."""
    tool = plan.instrument if "pulsed" in plan.group else str(random.choice(PHASE_SHIFT))
    noise = NOISES[int(random.integers(len(NOISES)))]
    if random.random() < OWN:
        return plan
    return replace(plan, instrument=tool, noise=noise)


def _fit(plan: Plan, step: float) -> Plan:
    """The plan, its field of view cut where the step would make too many beams."""
    field = plan.document.get("field")
    if field is None:
        return plan
    turn, rise = (np.ptp(field[key]) for key in ("azimuth_deg", "elevation_deg"))
    while turn * rise / step**2 > MOST_BEAMS:
        field = {key: [CUT * side for side in sides] for key, sides in field.items()}
        turn, rise = CUT * turn, CUT * rise
    return replace(plan, document=plan.document | {"field": field})
