"""Total least squares plane of the points in a ball: sums, and the direction they spread least.

Planes are solved `LANES` at a time: the same arithmetic on all, without a branch, is what the
processor does eight at once. The few that it cannot solve well go through Jacobi's method.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import INNER, SAFE

SUMS = 10
"""Number of points, sums of x, y, z, and of xx, xy, xz, yy, yz, zz."""
LANES = 16
PLANES = 6
"""Normal, rms distance, whether the points cover an area, whether the rest is to be trusted."""
COLLINEAR = 1e-10
SWEEPS = 12
STEPS = 8
APART = 1e-2
"""Least (λ₂ − λ₁)(λ₃ − λ₁) / trace² for the closed form: its error is 10⁻¹⁵ over the square."""
SETTLED = 1e-8
"""Largest last step of Newton's method, which about squares its error at each step."""
LEAST_SPREAD = 0.02
"""Smallest standard deviation across the beam, in radii; a dense surface has 0.5 cos ω."""
EPSILON = float(np.finfo(np.float64).eps)
TINY = float(np.finfo(np.float64).tiny)


@njit(**INNER)
def pick(
    px: float, py: float, pz: float, x: float, y: float, z: float, limit: float
) -> tuple[float, ...]:
    """1 and the offset from p where it is no longer than √limit; four zeros elsewhere."""
    dx, dy, dz = x - px, y - py, z - pz
    near = dx * dx + dy * dy + dz * dz <= limit
    return 1.0 if near else 0.0, dx if near else 0.0, dy if near else 0.0, dz if near else 0.0


@njit(**INNER, fastmath=SAFE)
def sum_ball(
    points: AnyArray, total: int, px: float, py: float, pz: float, limit: float
) -> tuple[float, ...]:
    """Count and moments of the first `total` points (3, m) within √limit of p, about p.

    Moments about the point itself stay exact at coordinates of 10⁶ m.
    """
    n = sx = sy = sz = xx = xy = xz = yy = yz = zz = 0.0
    for k in range(total):
        near, dx, dy, dz = pick(px, py, pz, points[0, k], points[1, k], points[2, k], limit)
        n += near
        sx += dx
        sy += dy
        sz += dz
        xx += dx * dx
        xy += dx * dy
        xz += dx * dz
        yy += dy * dy
        yz += dy * dz
        zz += dz * dz
    return n, sx, sy, sz, xx, xy, xz, yy, yz, zz


@njit(**INNER)
def _turn(pp: float, qq: float, pq: float, pr: float, qr: float) -> tuple[float, ...]:
    """Jacobi rotation that makes pq zero: new pp, qq, pr, qr, and its cosine and sine."""
    if pq == 0.0:
        return pp, qq, pr, qr, 1.0, 0.0
    ratio = (qq - pp) / (2.0 * pq)
    tangent = 1.0 / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
    if ratio < 0.0:
        tangent = -tangent
    c = 1.0 / math.sqrt(tangent * tangent + 1.0)
    s = tangent * c
    return pp - tangent * pq, qq + tangent * pq, c * pr - s * qr, s * pr + c * qr, c, s


@njit(cache=True, nogil=True)
def smallest_axis(a: float, d: float, e: float, b: float, f: float, c: float) -> tuple[float, ...]:
    """Eigenvector of the smallest eigenvalue of [[a d e] [d b f] [e f c]], by cyclic Jacobi.

    Returns the vector and the three eigenvalues in rising order. Closed formulas lose half
    of the digits where two eigenvalues nearly coincide; Jacobi does not.
    """
    u0, u1, u2, v0, v1, v2, w0, w1, w2 = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    small = 1e-18 * (a + b + c)
    for _ in range(SWEEPS):
        if abs(d) + abs(e) + abs(f) <= small:
            break
        a, b, e, f, k, s = _turn(a, b, d, e, f)
        d = 0.0
        u0, v0 = k * u0 - s * v0, s * u0 + k * v0
        u1, v1 = k * u1 - s * v1, s * u1 + k * v1
        u2, v2 = k * u2 - s * v2, s * u2 + k * v2
        a, c, d, f, k, s = _turn(a, c, e, d, f)
        e = 0.0
        u0, w0 = k * u0 - s * w0, s * u0 + k * w0
        u1, w1 = k * u1 - s * w1, s * u1 + k * w1
        u2, w2 = k * u2 - s * w2, s * u2 + k * w2
        b, c, d, e, k, s = _turn(b, c, f, d, e)
        f = 0.0
        v0, w0 = k * v0 - s * w0, s * v0 + k * w0
        v1, w1 = k * v1 - s * w1, s * v1 + k * w1
        v2, w2 = k * v2 - s * w2, s * v2 + k * w2
    low, high = min(a, b, c), max(a, b, c)
    middle = max(min(a, b), min(max(a, b), c))
    if a == low:
        return u0, u1, u2, low, middle, high
    if b == low:
        return v0, v1, v2, low, middle, high
    return w0, w1, w2, low, middle, high


