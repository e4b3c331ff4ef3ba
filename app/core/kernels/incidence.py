"""The angle between beams and normals."""

import math

from numba import njit

from app.core.arrays import AnyArray


@njit(cache=True, nogil=True, error_model="numpy")
def measure_angles(
    xyz: AnyArray, normals: AnyArray, scanner: AnyArray, first: int, last: int, angle: AnyArray
) -> None:
    """Fill `angle` from the first to the last point; see `app.core.incidence.incidence_angle`."""
    for i in range(first, last):
        x, y, z = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        u, v, w = y * c - z * b, z * a - x * c, x * b - y * a
        along = abs(x * a + y * b + z * c)
        angle[i] = math.atan2(math.sqrt(u * u + v * v + w * w), along)
        if x == 0.0 and y == 0.0 and z == 0.0:
            angle[i] = math.nan
