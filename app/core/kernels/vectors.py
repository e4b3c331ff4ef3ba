"""Vectors of three as tuples: a view of an array would be counted at every use."""

from numba import njit

from app.core.kernels import INNER


@njit(**INNER)
def dot(a, b):  # type: ignore[no-untyped-def]
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**INNER)
def cross(a, b):  # type: ignore[no-untyped-def]
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@njit(**INNER)
def minus(a, b):  # type: ignore[no-untyped-def]
    """Difference of two vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@njit(**INNER)
def along(o, d, t):  # type: ignore[no-untyped-def]
    """Point of a ray at t."""
    return (o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2])


@njit(**INNER)
def take(table, i):  # type: ignore[no-untyped-def]
    """Row of three."""
    return (table[i, 0], table[i, 1], table[i, 2])


@njit(**INNER)
def turn_in(frames, i, a):  # type: ignore[no-untyped-def]
    """A world vector in the frame of surface i."""
    return (
        frames[i, 0, 0] * a[0] + frames[i, 0, 1] * a[1] + frames[i, 0, 2] * a[2],
        frames[i, 1, 0] * a[0] + frames[i, 1, 1] * a[1] + frames[i, 1, 2] * a[2],
        frames[i, 2, 0] * a[0] + frames[i, 2, 1] * a[1] + frames[i, 2, 2] * a[2],
    )


@njit(**INNER)
def turn_out(frames, i, a):  # type: ignore[no-untyped-def]
    """A vector of the frame of surface i in the world."""
    return (
        frames[i, 0, 0] * a[0] + frames[i, 1, 0] * a[1] + frames[i, 2, 0] * a[2],
        frames[i, 0, 1] * a[0] + frames[i, 1, 1] * a[1] + frames[i, 2, 1] * a[2],
        frames[i, 0, 2] * a[0] + frames[i, 1, 2] * a[1] + frames[i, 2, 2] * a[2],
    )
