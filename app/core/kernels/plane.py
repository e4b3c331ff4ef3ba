"""Total least squares plane of the points in a ball: sums, and a 3 × 3 Jacobi solver."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import SAFE

SUMS = 10
COLLINEAR = 1e-10
SWEEPS = 12
LEAST_SPREAD = 0.02
"""Smallest standard deviation across the beam, in radii; a dense surface has 0.5 cos ω."""


@njit(cache=True, nogil=True, fastmath=SAFE)
def add_ball(
    x: AnyArray, y: AnyArray, z: AnyArray, first: int, last: int, step: int, px: float, py: float,
    pz: float, limit: float, sums: AnyArray,
) -> None:  # fmt: skip
    """Add count and moments of the points `first` to `last` within √limit of p, about p.

    Moments about the point itself stay exact at coordinates of 10⁶ m.
    """
    n = sx = sy = sz = xx = xy = xz = yy = yz = zz = 0.0
    for j in range(first, last, step):
        dx = x[j] - px
        dy = y[j] - py
        dz = z[j] - pz
        if dx * dx + dy * dy + dz * dz <= limit:
            n += 1.0
            sx += dx
            sy += dy
            sz += dz
            xx += dx * dx
            xy += dx * dy
            xz += dx * dz
            yy += dy * dy
            yz += dy * dz
            zz += dz * dz
    sums[0] += n
    sums[1] += sx
    sums[2] += sy
    sums[3] += sz
    sums[4] += xx
    sums[5] += xy
    sums[6] += xz
    sums[7] += yy
    sums[8] += yz
    sums[9] += zz


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def covers_area(
    sums: AnyArray, px: float, py: float, pz: float, scanner: AnyArray, width: float
) -> bool:
    """Whether the points spread in two directions as the scanner sees them.

    Where columns lie far apart a ball may hold points of one column only. Their noise along
    the beam then passes for a second direction, and every such plane seems edge-on.
    """
    n = sums[0]
    if n < 3.0:
        return False
    mx, my, mz = sums[1] / n, sums[2] / n, sums[3] / n
    xx, xy, xz = sums[4] / n - mx * mx, sums[5] / n - mx * my, sums[6] / n - mx * mz
    yy, yz, zz = sums[7] / n - my * my, sums[8] / n - my * mz, sums[9] / n - mz * mz
    bx, by, bz = px - scanner[0], py - scanner[1], pz - scanner[2]
    length = bx * bx + by * by + bz * bz
    # Trace and determinant of the covariance projected along the beam; the latter through
    # the adjugate.
    along = bx * bx * xx + by * by * yy + bz * bz * zz
    along += 2.0 * (bx * by * xy + bx * bz * xz + by * bz * yz)
    trace = xx + yy + zz - along / length
    det = bx * bx * (yy * zz - yz * yz) + by * by * (xx * zz - xz * xz)
    det += bz * bz * (xx * yy - xy * xy) + 2.0 * bx * by * (xz * yz - xy * zz)
    det += 2.0 * bx * bz * (xy * yz - xz * yy) + 2.0 * by * bz * (xy * xz - xx * yz)
    return bool(det / length >= (LEAST_SPREAD * width) ** 2 * trace and trace > 0.0)


@njit(cache=True, nogil=True)
def store_plane(
    sums: AnyArray,
    px: float,
    py: float,
    pz: float,
    scanner: AnyArray,
    normal: AnyArray,
) -> float:
    """Turn the sums into a normal that faces the scanner; give the rms distance from it.

    NaN, and an untouched normal, where the points are fewer than three or on one line.
    """
    n = sums[0]
    if n < 3.0:
        return math.nan
    mx, my, mz = sums[1] / n, sums[2] / n, sums[3] / n
    nx, ny, nz, low, middle, high = smallest_axis(
        sums[4] / n - mx * mx, sums[5] / n - mx * my, sums[6] / n - mx * mz,
        sums[7] / n - my * my, sums[8] / n - my * mz, sums[9] / n - mz * mz,
    )  # fmt: skip
    # Rounding of large coordinates spreads points on one line by about one unit in the
    # last place: such a spread says nothing about a direction.
    blur = 4.0 * np.finfo(np.float64).eps * max(abs(px), abs(py), abs(pz))
    if middle <= max(COLLINEAR * high, blur * blur):
        return math.nan
    facing = nx * (scanner[0] - px) + ny * (scanner[1] - py) + nz * (scanner[2] - pz)
    sign = -1.0 if facing < 0.0 else 1.0
    normal[0] = sign * nx
    normal[1] = sign * ny
    normal[2] = sign * nz
    return math.sqrt(max(low, 0.0))
