"""The plane of a whole leaf: regression after Balduzzi, robust, total least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, finite_rows
from app.core.errors import BadInput
from app.core.incidence import incidence_angle
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
        the plane.
    outlier_share : float
        Share of points farther than d_l across the plane.
    method : str
        'LSR z on x,y', 'LSR y on x,z', 'LSR x on y,z', 'TLS' or 'robust'.
    incidence : float
        Radians, at `point`; NaN without a scanner.
    warning : str
        Empty, or a sentence: no regression kept 95 % of the points within d_l.
    """

    normal: Floats
    point: Floats
    rmse: float
    outlier_share: float
    method: str
    incidence: float
    warning: str = ""


def leaf_plane(xyz: Floats, scanner: AnyArray | None, d_l: float = DISTANCE) -> LeafPlane:
    """Plane of a leaf by three regressions, each axis on the two others (Balduzzi 2.3.2).

    The smallest RMSE wins among those that leave at most 5 % of the points farther than
    `d_l` from the plane. When none does, the leaf is bent, or points of something else are
    among its members: then a robust plane through most of them is taken if they lie much
    nearer to it, else the regression with the smallest RMSE; both with a warning.

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
    centre, offsets = _centred(xyz)
    fits = [
        fit
        for name, axis in REGRESSIONS
        if (fit := _regress(offsets, axis, name, centre, scanner, d_l)) is not None
    ]
    kept = [fit for fit in fits if fit.outlier_share <= MOST_OUTLIERS]
    best = min(kept or fits, key=lambda fit: fit.rmse)
    if not kept:
        best = _prefer_robust(best, offsets, centre, scanner, d_l)
    _refuse_other_shapes(best, offsets + (centre - best.point), d_l)
    return best


def _prefer_robust(
    regression: LeafPlane, offsets: Floats, centre: Floats, scanner: AnyArray | None, d_l: float
) -> LeafPlane:
    normal, near = robust_normal(offsets, d_l)
    middle = offsets[near].mean(axis=0)
    across = np.abs((offsets - middle) @ normal)
    if np.median(across) > MUCH_NEARER * np.median(np.abs(offsets @ regression.normal)):
        return regression
    rmse = float(np.sqrt(np.mean(across[near] ** 2)))
    return _plane(normal, offsets - middle, "robust", rmse, centre + middle, scanner, d_l)


def _refuse_other_shapes(plane: LeafPlane, offsets: Floats, d_l: float) -> None:
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
    centre, offsets = _centred(xyz)
    normal = np.linalg.svd(offsets, full_matrices=False)[2][2]
    rmse = float(np.sqrt(np.mean((offsets @ normal) ** 2)))
    return _plane(normal, offsets, "TLS", rmse, centre, scanner, d_l)


def _centred(xyz: Floats) -> tuple[Floats, Floats]:
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
    return _plane(normal, offsets, f"LSR {name}", rmse, centre, scanner, d_l)


def _plane(
    normal: Floats, offsets: Floats, method: str, rmse: float,
    centre: Floats, scanner: AnyArray | None, d_l: float,
) -> LeafPlane:  # fmt: skip
    incidence = np.nan
    if scanner is not None:
        beam = np.asarray(scanner, dtype=np.float64) - centre
        normal = -normal if normal @ beam < 0.0 else normal
        incidence = float(incidence_angle(centre[None], normal[None], scanner)[0])
    share = float(np.mean(np.abs(offsets @ normal) > d_l))
    warning = ""
    if share > MOST_OUTLIERS:
        warning = f"{share:.0%} of the points lie farther than {d_l} m from the leaf's plane."
    return LeafPlane(normal, centre, rmse, share, method, incidence, warning)
