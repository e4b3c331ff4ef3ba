"""Panels that somebody drew in scans, as the table that a calibration is fitted to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import BadInput
from app.core.planes import robust_plane
from app.core.progress import QUIET, Progress
from app.core.radiometry.calibration import BY_RULE, Wishes
from app.core.radiometry.models import CalibrationModel
from app.core.radiometry.noise import noise_of_points
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.profile import ChannelCalibration, Noise, Profile
from app.model.project import Project
from app.model.scan import Scan
from app.services.beams import name_instrument
from app.services.calibrate import UNNAMED, CalibrationReport, Naming, report_channel
from app.services.panel_readings import PanelReading, measure_panel
from app.simulate import detector

MOST_SATURATED = 0.01
"""Share of a panel's points at the end of the scale above which its mean is too low."""
UNKNOWN = Noise()
TO_SIGMA = 1.4826
"""σ of normal noise over its median absolute deviation."""
PERCENT = re.compile(r"(\d+(?:[.,]\d+)?)\s*%")


@dataclass(frozen=True, slots=True)
class KnownPanel:
    """Points of a scan that lie on a panel, and the panel's reflectance.

    Attributes
    ----------
    scan : str
        Key of the scan.
    name : str
        Of the panel; in other scans the same panel has the same name.
    points : (k,) rows
    reflectance, sigma : float
        A fraction, and how sure it is.
    """

    scan: str
    name: str
    points: Ints
    reflectance: float
    sigma: float = 0.0


@dataclass(frozen=True, slots=True)
class SeenPanel:
    """A panel as one raw channel of its scan saw it.

    Attributes
    ----------
    panel : KnownPanel
    reading : PanelReading
    saturated : float
        Share of its points at the end of the scale.
    nearest, farthest : float
        Ranges of its points, metres, without those that lie far off it.
    roughness : float
        σ of its points about their plane, metres: the noise of ranges on a flat panel.
    """

    panel: KnownPanel
    reading: PanelReading
    saturated: float
    nearest: float
    farthest: float
    roughness: float

    @property
    def usable(self) -> bool:
        """Whether its mean says what came back from it."""
        return self.saturated <= MOST_SATURATED


def guess_reflectance(name: str) -> float | None:
    """The reflectance that a panel's name tells, as in "50 % grey"; None where it tells none."""
    found = PERCENT.search(name)
    return float(found[1].replace(",", ".")) / 100 if found else None


def scale_of(scan: Scan) -> tuple[float | None, float | None]:
    """Ends of the scale, DN (dark, saturated), of the instrument that the scan names."""
    tool = name_instrument(scan)
    return (None, None) if tool is None else detector.scale_of(tool.detector)


def see_panels(
    project: Project,
    panels: Sequence[KnownPanel],
    channel: str,
    saturated: float | None = None,
    progress: Progress = QUIET,
) -> list[SeenPanel]:
    """Measure panels in their scans; see `measure_panel` for the errors.

    Parameters
    ----------
    channel : str
        A raw channel that all these scans have.
    saturated : float, optional
        DN from which nothing is told.
    """
    seen = []
    for number, panel in enumerate(panels):
        progress.report(number / len(panels), f"Measuring {panel.name}")
        share_of = progress.part(number / len(panels), (number + 1) / len(panels))
        reading = measure_panel(project, panel.scan, panel.points, channel, share_of)
        alive = panel.points[project.state.scan(panel.scan).alive[panel.points]]
        values = project.field(panel.scan, channel, alive)
        limit = np.inf if saturated is None else saturated
        ends = _find_ends(project.field(panel.scan, "range", alive))
        # Numbers that are all the same can only be the end of the scale, whatever was said.
        share = float(np.mean(values >= limit)) if reading.sigma > 0.0 else 1.0
        roughness = _measure_roughness(project.state.scan(panel.scan).scan.xyz[alive])
        seen.append(SeenPanel(panel, reading, share, *ends, roughness))
    return seen


