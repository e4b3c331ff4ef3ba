"""A scan of targets that no calibration knew, and the power of the laser in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.radiometry.power import measure_power
from app.services.bench.radiometry.plans import (
    FIXED_RANGE,
    LEAST_POWER,
    Calibrated,
    Plan,
    draw_seed,
)
from app.services.bench.radiometry.sights import see_panels, take_instrument
from app.simulate.instrument import Instrument

TARGETS = (0.08, 0.15, 0.3, 0.5, 0.75)
OWN_PANEL, OWN_SIGMA = 0.5, 0.01
"""A panel that no calibration knows, and its σ relative to it."""
SHARED = 2
"""Place of the calibration's panel that the power is taken from."""


@dataclass(frozen=True, slots=True, eq=False)
class NewScan:
    """Targets that no calibration knew, in a scan with a power of its own.

    Attributes
    ----------
    target, place : (n,) arrays
        Number of the target's reflectance, and of its range.
    dn : (n, channels)
    distance : (n,) as measured
    rho : (n, channels)
        True reflectance.
    power, power_sigma : (channels,)
        As measured.
    power_pull : tuple of (k,) arrays or None
        Derivatives of the power by the parameters, per channel.
    """

    target: Ints
    place: Ints
    dn: Floats
    distance: Floats
    rho: Floats
    power: Floats
    power_sigma: Floats
    power_pull: tuple[Floats | None, ...]


def scan_targets(plan: Plan, calibrated: Calibrated, seed: int) -> NewScan:
    """Scan the targets at all their ranges, and measure the power of that scan."""
    tool = take_instrument(plan.instrument)
    random = np.random.default_rng([seed, 2])
    power = 1.0 if plan.drift == "none" else random.uniform(LEAST_POWER, 1.0)
    sights = [
        see_panels(tool, tuple(power * np.array(TARGETS)), away, draw_seed(random))
        for away in plan.targets
    ]
    found = _measure_power(plan, tool, calibrated, power, random)
    return NewScan(
        np.concatenate([sight.panel for sight in sights]),
        np.repeat(np.arange(len(sights)), [len(sight.panel) for sight in sights]),
        np.concatenate([sight.dn for sight in sights]),
        np.concatenate([sight.distance for sight in sights]),
        np.concatenate([sight.light for sight in sights]) / power,
        *found,
    )


def _measure_power(
    plan: Plan, tool: Instrument, calibrated: Calibrated, power: float, random: np.random.Generator
) -> tuple[Floats, Floats, tuple[Floats | None, ...]]:
    """Power of a new scan, its σ and its pull, per channel."""
    if plan.drift == "none":
        count = len(calibrated.channels)
        return np.ones(count), np.zeros(count), (None,) * count
    told, true, sigma = _choose_panels(plan, calibrated, random)
    away = FIXED_RANGE if plan.drift == "fixed panels" else plan.targets[0]
    sight = see_panels(tool, tuple(true * power), away, draw_seed(random))
    found = []
    for k, channel in enumerate(calibrated.channels):
        parts = [sight.dn[sight.of(place), k] for place in range(len(told))]
        dn = np.array([part.mean() for part in parts])
        spread = np.array([part.std(ddof=1) / np.sqrt(len(part)) for part in parts])
        found.append(
            measure_power(channel, dn, np.full(len(told), away), told, sigma * told, spread)
        )
    powers, sigmas = (np.array([each[k] for each in found]) for k in range(2))
    return powers, sigmas, tuple(each.pull for each in found)


def _choose_panels(
    plan: Plan, calibrated: Calibrated, random: np.random.Generator
) -> tuple[Floats, Floats, float]:
    """Panels of a new scan: reflectances as told, as they are, and σ relative to them."""
    if plan.drift == "a panel of its own":
        told = np.array([OWN_PANEL])
        return told, told * (1.0 + OWN_SIGMA * random.standard_normal(1)), OWN_SIGMA
    told = np.array(plan.panels)
    if plan.drift == "fixed panels":
        return told, calibrated.panels, plan.panel_sigma
    one = slice(SHARED, SHARED + 1)
    return told[one], calibrated.panels[one], plan.panel_sigma
