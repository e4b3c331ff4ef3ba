"""One leaf: its angles from intensity against its plane, with their errors and its wrinkles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.neighbours.steps import Cells
from app.core.planes import DISTANCE, LeafPlane, leaf_plane
from app.core.synthetic_footprint import Lines
from app.core.wrinkles import Distribution, delta_omega, distribution
from app.core.wrinkling.claim import Calibration
from app.core.wrinkling.index import WrinkleIndex, find_index
from app.core.wrinkling.level import level_leaf
from app.core.wrinkling.means import average_leaf, measure_noise, noise_of_means
from app.core.wrinkling.offset import Offset, Scale, no_offset
from app.core.wrinkling.shape import Shape, name_shape
from app.core.wrinkling.validity import USUAL, Limits, PointAngles, invert_points

LEAST_SOLID = 10


@dataclass(frozen=True, slots=True, eq=False)
class LeafPoints:
    """What was measured of a leaf.

    Attributes
    ----------
    intensity : (k,)
        Corrected for range.
    xyz : (k, 3) metres
    scanner : (3,) metres
    diameter : float
        Of the beam at the leaf, metres.
    full, saturated : (k,) bools or None
        Points that the beam hits wholly; whose channel is at its end. None: not known.
    cells, lines
        Rows and columns, see `means.cut_grid`; None without a grid.
    ghosts : (k,) bools or None
        Points on no surface, known as such or marked: they are never valid, and no mean holds one.
    """

    intensity: Floats
    xyz: Floats
    scanner: AnyArray
    diameter: float
    full: Bools | None = None
    saturated: Bools | None = None
    cells: Cells | None = None
    lines: Lines | None = None
    ghosts: Bools | None = None

    @property
    def solid(self) -> Floats:
        """Places of the points that are no ghosts, (m, 3) metres."""
        return self.xyz if self.ghosts is None else self.xyz[~self.ghosts]

    @property
    def usable(self) -> Bools:
        """Points whose intensity is that of the leaf and nothing else."""
        found: Bools = np.isfinite(self.intensity)
        if self.full is not None:
            found = found & self.full
        for bad in (self.saturated, self.ghosts):
            if bad is not None:
                found = found & ~bad
        return found


@dataclass(frozen=True, slots=True)
class Choices:
    """How a leaf is judged.

    Attributes
    ----------
    means : bool
        Average over the footprint before inverting: over full hits that are neither saturated
        nor ghosts. A point that the beam hits in part is then valid by its neighbours' mean; a
        ghost is not, whatever its neighbours are.
    noise : float or None
        Of one intensity: a share of it on a linear scale, DN on a logarithmic one. None is
        measured on each leaf.
    limits : Limits
    gate : float
        Distance from the plane beyond which points are off it, metres.
    index : bool
        Find the wrinkle index too.
    """

    means: bool = True
    noise: float | None = None
    limits: Limits = USUAL
    gate: float = DISTANCE
    index: bool = True

    def __post_init__(self) -> None:
        if self.noise is not None and not 0.0 <= self.noise < np.inf:
            raise WrongUse(f"The noise of an intensity is a number from 0 on, not {self.noise}.")


@dataclass(frozen=True, slots=True, eq=False)
class JudgedLeaf:
    """Angles of one leaf; radians.

    Attributes
    ----------
    angles : PointAngles
    delta, sigma_delta, significance : (k,)
        Δω = ω_I − ω_plane, its error (that of the plane is in it), and their ratio.
    count : (k,)
        Points behind each mean; 1 without means.
    plane : LeafPlane
    offset : Offset
        That was used.
    noise : float
        Of one intensity, as `Choices.noise`.
    spread : Distribution or None
        Of Δω of the valid points; None without one.
    shape : str
        See `shape.RULE`.
    index : WrinkleIndex or None
    refusal : str
        Why there is no index.
    shift : float
        Angle of the leaf's mean intensity − ω_plane; NaN off the curve.
    """

    angles: PointAngles
    delta: Floats
    sigma_delta: Floats
    significance: Floats
    count: Ints
    plane: LeafPlane
    offset: Offset
    noise: float
    spread: Distribution | None
    shape: Shape
    index: WrinkleIndex | None
    refusal: str
    shift: float


def judge_leaf(
    points: LeafPoints, calibration: Calibration, choices: Choices | None = None
) -> JudgedLeaf:
    """Angles of a leaf from its intensity, and what they say about its shape.

    Raises
    ------
    BadInput
        The leaf has no plane, nobody knows its noise, or no offset can be found.
    """
    choices = choices or Choices()
    curve = calibration.curve
    solid = len(points.solid)
    if solid < LEAST_SOLID < len(points.xyz):
        raise BadInput(
            f"Only {solid} of {len(points.xyz)} points of the leaf are no ghosts.",
            "Keep those that are none under Ghosts, or scan the leaf from nearer.",
        )
    plane = leaf_plane(points.solid, points.scanner, choices.gate)
    usable = points.usable
    noise = _find_noise(points, usable, calibration, choices)
    values, count = _take_means(points, usable, choices)
    offset = calibration.offset or no_offset(curve.scale)
    if calibration.case == "levelled" and not calibration.own:
        level = values[np.isfinite(values) & usable]
        offset = level_leaf(level, curve, plane.incidence, plane.sigma, choices.limits.steepest)
    angles = invert_points(
        values, noise_of_means(noise, values, count, curve.scale), curve, offset,
        calibration.scatter, choices.limits, points.saturated,
        None if points.full is None else ~points.full & (count == 0 if choices.means else True),
        points.ghosts,
    )  # fmt: skip
    delta = delta_omega(angles.omega, plane.incidence)
    sigma = np.hypot(angles.sigma, plane.sigma if np.isfinite(plane.sigma) else 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        significance = delta / sigma
    valid = delta[angles.valid]
    spread = distribution(valid) if len(valid) else None
    index, refusal = _find_index(points, angles, plane, choices)
    return JudgedLeaf(
        angles, delta, sigma, significance, count, plane, offset, noise, spread,
        "too few points" if spread is None else name_shape(spread), index, refusal,
        _shift_of_mean(values[usable], calibration, offset, plane),
    )  # fmt: skip


def _find_noise(
    points: LeafPoints, usable: Bools, calibration: Calibration, choices: Choices
) -> float:
    if choices.noise is not None:
        return choices.noise
    scale = calibration.curve.scale
    found = measure_noise(points.intensity, points.xyz, points.scanner, scale, usable, points.cells)
    if not np.isfinite(found):
        raise BadInput(
            "The leaf has too few points that the beam hits wholly to measure its noise.",
            "Say the noise of the channel, or leave the leaf out.",
        )
    return found


def pool_noise(leaves: Sequence[LeafPoints], scale: Scale) -> float | None:
    """Noise of a channel, the median over leaves; None where no leaf can tell."""
    found = [
        measure_noise(leaf.intensity, leaf.xyz, leaf.scanner, scale, leaf.usable, leaf.cells)
        for leaf in leaves
    ]
    known = [noise for noise in found if np.isfinite(noise)]
    return float(np.median(known)) if known else None


def _take_means(points: LeafPoints, usable: Bools, choices: Choices) -> tuple[Floats, Ints]:
    if not choices.means:
        return np.asarray(points.intensity, np.float64), np.ones(len(points.xyz), np.int64)
    found = average_leaf(
        points.intensity, points.xyz, points.scanner, points.diameter, usable, points.cells,
        points.lines,
    )  # fmt: skip
    return found.values, found.count


def _find_index(
    points: LeafPoints, angles: PointAngles, plane: LeafPlane, choices: Choices
) -> tuple[WrinkleIndex | None, str]:
    if not choices.index:
        return None, "not asked for"
    taken = angles.valid if points.full is None else angles.valid & points.full
    omega = np.where(taken, angles.omega, np.nan)
    try:
        flat = lay_flat(points.xyz, plane)
        return find_index(omega, angles.parts["noise"], flat, points.diameter), ""
    except BadInput as error:
        return None, str(error)


def lay_flat(xyz: Floats, plane: LeafPlane) -> Floats:
    """Places of points in a leaf's plane, (k, 2) metres about its point."""
    across = np.cross(plane.normal, np.eye(3)[np.argmin(np.abs(plane.normal))])
    across /= np.linalg.norm(across)
    axes = np.stack([across, np.cross(plane.normal, across)], axis=1)
    return np.asarray((xyz - plane.point) @ axes, np.float64)


def _shift_of_mean(
    values: Floats, calibration: Calibration, offset: Offset, plane: LeafPlane
) -> float:
    # Balduzzi's shifts (+13°, +5°, +9°, −10°, −8°): a curved leaf is not its plane.
    known = values[np.isfinite(values)]
    if not len(known):
        return float("nan")
    mean = offset.remove(np.array([known.mean()]))
    return float(calibration.curve.invert(mean)[0] - plane.incidence)