def tabulate(
    project: Project, seen: Sequence[SeenPanel], channel: str, wavelength_nm: float
) -> PanelTable:
    """The table of the panels that can be used.

    Raises
    ------
    BadInput
        All are saturated, or there is none.
    """
    if not seen:
        raise BadInput("No panel has a reflectance yet.", "Draw around panels and give theirs.")
    used = [each for each in seen if each.usable]
    if not used:
        raise BadInput(
            f"All {len(seen)} panels are saturated.", "Draw darker ones, or scan them farther away."
        )
    return make_table(
        np.array([each.reading.range_m for each in used]),
        np.array([each.reading.dn for each in used]),
        np.array([each.panel.reflectance for each in used]),
        wavelength_nm,
        scan=[_name_scan(project, each.panel.scan) for each in used],
        panel=[each.panel.name for each in used],
        channel=channel,
        dn_sigma=np.array([each.reading.sigma for each in used]),
        reflectance_sigma=np.array([each.panel.sigma for each in used]),
    )


def calibrate_panels(
    project: Project,
    panels: Sequence[KnownPanel],
    channel: tuple[str, float],
    model: CalibrationModel,
    wishes: Wishes = BY_RULE,
    naming: Naming = UNNAMED,
    progress: Progress = QUIET,
) -> tuple[CalibrationReport, tuple[SeenPanel, ...]]:
    """Calibrate a raw channel, given by name and nm, by panels drawn in scans.

    The fit knows the means of panels only. The noise of a point, which is far larger, is that of
    the panels' points, and without a fitted range effect the profile holds for all of them.

    Raises
    ------
    BadInput
        A panel cannot be measured, or no calibration comes of them.
    """
    seen = see_panels(project, panels, channel[0], wishes.saturated, progress.part(0.0, 0.7))
    progress.report(0.7, "Fitting")
    table = tabulate(project, seen, *channel)
    used = [each for each in seen if each.usable]
    # A noise is named before the fit so that nobody is warned of that of the rows.
    found = report_channel(table, model, wishes, replace(naming, point_noise=UNKNOWN))
    scatter = np.array([each.reading.sigma * np.sqrt(each.reading.n) for each in used])
    noise = naming.point_noise or noise_of_points(found.channel, table, scatter)
    sigma = naming.range_sigma or float(np.sqrt(np.mean([each.roughness**2 for each in used])))
    made = msgspec.structs.replace(found.channel, noise=noise, range_sigma=sigma)
    found = replace(found, channel=made)
    if not model.fits_range:  # a curve over range ends at the means
        found = replace(found, channel=_widen(found.channel, used, naming.margin))
    named = ", ".join(table.panels)
    note = f"Calibrated from {named} in {', '.join(table.scans)} with the model {model.name}."
    title = naming.name or Path(table.scans[0]).stem
    profile = Profile(title, (found.channel,), naming.instrument, "yours", (note,))
    return CalibrationReport(profile, ", ".join(table.scans), (found,), ()), tuple(seen)


def _measure_roughness(xyz: Floats) -> float:
    """Scatter about the plane of a panel, metres; 0 where its points span no plane."""
    try:
        plane = robust_plane(xyz)
    except BadInput:
        return 0.0
    return float(TO_SIGMA * np.median(np.abs((xyz - plane.point) @ plane.normal)))


def _widen(
    calibration: ChannelCalibration, used: Sequence[SeenPanel], margin: float
) -> ChannelCalibration:
    """A calibration that holds at least where the panels' points are, and a margin beyond."""
    nearest, farthest = calibration.nearest, calibration.farthest
    if nearest is None or farthest is None:
        return calibration
    near = min(each.nearest for each in used) - margin
    far = max(each.farthest for each in used) + margin
    return msgspec.structs.replace(
        calibration, nearest=max(min(nearest, near), 0.0), farthest=max(farthest, far)
    )


def _name_scan(project: Project, key: str) -> str:
    """The name of a scan, and its key where several are called the same."""
    scans = {k: state.scan.name for k, state in project.state.scans.items()}
    alike = [k for k, name in scans.items() if name == scans[key]]
    return scans[key] if len(alike) == 1 else f"{scans[key]} ({key})"


def _find_ends(ranges: AnyArray) -> tuple[float, float]:
    """Least and largest range, without ghosts that the contour took along."""
    low, high = np.nanquantile(ranges, (0.01, 0.99))
    near = ranges[np.abs(ranges - np.nanmedian(ranges)) <= 2.0 * max(high - low, 1e-3)]
    return float(near.min()), float(near.max())
