"""A leaf as a scanner sees it: across the beams, and along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.holder import across_of
from app.core.robust_plane import MEDIAN_TO_SIGMA

NEIGHBOURS = 4
SMOOTHED = 25
"""Nearest beams whose ranges are smoothed: five rows of five."""
CUT, SLACK = 4.0, 1e-4
"""Standard deviations, and metres, from the median beyond which a range smooths no other."""
FACE_ON = 1e-9
TOUCH = 1.6
"""Beams apart that neighbours on one surface may be; 1.41 is a diagonal."""
JUMP = 0.01
"""Metres of range that they may differ by."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A scan as its scanner sees it.

    Attributes
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    usable : (n,) bool
        Points that may belong to a leaf; they have coordinates.
    """

    xyz: Floats
    scanner: Floats
    usable: Bools


class Sight:
    """Coordinates of points about a leaf: two across its middle beam, metres there, and range."""

    def __init__(self, centre: Floats, scanner: Floats) -> None:
        self._scanner = scanner
        self._away = float(np.linalg.norm(centre - scanner))
        self._ahead = (centre - scanner) / self._away
        self._across = np.stack(across_of(self._ahead), axis=1)

    def look(self, xyz: Floats) -> Floats:
        """(k, 3) coordinates; NaN behind the scanner."""
        offset = xyz - self._scanner
        depth = offset @ self._ahead
        with np.errstate(divide="ignore", invalid="ignore"):
            across = offset @ self._across / depth[:, None] * self._away
        across[depth <= 0.0] = np.nan
        return np.column_stack([across, np.sqrt(np.einsum("ij,ij->i", offset, offset))])

    def steepest(self, normal: Floats) -> Floats:
        """The direction in a plane, (3,), that is foreshortened most."""
        along = np.cross(normal, np.cross(normal, self._ahead))
        size = float(np.linalg.norm(along))
        return along / size if size > FACE_ON else self._across[:, 0]

    def lift(self, seen: Floats) -> Floats:
        """Points, (k, 3) metres, of their coordinates: the way back from `look`."""
        beams = self._ahead * self._away + seen[:, :2] @ self._across.T
        beams /= np.linalg.norm(beams, axis=1, keepdims=True)
        return np.asarray(self._scanner + beams * seen[:, 2:])

    def foreshorten(self, direction: Floats) -> float:
        """How long a unit vector at the leaf looks from the scanner, 0 to 1."""
        return float(np.sqrt(max(0.0, 1.0 - float(direction @ self._ahead) ** 2)))


def beam_step(seen: Floats) -> float:
    """Metres between neighbouring beams: median distance of the 4th nearest, on a grid its step."""
    from scipy.spatial import cKDTree

    if len(seen) <= NEIGHBOURS:
        return 0.0
    far = np.asarray(cKDTree(seen[:, :2]).query(seen[:, :2], NEIGHBOURS + 1)[0])
    return float(np.median(far[:, NEIGHBOURS]))


def smooth_ranges(seen: Floats) -> Floats:
    """Ranges on the surface, (k,) metres: of a plane through each point's nearest beams.

    Noise lies along the beam; turned with a leaf it would fray its outline.
    """
    from scipy.spatial import cKDTree

    if len(seen) <= SMOOTHED:
        return seen[:, 2]
    _, near = cKDTree(seen[:, :2]).query(seen[:, :2], SMOOTHED)
    around = seen[near] - seen[:, None]
    around[:, :, 2] += seen[:, None, 2]
    middle = np.median(around[:, :, 2], axis=1)
    off = np.abs(around[:, :, 2] - middle[:, None])
    # Mixed pixels lie far behind the rim of a leaf; they must not bend it.
    kept = off <= CUT * MEDIAN_TO_SIGMA * np.median(off, axis=1)[:, None] + SLACK
    design = np.concatenate([np.ones_like(around[:, :, :1]), around[:, :, :2]], axis=2)
    wanted = ((around[:, :, 2] - middle[:, None]) * kept)[:, :, None]
    found = np.linalg.pinv(design * kept[:, :, None]) @ wanted
    return np.asarray(middle + found[:, 0, 0])


def connected(seen: Floats, seeds: Bools, step: float) -> Bools:
    """Points on the surfaces that hold seeds: neighbouring beams without a jump in range."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    scale = np.array([TOUCH * step, TOUCH * step, max(JUMP, TOUCH * step)])
    pairs = cKDTree(seen / scale).query_pairs(1.0, p=np.inf, output_type="ndarray")
    ones = np.ones(len(pairs))
    links = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(seen), len(seen)))
    _, component = connected_components(links, directed=False)
    held = np.zeros(int(component.max()) + 1, np.bool_)
    held[component[seeds]] = True
    found: Bools = held[component]
    return found