@njit(**INNER, fastmath={"contract"}, forceinline=True)
def covers(n: float, cov: tuple[float, ...], bx: float, by: float, bz: float, width: float) -> bool:
    """Whether `n` points spread in two directions as seen along the beam b.

    Where columns lie far apart a ball may hold points of one column only. Their noise along
    the beam then passes for a second direction, and every such plane seems edge-on.
    """
    xx, xy, xz, yy, yz, zz = cov
    # Trace and determinant of the covariance projected along the beam; the latter through
    # the adjugate.
    length = bx * bx + by * by + bz * bz
    along = bx * bx * xx + by * by * yy + bz * bz * zz
    along += 2.0 * (bx * by * xy + bx * bz * xz + by * bz * yz)
    trace = xx + yy + zz - along / length
    det = bx * bx * (yy * zz - yz * yz) + by * by * (xx * zz - xz * xz)
    det += bz * bz * (xx * yy - xy * xy) + 2.0 * bx * by * (xz * yz - xy * zz)
    det += 2.0 * bx * bz * (xy * yz - xz * yy) + 2.0 * by * bz * (xy * xz - xx * yz)
    least = (LEAST_SPREAD * width) ** 2 * trace
    return (n >= 3.0) & (det / length >= least) & (trace > 0.0)


@njit(**INNER, fastmath={"contract"}, forceinline=True)
def covariance(
    n: float, sx: float, sy: float, sz: float, xx: float, xy: float, xz: float, yy: float,
    yz: float, zz: float,
) -> tuple[float, ...]:  # fmt: skip
    """Upper triangle of the covariance, row by row, from the sums of `sum_ball`."""
    share = 1.0 / max(n, 1.0)
    mx, my, mz = sx * share, sy * share, sz * share
    return (
        xx * share - mx * mx, xy * share - mx * my, xz * share - mx * mz,
        yy * share - my * my, yz * share - my * mz, zz * share - mz * mz,
    )  # fmt: skip


@njit(**INNER, fastmath={"contract"}, forceinline=True)
def least_root(a: float, d: float, e: float, b: float, f: float, c: float) -> tuple[float, ...]:
    """Smallest eigenvalue of [[a d e] [d b f] [e f c]], the last step towards it, the slope.

    It is the smallest root of the characteristic cubic. From 0 Newton's method rises to it and
    never beyond, because the cubic is concave there.
    """
    minors = a * b - d * d + (a * c - e * e) + (b * c - f * f)
    cube = a * (b * c - f * f) - d * (d * c - e * f) + e * (d * f - e * b)
    total = a + b + c
    low, step, slope = 0.0, 0.0, 1.0
    for _ in range(STEPS):
        slope = (3.0 * low - 2.0 * total) * low + minors
        step = (((low - total) * low + minors) * low - cube) / slope
        low -= step
    return low, step, slope


