"""Who takes part: each estimator of ours, by grid and by voxels, and the programs of others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter

import numpy as np
import numpy.typing as npt

from app.core.arrays import Bools, Floats
from app.core.incidence import Estimator, incidence_angle, local_planes
from app.core.units import to_degrees, to_mm
from app.services.bench.incidence.scenes import Noise, Truth

OURS = "Leafscope"
RADII = (0.003, 0.004, 0.006, 0.008, 0.010)

Singles = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What a program gives back.

    Attributes
    ----------
    normals : (n, 3)
        Of any sign; NaN where there is none.
    width : (n,) metres
        Half-width of the window, or radius, that was used.
    preparing : float
        Seconds to bring the points into the program, which are no part of the estimate.
    seconds : float or None
        Of the estimate, where the clock here cannot tell it.
    """

    normals: Floats
    width: Floats | Singles | float
    preparing: float = 0.0
    seconds: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """Points with noise, and the truth that they are judged by."""

    truth: Truth
    noise: Noise
    xyz: Floats


Estimating = Callable[[Load], Estimate]


@dataclass(slots=True, eq=False)
class Rival:
    """One method at one radius, run on one load again and again.

    Attributes
    ----------
    method, program : str
    radius : float
        Metres, as given to the program.
    estimate : callable
        Of the load; it gives an `Estimate`.
    load : Load
    sample : bools, optional
        Points that are estimated; all when left out.
    """

    method: str
    program: str
    radius: float
    estimate: Estimating
    load: Load
    sample: Bools | None = None
    seconds: list[float] = field(default_factory=list)
    preparing: list[float] = field(default_factory=list)
    omega: Singles = field(default_factory=lambda: np.empty(0, np.float32))
    width: Singles = field(default_factory=lambda: np.empty(0, np.float32))

    @property
    def name(self) -> str:
        """Unlike any other of the same load."""
        return f"{self.program} {self.method} {to_mm(self.radius):g}"

    def run(self) -> None:
        """Estimate the angles, and keep them and the seconds of this turn.

        The angle from the normal is part of everybody's work; bringing the points into the
        program is told apart.
        """
        truth = self.load.truth
        begun = perf_counter()
        made = self.estimate(self.load)
        spent = perf_counter() - begun - made.preparing
        begun = perf_counter()
        omega = incidence_angle(self.load.xyz, made.normals, truth.scanner)
        angle = perf_counter() - begun
        self.seconds.append((spent if made.seconds is None else made.seconds) + angle)
        self.preparing.append(made.preparing)
        self.omega = to_degrees(omega).astype(np.float32)
        self.width = np.broadcast_to(np.asarray(made.width, np.float32), omega.shape)

    @property
    def median_seconds(self) -> float:
        """Middle of the turns."""
        return median(self.seconds)

    @property
    def spread(self) -> float:
        """Slowest less fastest turn, as a share of the middle one; NaN after one turn."""
        if len(self.seconds) < 2:
            return float("nan")
        return (max(self.seconds) - min(self.seconds)) / self.median_seconds

    @property
    def judged(self) -> Bools:
        """Points by which the rival is judged."""
        truth = self.load.truth.judged
        return truth if self.sample is None else truth & self.sample

    def errors(self) -> Singles:
        """|ω − true ω| at the judged points, degrees; 90 where no angle was given."""
        judged = self.judged
        off = np.abs(self.omega[judged] - self.load.truth.omega[judged])
        found: Singles = np.where(np.isnan(off), 90.0, off).astype(np.float32)
        return found

    def undefined(self) -> float:
        """Share of the judged points without an angle."""
        return float(np.isnan(self.omega[self.judged]).mean())


def our_rival(load: Load, estimator: Estimator, radius: float, grid: bool = True) -> Rival:
    """One of our estimators; without a grid it finds its neighbours by voxels."""

    def estimate(load: Load) -> Estimate:
        cells = load.truth.grid if grid else None
        at = load.truth.scanner
        planes = local_planes(load.xyz, at, radius=radius, grid=cells, estimator=estimator)
        return Estimate(planes.normals, planes.width)

    method = estimator if estimator != "ball" else f"ball, {'grid' if grid else 'voxels'}"
    return Rival(method, OURS, radius, estimate, load)


def single_rival(load: Load, estimator: Estimator, radius: float) -> Rival:
    """The same of float32 coordinates, relative to the scanner as instruments store them."""
    near = (load.xyz - load.truth.scanner).astype(np.float32).astype(np.float64)
    single = Load(load.truth, load.noise, near + load.truth.scanner)
    rival = our_rival(single, estimator, radius)
    rival.method += ", float32 points"
    return rival
