"""Local planes and the angle at which the beam meets them (Junttila 2016, 2.6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal, get_args

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints, read_only
from app.core.ball import BallPlanes, fit_balls
from app.core.chunks import run_in_pieces, split_evenly
from app.core.errors import WrongUse
from app.core.neighbours.asked import as_points, each_once
from app.core.neighbours.steps import Cells, ScanGrid, UnusableGrid, as_cells
from app.core.normals import adaptive, robust, window
from app.core.normals.image import ImagePlanes, fit_image
from app.core.progress import QUIET, Progress

RADIUS = 0.004
Estimator = Literal["adaptive", "robust", "window", "ball"]
ESTIMATORS: tuple[Estimator, ...] = get_args(Estimator)
"""Ways to find a plane: see `app.core.normals`, and `app.core.ball` for what others use."""
RULES = {
    "adaptive": adaptive.make_rules,
    "robust": robust.make_rules,
    "window": window.make_rules,
}
PIECE = 200_000
Way = Literal["image", "cells", "voxels"]
WAYS: tuple[Way, ...] = get_args(Way)
"""Estimators on the range image; balls on a scan grid; balls in voxels."""


@dataclass(frozen=True, slots=True, eq=False)
class LocalPlanes:
    """A plane at each asked point.

    Attributes
    ----------
    normals : (k, 3)
        Unit vectors towards the scanner's side; NaN where no plane is defined.
    count : (k,) int32
        Points in the window or ball, the point itself included.
    width : (k,) float32, metres
        Half-width of the window, or radius of the ball, that was used; 0 where there is none.
        A window reaches 18 cells to either side at most.
    rms : (k,) float32, metres
        Root mean square distance of these points from the plane.
    sigma : (k,) float32, radians
        Standard error of the angle of incidence, from the residuals, the geometry and the
        bend of the surface around; of balls without the bend, so that it is rather too small.
        NaN where it cannot be told.
    estimator : {'adaptive', 'robust', 'window', 'ball'}
        What was used.
    balls : int
        Points that a ball was fitted to, all or those that no window could be laid around.
    method : {'scan grid', 'voxel hash'}
    reason : str
        Why this method was taken.
    seconds : dict
        'neighbours' (sorting) and 'planes' (windows and fits), without compilation.
    """

    normals: Floats
    count: AnyArray
    width: AnyArray
    rms: AnyArray
    sigma: AnyArray
    estimator: Estimator
    balls: int
    method: str
    reason: str
    seconds: dict[str, float]


def incidence_angle(xyz: Floats, normals: Floats, scanner: AnyArray) -> Floats:
    """Angle between the beam and the normal.

    Parameters
    ----------
    xyz, normals : (k, 3)
        Points in metres, and a normal at each (of any sign).
    scanner : (3,) metres

    Returns
    -------
    (k,) radians, 0 to π/2
        atan2(|P × N|, |P · N|): arccos would lose half its digits near 0. NaN where the
        normal is NaN or the point lies at the scanner.
    """
    from app.core.kernels.incidence import measure_angles

    points, given = as_points(xyz), as_points(normals)
    origin = np.array(scanner, dtype=np.float64)
    angle: Floats = np.empty(len(points))

    def work(first: int, last: int) -> None:
        measure_angles(points, given, origin, first, last, angle)

    run_in_pieces(work, split_evenly(len(points), PIECE))
    return angle


def local_planes(
    xyz: Floats,
    scanner: AnyArray,
    points: Ints | None = None,
    radius: float = RADIUS,
    grid: ScanGrid | None = None,
    progress: Progress = QUIET,
    estimator: Estimator = "adaptive",
) -> LocalPlanes:
    """Fit a plane at each asked point.

    The estimators 'adaptive', 'robust' and 'window' need the scan grid, and that its rows and
    columns follow the beams; without it all is done by 'ball'. So it is for points that share
    a cell with a nearer one, near a pole, and where the step from row to row changes.

    Parameters
    ----------
    xyz : (n, 3) metres, world
    scanner : (3,) metres
    points : (k,) or None
        Numbers of the points asked for; None means all. Work is proportional to them.
    radius : float
        Metres: half-width of a window, or radius of a ball. 'adaptive' takes it as the least
        half-width, and up to twice as much where nothing speaks against it.
    grid : ScanGrid or None
    progress : Progress
    estimator : {'adaptive', 'robust', 'window', 'ball'}

    Raises
    ------
    BadInput
        The grid belongs to other points.
    WrongUse
        The radius is not positive, a point number does not exist, or the estimator.
    Cancelled
    """
    _check(radius, estimator)
    xyz, scanner = as_points(xyz), np.array(scanner, dtype=np.float64)
    asked, where = each_once(points, len(xyz))
    progress.report(0.0, "local planes")
    refusal = ""
    if grid is not None and estimator != "ball":
        try:
            found = _fit_on_image(xyz, scanner, grid, asked, radius, progress, estimator)
        except UnusableGrid as error:
            refusal = str(error)
        else:
            return LocalPlanes(
                found.normals[where], found.count[where], found.width[where], found.rms[where],
                found.sigma[where], estimator, len(found.left), "scan grid",
                "rows and columns are known", found.seconds,
            )  # fmt: skip
    warm_up("voxels" if grid is None else "cells")
    balls = fit_balls(xyz, scanner, grid, asked, radius, progress)
    return LocalPlanes(
        balls.normals[where], balls.count[where], balls.width[where], balls.rms[where],
        _error_of_balls(balls)[where], "ball", len(balls.count), balls.method,
        refusal or balls.reason, balls.seconds,
    )  # fmt: skip


def _check(radius: float, estimator: Estimator) -> None:
    if not (0.0 < radius < np.inf):
        raise WrongUse(f"The radius must be positive, not {radius} m.")
    if estimator not in ESTIMATORS:
        raise WrongUse(f"There is no estimator {estimator!r}; take {', '.join(ESTIMATORS)}.")


def _fit_on_image(
    xyz: Floats, scanner: Floats, grid: ScanGrid, asked: Ints | None, radius: float,
    progress: Progress, estimator: Estimator,
) -> ImagePlanes:  # fmt: skip
    warm_up("image")
    found = fit_image(xyz, scanner, as_cells(grid), asked, radius, RULES[estimator], progress)
    _fit_left(found, xyz, scanner, grid, asked, radius)
    return found


def _fit_left(
    found: ImagePlanes, xyz: Floats, scanner: Floats, grid: ScanGrid,
    asked: Ints | None, radius: float,
) -> None:  # fmt: skip
    """Balls for the points that no window was laid around."""
    if not len(found.left):
        return
    warm_up("cells")
    numbers = found.left if asked is None else asked[found.left]
    balls = fit_balls(xyz, scanner, grid, numbers, radius, QUIET)
    found.normals[found.left] = balls.normals
    found.count[found.left] = balls.count
    found.width[found.left] = balls.width
    found.rms[found.left] = balls.rms
    found.sigma[found.left] = _error_of_balls(balls)
    for step, seconds in balls.seconds.items():
        found.seconds[step] += seconds


def _error_of_balls(balls: BallPlanes) -> AnyArray:
    """Standard error of the angle, radians: points spread evenly over a disc, bends unknown."""
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = 0.5 * balls.width * np.sqrt(np.maximum(balls.count - 3, 1))
        sigma: AnyArray = (balls.rms / spread).astype(np.float32)
    sigma[balls.count <= 3] = np.nan  # three points fit any plane, and tell no noise
    return sigma


@cache
def warm_up(way: Way) -> None:
    """Compile, or load, the kernels of one way once, so that no measured second holds it."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:4, :4])
    xyz = read_only(np.stack([np.ones(16), column / 1000.0, row / 1000.0], axis=1))
    cells = as_cells(Cells(4, 4, row, column))
    scanner, asked = np.zeros(3), np.arange(3)
    if way == "image":
        fit_image(xyz, scanner, cells, asked, RADIUS, adaptive.make_rules)
    else:
        fit_balls(xyz, scanner, cells if way == "cells" else None, asked, RADIUS, QUIET)
    incidence_angle(xyz[:3], xyz[:3], scanner)
