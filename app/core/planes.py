"""The plane of a whole leaf: regression after Balduzzi, robust, total least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, finite_rows
from app.core.errors import BadInput
from app.core.incidence import incidence_angle
from app.core.plane_error import error_of_angle
from app.core.robust_plane import MEDIAN_TO_SIGMA, SIGMAS, robust_normal

DISTANCE = 0.005
MOST_OUTLIERS = 0.05
FLAT = 1e-10
"""Below this ratio of the two larger variances the points lie on one line."""
THICK = 4.0
"""A plane's points vary along it, both ways, by this much more than across (variances)."""
MUCH_NEARER = 0.5
"""The robust plane wins where its median distance is this share of the regression's."""
REGRESSIONS = (("z on x,y", 2), ("y on x,z", 1), ("x on y,z", 0))


@dataclass(frozen=True, slots=True, eq=False)
class LeafPlane:
    """A plane, and how well it stands for the leaf.

    Attributes
    ----------
    normal : (3,)
        Unit vector towards the scanner, where there is one.
    point : (3,) metres
        A point of the plane: the mean of the leaf's points.
    rmse : float
        Metres: residual of the regression along its axis, for total least squares across
        the plane, for the others too, of the points that they keep.
    outlier_share : float
        Share of points farther than d_l across the plane.
    method : str
        'LSR z on x,y', 'LSR y on x,z', 'LSR x on y,z', 'TLS', 'robust', 'inverse range' or
        'inverse range, bent'.
    incidence : float
        Radians, at `point`; NaN without a scanner.
    warning : str
        Empty, or a sentence: no regression kept 95 % of the points within d_l.
    sigma : float
        Radians: standard error of `incidence`, see `plane_error.error_of_angle`; it knows of
        noise and wrinkles, not of a method's bias. NaN without a scanner.
    """

    normal: Floats
    point: Floats
    rmse: float
    outlier_share: float
    method: str
    incidence: float
    warning: str = ""
    sigma: float = float("nan")


def leaf_plane(xyz: Floats, scanner: AnyArray | None, d_l: float = DISTANCE) -> LeafPlane:
    """Plane of a leaf by three regressions, or a robust one where they fail.

    `regression_plane`; when it leaves more than 5 % of the points out, the leaf is bent, or
    points of something else are among its members: then a robust plane through most of them is
    taken if they lie much nearer to it. Both come with a warning then.

    Parameters
    ----------
    xyz : (k, 3) metres
        Rows that are not finite are left out.
    scanner : (3,) metres or None
    d_l : float
        Metres.

    Raises
    ------
    BadInput
        Fewer than three finite points, all along one line, or spread in all directions.
    """
    centre, offsets = centre_points(xyz)
    best = _choose_regression(offsets, centre, scanner, d_l)
    if best.outlier_share > MOST_OUTLIERS:
        best = _prefer_robust(best, offsets, centre, scanner, d_l)
    refuse_other_shapes(best, offsets + (centre - best.point), d_l)
    return best


def regression_plane(
    xyz: Floats, scanner: AnyArray | None = None, d_l: float = DISTANCE
) -> LeafPlane:
    """Plane by three regressions, each axis on the two others (Balduzzi 2011, 2.3.2).

    The smallest RMSE wins among those that leave at most 5 % of the points farther than `d_l`
    from the plane; among all, with a warning, when none does. See `leaf_plane`.
    """
    centre, offsets = centre_points(xyz)
    return _choose_regression(offsets, centre, scanner, d_l)


def _choose_regression(
    offsets: Floats, centre: Floats, scanner: AnyArray | None, d_l: float
) -> LeafPlane:
    fits = [
        fit
        for name, axis in REGRESSIONS
        if (fit := _regress(offsets, axis, name, centre, scanner, d_l)) is not None
    ]
    kept = [fit for fit in fits if fit.outlier_share <= MOST_OUTLIERS]
    return min(kept or fits, key=lambda fit: fit.rmse)


def robust_plane(xyz: Floats, scanner: AnyArray | None = None, d_l: float = DISTANCE) -> LeafPlane:
    """Plane that up to half of the points may contradict: see `robust_plane.robust_normal`.

    Least median of squares (Rousseeuw 1984), then total least squares of the points near it.
    Raises as `leaf_plane` does.
    """
    centre, offsets = centre_points(xyz)
    plane = _fit_robust(offsets, centre, scanner, d_l)
    refuse_other_shapes(plane, offsets + (centre - plane.point), d_l)
    return plane


