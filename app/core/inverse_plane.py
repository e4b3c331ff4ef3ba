"""The plane of a leaf, for noise that lies along the beam.

A plane is 1 / z = α + β a + γ b, linear in the tangents a, b of the beams about the one to the
leaf's middle; z is the depth along that beam. Tangents are known, only z is noisy: weighted by
z², the regression is that of the ranges (nearest published idea: Badino, Huber, Park, Kanade
2011, for small windows). Regressions and total least squares of x, y, z take the noise along
the beam for noise across the plane, which turns a tilted plane towards 0 or 90°.

A bent leaf is no plane, and the regression of its ranges leans to where it is steep. Where a
second degree in a, b explains the ranges better (Schwarz 1978), the plane is the one of least
squared distances to that smooth surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.planes import DISTANCE, LeafPlane, centre_points, make_plane, refuse_other_shapes
from app.core.robust_plane import MEDIAN_TO_SIGMA, robust_normal

CUT = 3.0
"""σ of the range beyond which a point is not of the leaf."""
ROUNDING = 1e-4
"""Share of d_l: a residual as small is no reason to leave a point out."""
PASSES = 10
MARKED = 1.25
"""The second degree must lower the sum of squares by this factor: the rim of a flat leaf, where
beams lie on it in part, bends it a little."""
PLANE, BENT = 3, 6
"""Terms of the first and the second degree."""
FEWEST = 2 * BENT
"""Points below which a leaf is not taken to be bent, nor cut smaller."""
LEFT = 0.2
"""Share of the points that must stay when the rim is left out."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Points as seen from the scanner, along the beam to the leaf's middle.

    Attributes
    ----------
    terms : (k, 6)
        1, a, b, a², ab, b²; a and b about their middle and of the size of 1.
    beams : (k, 3)
        Directions in scanner axes, of depth 1.
    depth : (k,)
        Metres.
    size : float
        Radians (tangent) that are 1 in `terms`.
    """

    terms: Floats
    beams: Floats
    depth: Floats
    size: float


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Inverse depth as a polynomial of the tangents, and the points that follow it.

    `depth` is that of the polynomial at every point, infinite where it has none.
    """

    depth: Floats
    kept: Bools


def inverse_range_plane(
    xyz: Floats, scanner: AnyArray, d_l: float = DISTANCE, rim: float = 0.0
) -> LeafPlane:
    """Plane of a leaf by regression of its inverse range on the beam's directions.

    Begins with the points near the robust plane; then those stay that lie within 3 σ along the
    beam, σ from the median residual.

    Parameters
    ----------
    xyz : (k, 3) metres
        Rows that are not finite are left out.
    scanner : (3,) metres
    d_l : float
        Metres across the plane: where the search begins, and what counts as an outlier in the end.
    rim : float
        Radians: width of a beam as seen from the scanner, its footprint over its range. Points so
        near to the convex outline are left out, if a fifth of the points stays: beams that a leaf
        catches in part end on its rim, beside where they point to, and flatten it.

    Returns
    -------
    LeafPlane
        'inverse range', or 'inverse range, bent'.

    Raises
    ------
    BadInput
        As `planes.leaf_plane` does.
    """
    centre, offsets = centre_points(xyz)
    near = robust_normal(offsets, d_l)[1]
    away = centre - np.asarray(scanner, np.float64)
    view = _look(offsets, away, near)
    if rim > 0.0:
        inside = _find_inside(view, near, rim)
        offsets, near = offsets[inside], near[inside]
        view = _look(offsets, away, near)
    surface, method = _fit_surface(view, near & (view.depth > 0.0), ROUNDING * d_l)
    smooth = view.beams[surface.kept] * surface.depth[surface.kept, None]
    normal = np.linalg.svd(smooth - smooth.mean(axis=0), full_matrices=False)[2][2]
    middle = offsets[surface.kept].mean(axis=0)
    around = offsets - middle
    rmse = float(np.sqrt(np.mean((around[surface.kept] @ normal) ** 2)))
    place = centre + middle
    plane = make_plane(normal, around, method, rmse, place, scanner, d_l, surface.kept)
    refuse_other_shapes(plane, around, d_l)
    return plane


def _look(offsets: Floats, centre: Floats, near: Bools) -> View:
    points = centre + offsets
    ahead = centre + offsets[near].mean(axis=0)
    ahead /= np.linalg.norm(ahead)
    side, up = np.linalg.svd(ahead[None])[2][1:]
    depth = points @ ahead
    with np.errstate(divide="ignore", invalid="ignore"):
        beams = points / depth[:, None]
    a, b = beams @ side, beams @ up
    a, b = (t - t[near].mean() for t in (a, b))
    size = float(np.hypot(a[near], b[near]).max()) or 1.0
    a, b = a / size, b / size
    return View(np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1), beams, depth, size)


def _find_inside(view: View, near: Bools, rim: float) -> Bools:
    """Points farther than `rim` from the outline of those near; all, where too few would be."""
    from scipy.spatial import ConvexHull, QhullError

    places = view.terms[:, 1:3] * view.size
    try:
        sides = ConvexHull(places[near]).equations
    except QhullError:
        return np.ones(len(near), np.bool_)
    inside = np.asarray((places @ sides[:, :2].T + sides[:, 2] < -rim).all(axis=1))
    left = int((inside & near).sum())
    enough = left >= max(FEWEST, LEFT * int(near.sum()))
    return inside if enough else np.ones(len(near), np.bool_)


def _fit_surface(view: View, near: Bools, least: float) -> tuple[Surface, str]:
    surface = _fit(view, near, PLANE, least)
    if not _is_bent(view, surface.kept):
        return surface, "inverse range"
    return _fit(view, surface.kept, BENT, least), "inverse range, bent"


def _fit(view: View, kept: Bools, count: int, least: float) -> Surface:
    depth = view.depth
    for _ in range(PASSES):
        depth = _regress(view, kept, count, depth)
        off = np.abs(view.depth - depth)
        reach = max(least, CUT * MEDIAN_TO_SIGMA * float(np.median(off[kept])))
        chosen = off <= reach
        if (chosen == kept).all() or chosen.sum() < count:
            break
        kept = chosen
    return Surface(depth, kept)


def _regress(view: View, kept: Bools, count: int, weight: Floats) -> Floats:
    """Depth of the polynomial at all points; weighted by a depth, for ∂(1/z) = −∂z / z²."""
    heavy = weight[kept]
    terms = view.terms[:, :count]
    wanted = heavy / view.depth[kept]
    solution = np.linalg.lstsq(terms[kept] * heavy[:, None], wanted, rcond=1e-9)[0]
    inverse = terms @ solution
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(inverse > 0.0, 1.0 / inverse, np.inf))


def _is_bent(view: View, kept: Bools) -> bool:
    """Whether the second degree lowers Schwarz's criterion over the same points."""
    points = int(kept.sum())
    if points < FEWEST:
        return False
    squares = []
    for count in (PLANE, BENT):
        off = (view.depth - _regress(view, kept, count, view.depth))[kept]
        squares.append(float(off @ off))
    plane, bent = squares
    # Rounding alone, of a perfect plane, has no degree.
    if plane <= points * (ROUNDING * DISTANCE) ** 2:
        return False
    better = points * np.log(plane / max(bent, np.finfo(float).tiny))
    return plane > MARKED * bent and bool(better > (BENT - PLANE) * np.log(points))
