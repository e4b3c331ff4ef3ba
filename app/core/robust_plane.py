"""A plane that up to half of the points may contradict: least median of squares."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools, Floats

TRIPLETS = 300
SAMPLE = 2000
SIGMAS = 2.5
MEDIAN_TO_SIGMA = 1.4826
SEED = 20261122


def robust_normal(offsets: Floats, least: float) -> tuple[Floats, Bools]:
    """Find the plane with the smallest median distance, then fit the points near it.

    Planes through random triplets are tried (Rousseeuw 1984); with half of the points off
    the plane, 300 triplets miss it with a chance below 1e-17. The seed is fixed: the same
    points give the same plane.

    Parameters
    ----------
    offsets : (k, 3) metres
        Points about any centre near them.
    least : float
        Metres: points nearer than this belong to the plane in any case.

    Returns
    -------
    normal : (3,)
        Unit vector, of either sign.
    near : (k,) bool
        Points that belong to the plane.
    """
    random = np.random.default_rng(SEED)
    few = offsets if len(offsets) <= SAMPLE else random.choice(offsets, SAMPLE, replace=False)
    corners = few[random.integers(len(few), size=(TRIPLETS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    usable = lengths > 1e-12 * max(float(lengths.max()), 1e-300)
    normals, places = normals[usable] / lengths[usable, None], corners[usable, 0]
    distance = np.abs(few @ normals.T - np.einsum("ij,ij->i", normals, places))
    medians = np.median(distance, axis=0)
    best = int(np.argmin(medians))
    reach = max(least, SIGMAS * MEDIAN_TO_SIGMA * float(medians[best]))
    near = np.abs((offsets - places[best]) @ normals[best]) <= reach
    kept = offsets[near]
    normal = np.linalg.svd(kept - kept.mean(axis=0), full_matrices=False)[2][2]
    return normal, near