def _fit_robust(offsets: Floats, centre: Floats, scanner: AnyArray | None, d_l: float) -> LeafPlane:
    normal, near = robust_normal(offsets, d_l)
    middle = offsets[near].mean(axis=0)
    around = offsets - middle
    rmse = float(np.sqrt(np.mean((around[near] @ normal) ** 2)))
    return make_plane(normal, around, "robust", rmse, centre + middle, scanner, d_l, near)


def _prefer_robust(
    regression: LeafPlane, offsets: Floats, centre: Floats, scanner: AnyArray | None, d_l: float
) -> LeafPlane:
    robust = _fit_robust(offsets, centre, scanner, d_l)
    across = np.abs((offsets + (centre - robust.point)) @ robust.normal)
    if np.median(across) > MUCH_NEARER * np.median(np.abs(offsets @ regression.normal)):
        return regression
    return robust


def refuse_other_shapes(plane: LeafPlane, offsets: Floats, d_l: float) -> None:
    """Raise `BadInput` where the points about a plane lie along a line or everywhere."""
    across = np.abs(offsets @ plane.normal)
    near = offsets[across <= max(d_l, SIGMAS * MEDIAN_TO_SIGMA * float(np.median(across)))]
    spread = np.linalg.svd(near - near.mean(axis=0), compute_uv=False) ** 2
    if len(near) > 3 and spread[1] <= THICK * spread[2]:
        raise BadInput(
            f"The {len(offsets)} points of the leaf spread along a line or in all directions: "
            "they have no plane.",
            "Select the points of one leaf.",
        )


def total_least_squares_plane(
    xyz: Floats, scanner: AnyArray | None = None, d_l: float = DISTANCE
) -> LeafPlane:
    """Plane with the smallest sum of squared distances across it; see `leaf_plane`."""
    centre, offsets = centre_points(xyz)
    normal = np.linalg.svd(offsets, full_matrices=False)[2][2]
    rmse = float(np.sqrt(np.mean((offsets @ normal) ** 2)))
    return make_plane(normal, offsets, "TLS", rmse, centre, scanner, d_l)


def centre_points(xyz: Floats) -> tuple[Floats, Floats]:
    """Mean of the finite points, and the points about it."""
    points = xyz[finite_rows(xyz)]
    if len(points) < 3:
        raise BadInput(
            f"A plane needs three points; {len(points)} of the leaf have coordinates.",
            "Select more points.",
        )
    offsets = points - points[0]
    mean = offsets.mean(axis=0)
    offsets -= mean
    variances = np.linalg.svd(offsets, compute_uv=False) ** 2
    blur = len(points) * (4.0 * np.finfo(np.float64).eps * np.abs(points).max()) ** 2
    if variances[1] <= max(FLAT * variances[0], blur):
        raise BadInput(
            f"The {len(points)} points of the leaf lie on one line: they have no plane.",
            "Select an area, not a row of points.",
        )
    return points[0] + mean, offsets


def _regress(
    offsets: Floats, axis: int, name: str, centre: Floats, scanner: AnyArray | None, d_l: float
) -> LeafPlane | None:
    """Regression of one axis; None where the plane holds that axis and has no slope."""
    others = np.delete(offsets, axis, axis=1)
    slopes, _, rank, _ = np.linalg.lstsq(others, offsets[:, axis], rcond=1e-12)
    if rank < 2:
        return None
    residual = offsets[:, axis] - others @ slopes
    normal = np.insert(-slopes, axis, 1.0)
    normal /= np.linalg.norm(normal)
    rmse = float(np.sqrt(np.mean(residual**2)))
    return make_plane(normal, offsets, f"LSR {name}", rmse, centre, scanner, d_l)


def make_plane(
    normal: Floats, offsets: Floats, method: str, rmse: float,
    centre: Floats, scanner: AnyArray | None, d_l: float, members: Bools | None = None,
) -> LeafPlane:  # fmt: skip
    """A plane through a centre, about which the points are given; σ is that of its members."""
    incidence, sigma = np.nan, np.nan
    if scanner is not None:
        beam = np.asarray(scanner, dtype=np.float64) - centre
        normal = -normal if normal @ beam < 0.0 else normal
        incidence = float(incidence_angle(centre[None], normal[None], scanner)[0])
        sigma = error_of_angle(offsets if members is None else offsets[members], normal, beam)
    share = float(np.mean(np.abs(offsets @ normal) > d_l))
    warning = ""
    if share > MOST_OUTLIERS:
        warning = f"{share:.0%} of the points lie farther than {d_l} m from the leaf's plane."
    return LeafPlane(normal, centre, rmse, share, method, incidence, warning, sigma)
