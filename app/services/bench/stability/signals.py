"""Scans with numbers to be turned into reflectances, and calibrations of each kind to do it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.radiometry import chain as chains
from app.core.radiometry.chain import AnyStep
from app.core.radiometry.drift import Power
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.marks import GOOD
from app.core.radiometry.profile import ChannelCalibration, Noise, Profile
from app.core.radiometry.range_curve import PolynomialCurve, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.salca import SalcaResponse
from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.services.radiometry import apply_profile

CHANNEL, NM = "intensity", 1000.0
FIELD = f"reflectance_{NM:g}"
NEAREST, FARTHEST = 2.0, 20.0
"""Metres that all calibrations are good for."""
HERE = (0.3, -0.2, 1.6)
RANGES, LEVELS = (2.0, 4.0, 8.0, 14.0, 20.0), (3.0, 2.2, 1.0, 0.4, 0.2)
SHIFTS = (280.0, 200.0, 0.0, -240.0, -420.0)


@dataclass(frozen=True, slots=True)
class Seen:
    """Reflectances, their σ and marks, (n,) each."""

    values: Floats
    sigma: Floats
    marks: AnyArray


@dataclass(frozen=True, slots=True)
class Calibrated:
    """A kind of calibration.

    Attributes
    ----------
    name : str
    calibration : ChannelCalibration
    kind : {'DN', 'dB'}
        Of its numbers.
    """

    name: str
    calibration: ChannelCalibration
    kind: Literal["DN", "dB"] = "DN"

    def see(self, scan: Scan, points: Ints | None = None) -> Seen:
        """Reflectances of a scan as the program's fields; a warning on the way is an error."""
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            project = Project()
            key = project.shelve(scan)
            project.do(AddScan(key, scan.name, None))
            apply_profile(project, key, Profile("bench", (self.calibration,)))
            values = project.field(key, FIELD, points)
            sigma = project.field(key, f"{FIELD}_sigma", points)
            return Seen(values, sigma, project.field(key, f"{FIELD}_mark", points))

    def make_scan(self, count: int, seed: int = 0) -> Scan:
        """Points around the scanner: most good, some too near, too far, dark or saturated."""
        random = np.random.default_rng(seed)
        beams = random.normal(size=(count, 3))
        away = random.uniform(1.5, 22.0, count)
        xyz = np.array(HERE) + away[:, None] * beams / np.linalg.norm(beams, axis=1)[:, None]
        rho = np.exp(random.uniform(np.log(0.02), 0.0, count))
        inside = np.clip(away, NEAREST, FARTHEST)
        dn = np.round(chains.respond(self.calibration.steps, rho, inside))
        return self.put(dn, xyz)

    def put(self, dn: AnyArray, xyz: Floats, pose: tuple[float, float, float] = HERE) -> Scan:
        """A scan of these numbers and points."""
        channel = Channel(CHANNEL, CHANNEL, NM, self.kind)
        return Scan("bench", xyz, {CHANNEL: dn}, (channel,), Pose(pose))


def change(scan: Scan, dn: AnyArray | None = None, xyz: Floats | None = None) -> Scan:
    """The scan with other numbers or points."""
    attributes = dict(scan.attributes) if dn is None else {CHANNEL: dn}
    return replace(scan, attributes=attributes, xyz=scan.xyz if xyz is None else xyz)


def _calibrate(
    name: str, *steps: AnyStep, saturated: float | None = None, kind: Literal["DN", "dB"] = "DN"
) -> Calibrated:
    chain = (Power(), *steps)
    count = len(chains.names(chain))
    spread = np.diag([0.0, *(0.01 * np.abs(chains.values(chain)[1:]))]) ** 2
    covariance = tuple(tuple(map(float, row)) for row in spread.reshape(count, count))
    calibration = ChannelCalibration(
        CHANNEL, chain, wavelength_nm=NM, saturated=saturated, nearest=NEAREST, farthest=FARTHEST,
        noise=Noise(2.0, 0.01), range_sigma=0.002, fit_covariance=covariance,
        panel_covariance=covariance,
    )  # fmt: skip
    return Calibrated(name, calibration, kind)


CALIBRATIONS = (
    _calibrate(
        "logarithmic", LogResponse(600.0, 1784.0), PolynomialCurve("additive", RANGES, SHIFTS, 8.0),
        saturated=2000.0,
    ),
    _calibrate(
        "linear", SplineCurve("multiplicative", RANGES, LEVELS, 8.0), LinearResponse(1e-3, 0.2),
        saturated=2000.0,
    ),
    _calibrate("SALCA", AnalyticRange(1.5, 0.18, 0.84), SalcaResponse(137.21, 407.04, 16.83)),
    _calibrate("proportional", InverseSquare(8.0), Proportional(5000.0)),
    _calibrate("decibel", Decibel(), kind="dB"),
)  # fmt: skip


def tell_difference(found: Seen, expected: Seen) -> float:
    """Largest relative difference of values and σ; infinite where a mark differs."""
    if len(found.values) != len(expected.values) or (found.marks != expected.marks).any():
        return np.inf
    worst = 0.0
    for one, other in ((found.values, expected.values), (found.sigma, expected.sigma)):
        if (np.isfinite(one) != np.isfinite(other)).any():
            return np.inf
        known = np.isfinite(other)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.abs(one[known] - other[known]) / np.abs(other[known])
        worst = max(worst, float(np.nan_to_num(away, nan=0.0).max(initial=0.0)))
    return worst


def judge_marks(found: Seen) -> float:
    """0 where each reflectance and σ is finite or the point is marked; infinite elsewhere."""
    good = found.marks == GOOD
    finite = np.isfinite(found.values) & np.isfinite(found.sigma)
    absent = np.isnan(found.values) & np.isnan(found.sigma)
    return 0.0 if bool(np.where(good, finite, absent).all()) else np.inf