@njit(**INNER, fastmath={"contract"}, forceinline=True)
def longest_cross(
    a: float, d: float, e: float, b: float, f: float, c: float
) -> tuple[float, float, float]:
    """Unit vector across the rows of a matrix of rank two: their longest cross product."""
    ux, uy, uz = d * f - e * b, e * d - a * f, a * b - d * d
    vx, vy, vz = d * c - e * f, e * e - a * c, a * f - d * e
    wx, wy, wz = b * c - f * f, f * e - d * c, d * f - b * e
    size = ux * ux + uy * uy + uz * uz
    other = vx * vx + vy * vy + vz * vz
    longer = other > size
    ux, uy, uz = vx if longer else ux, vy if longer else uy, vz if longer else uz
    size = other if longer else size
    other = wx * wx + wy * wy + wz * wz
    longer = other > size
    ux, uy, uz = wx if longer else ux, wy if longer else uy, wz if longer else uz
    share = 1.0 / np.sqrt(max(other if longer else size, TINY))
    return share * ux, share * uy, share * uz


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def solve_lanes(
    sums: AnyArray, own: AnyArray, scanner: AnyArray, width: float, planes: AnyArray
) -> None:
    """Planes from the sums of `LANES` balls.

    Parameters
    ----------
    sums : (SUMS · LANES,)
        First all counts, then all sums of x, and so on.
    own : (3 · LANES,) metres
        The points in the middles of the balls.
    scanner : (3,) metres
    width : float
        Metres: radius of the balls.
    planes : (PLANES · LANES,)
        Filled.
    """
    qx, qy, qz = scanner[0], scanner[1], scanner[2]
    for k in range(LANES):
        px, py, pz = own[k], own[LANES + k], own[2 * LANES + k]
        bx, by, bz = px - qx, py - qy, pz - qz
        cov = covariance(
            sums[k], sums[LANES + k], sums[2 * LANES + k], sums[3 * LANES + k],
            sums[4 * LANES + k], sums[5 * LANES + k], sums[6 * LANES + k], sums[7 * LANES + k],
            sums[8 * LANES + k], sums[9 * LANES + k],
        )  # fmt: skip
        trace = cov[0] + cov[3] + cov[5]
        scale = 1.0 / max(trace, TINY)
        a, d, e = cov[0] * scale, cov[1] * scale, cov[2] * scale
        b, f, c = cov[3] * scale, cov[4] * scale, cov[5] * scale
        low, step, slope = least_root(a, d, e, b, f, c)
        nx, ny, nz = longest_cross(a - low, d, e, b - low, f, c - low)
        sign = -1.0 if bx * nx + by * ny + bz * nz > 0.0 else 1.0
        blur = 4.0 * EPSILON * max(abs(px), max(abs(py), abs(pz)))
        # Beyond a third of the trace it is not the smallest root: on a line Newton may jump.
        sound = (slope >= APART) & (abs(step) <= SETTLED) & (3.0 * low <= 1.0)
        sound &= APART * trace > blur * blur
        planes[k], planes[LANES + k], planes[2 * LANES + k] = sign * nx, sign * ny, sign * nz
        planes[3 * LANES + k] = np.sqrt(max(low * trace, 0.0))
        planes[4 * LANES + k] = 1.0 if covers(sums[k], cov, bx, by, bz, width) else 0.0
        planes[5 * LANES + k] = 1.0 if sound else 0.0


@njit(**INNER)
def covers_area(
    sums: AnyArray, px: float, py: float, pz: float, scanner: AnyArray, width: float
) -> bool:
    """Whether the points of one ball spread in two directions as the scanner sees them."""
    cov = covariance(
        sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7], sums[8], sums[9]
    )
    return bool(covers(sums[0], cov, px - scanner[0], py - scanner[1], pz - scanner[2], width))


@njit(**INNER)
def store_plane(
    sums: AnyArray,
    px: float,
    py: float,
    pz: float,
    scanner: AnyArray,
    s: int,
    normals: AnyArray,
    rms: AnyArray,
) -> None:
    """Write the normal that faces the scanner, and the rms distance, to slot `s`.

    Nothing is written where the points are fewer than three or on one line.
    """
    n = sums[0]
    if n < 3.0:
        return
    xx, xy, xz, yy, yz, zz = covariance(
        n, sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7], sums[8], sums[9]
    )
    nx, ny, nz, low, middle, high = smallest_axis(xx, xy, xz, yy, yz, zz)
    # Rounding of large coordinates spreads points on one line by about one unit in the
    # last place: such a spread says nothing about a direction.
    blur = 4.0 * EPSILON * max(abs(px), abs(py), abs(pz))
    if middle <= max(COLLINEAR * high, blur * blur):
        return
    facing = nx * (scanner[0] - px) + ny * (scanner[1] - py) + nz * (scanner[2] - pz)
    sign = -1.0 if facing < 0.0 else 1.0
    normals[s, 0], normals[s, 1], normals[s, 2] = sign * nx, sign * ny, sign * nz
    rms[s] = math.sqrt(max(low, 0.0))


@njit(cache=True, nogil=True)
def clear_planes(
    first: int, last: int, normals: AnyArray, count: AnyArray, width: AnyArray, rms: AnyArray
) -> None:
    """No plane in the slots `first` to `last`."""
    for s in range(first, last):
        normals[s, 0] = normals[s, 1] = normals[s, 2] = math.nan
        count[s] = 0
        width[s] = 0.0
        rms[s] = math.nan
