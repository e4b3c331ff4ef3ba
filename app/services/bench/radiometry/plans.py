"""Calibrations from simulated scans, as somebody would make them, and scans to try them on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np

from app.core.arrays import Floats
from app.core.radiometry.calibration import Wishes, calibrate, make_channel
from app.core.radiometry.models import choose_model
from app.core.radiometry.noise import noise_of_points
from app.core.radiometry.panels import make_table
from app.core.radiometry.profile import ChannelCalibration
from app.services.bench.radiometry.sights import Sight, ends_of, see_panels, take_instrument
from app.simulate.instrument import Instrument

Drift = Literal["none", "fixed panels", "a panel of its own", "a panel of the calibration"]
LEAST_POWER = 0.7
MOST_CLIPPED = 0.01
"""Share of a panel's points at an end of the scale above which its mean is not taken."""
MARGIN = 0.1
"""Metres beyond the panels' ranges where a calibration holds as well."""


@dataclass(frozen=True, slots=True)
class Plan:
    """How an instrument is calibrated, and where it is tried.

    Attributes
    ----------
    instrument, model : str
    panels : tuple of float
        Their reflectances as told.
    ranges : tuple of float
        A scan at each, metres.
    targets : tuple of float
        Ranges where it is tried, metres.
    panel_sigma : float
        σ of a panel's reflectance, relative to it; the same error in all scans.
    drift : str
        How the power of the new scan is found, which is not that of the calibration.
    """

    instrument: str
    model: str
    panels: tuple[float, ...]
    ranges: tuple[float, ...]
    targets: tuple[float, ...]
    panel_sigma: float
    drift: Drift


def _space(low: float, high: float, count: int) -> tuple[float, ...]:
    return tuple(round(float(away), 2) for away in np.geomspace(low, high, count))


GREYS = (0.9, 0.5, 0.25, 0.12, 0.05)
X330 = ("x330", "log+polynomial", GREYS, _space(4, 30, 13), (4.6, 7.5, 14.0), 0.02)
PLANS = (
    Plan("ls880", "log+polynomial", GREYS, _space(2, 30, 15), (2.5, 5.2, 11.0, 22.0), 0.02, "none"),
    Plan(*X330, "a panel of its own"),
    Plan(*X330, "a panel of the calibration"),
    Plan(
        "hds6100", "linear+spline", GREYS, _space(4, 14, 11), (4.7, 7.1, 11.0), 0.02,
        "a panel of its own",
    ),
    Plan(
        "salca", "hancock", (0.9, 0.65, 0.4, 0.2, 0.1, 0.05),
        (2.1, 3.0, 4.0, 5.5, 8.0, 11.0, 16.0, 24.0, 36.0, 50.0), (2.6, 6.5, 13.0, 30.0), 0.0,
        "fixed panels",
    ),
)  # fmt: skip
FIXED_RANGE = 8.0


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A calibration per channel, and the panels' reflectances as they truly are."""

    channels: tuple[ChannelCalibration, ...]
    panels: Floats


def carry_out(plan: Plan, seed: int) -> Calibrated:
    """Scan the panels at all ranges, and calibrate every channel of the instrument."""
    tool = take_instrument(plan.instrument)
    random = np.random.default_rng([seed, 1])
    told = np.array(plan.panels)
    true = told * (1.0 + plan.panel_sigma * random.standard_normal(len(told)))
    seen: list[list[Reading]] = [[] for _ in tool.wavelengths_nm]
    for number, away in enumerate(plan.ranges):
        fixed = plan.drift == "fixed panels"
        power = random.uniform(LEAST_POWER, 1.0) if fixed and away != FIXED_RANGE else 1.0
        for kind, distance in (("fixed", FIXED_RANGE), ("", away))[0 if fixed else 1 :]:
            noise = draw_seed(random)
            sight = see_panels(tool, tuple(true * power), distance, noise)
            for channel, found in enumerate(seen):
                found += _read(tool, sight, channel, told, f"scan {number}", kind, plan)
    channels = tuple(_calibrate(plan, tool, k, found) for k, found in enumerate(seen))
    return Calibrated(channels, true)


def draw_seed(random: np.random.Generator) -> int:
    """A seed for the noise of a scan."""
    return int(random.integers(2**31))


@dataclass(frozen=True, slots=True)
class Reading:
    """What one channel saw of a panel in a scan.

    Attributes
    ----------
    scan, panel : str
    told, sigma : float
        Reflectance of the panel as told, and its σ.
    distance : float
        Mean, metres.
    dn, scatter : float
        Mean and standard deviation of its points.
    count : int
    clipped : float
        Share of them at an end of the scale.
    spread : float
        Standard deviation of their ranges, metres.
    """

    scan: str
    panel: str
    told: float
    sigma: float
    distance: float
    dn: float
    scatter: float
    count: int
    clipped: float
    spread: float


def _read(
    tool: Instrument, sight: Sight, channel: int, told: Floats, scan: str, kind: str, plan: Plan
) -> list[Reading]:
    """What one channel saw of each panel of a scan."""
    low, high = ends_of(tool)
    found = []
    for place, rho in enumerate(told):
        at = sight.of(place)
        dn, away = sight.dn[at, channel], sight.distance[at]
        clipped = float(np.mean((dn >= high) | (dn <= low)))
        found.append(
            Reading(
                scan, f"{kind} {rho:g}", float(rho), plan.panel_sigma * float(rho),
                float(away.mean()), float(dn.mean()), float(dn.std(ddof=1)), len(dn), clipped,
                float(away.std(ddof=1)),
            )
        )  # fmt: skip
    return found


def _calibrate(
    plan: Plan, tool: Instrument, channel: int, seen: Sequence[Reading]
) -> ChannelCalibration:
    """Fit the means of panels; the noise of a point is that of the panels' points."""
    low, high = ends_of(tool)
    used = [each for each in seen if each.clipped <= MOST_CLIPPED]
    count = np.array([each.count for each in used])
    dn, scatter = np.array([(each.dn, each.scatter) for each in used]).T
    table = make_table(
        # Where the panels stood, so that it is one range for all panels of a scan.
        np.array([round(each.distance, 2) for each in used]),
        dn,
        np.array([each.told for each in used]),
        tool.wavelengths_nm[channel],
        scan=[each.scan for each in used],
        panel=[each.panel for each in used],
        dn_sigma=scatter / np.sqrt(count),
        reflectance_sigma=np.array([each.sigma for each in used]),
    )
    fixed = tuple(name for name in table.panels if name.startswith("fixed"))
    scan = f"scan {plan.ranges.index(FIXED_RANGE)}" if fixed else None
    # Numbers of a linear amplifier fall below 0, where the rule that chooses nodes cannot look.
    breaks = plan.ranges[1:-1] if low < 0 and plan.model.startswith("linear") else ()
    middle = plan.ranges[len(plan.ranges) // 2] if breaks else None
    wishes = Wishes(
        dark=low,
        saturated=high,
        fixed_panels=fixed,
        reference_scan=scan,
        breaks=breaks,
        reference_range=middle,
    )
    found = make_channel(calibrate(table, choose_model(plan.model), wishes))
    return msgspec.structs.replace(
        found,
        noise=noise_of_points(found, table, scatter),
        range_sigma=float(np.mean([each.spread for each in used])),
        nearest=float(table.distance.min()) - MARGIN,
        farthest=float(table.distance.max()) + MARGIN,
    )
