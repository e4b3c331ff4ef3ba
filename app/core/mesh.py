"""The mesh of a leaf on the scan grid, and its area with an interval.

Triangles join neighbouring beams of one leaf, never over a jump: they end where the leaf does
(`app.core.surfaces.outline`). Their corners lie on the ranges smoothed within the noise
(`app.core.surfaces.smoothing`), so that noise does not make the area larger.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.neighbours.steps import UnusableGrid
from app.core.surfaces.crop import Crop, Layout, crop_leaf, lay_out
from app.core.surfaces.outline import USUAL, Outline, border_length, find_outline
from app.core.surfaces.rim import estimate_lost
from app.core.surfaces.smoothing import Smooth, smooth_leaf
from app.core.surfaces.triangles import Cuts, cut_triangles

__all__ = ["Area", "Mesh", "estimate_beam", "lay_out", "mesh_leaf"]

NORMAL = 1.959963984540054
BORDER = 0.35
"""Share of a cell by which the border is uncertain between two beams, independently along it."""
BEAM = 0.12
"""Share of a beam's radius by which the whole border may lie too far out or in."""
UNKNOWN = 0.5
"""The same in cells where the beam is unknown."""
KNOWN_TERMS = 6
DECILE = 0.9
FEWEST_BORDERS = 3
WHOLE = 0.15
"""Share of its border from which on a leaf counts as partly hidden. On simulated leaves 91 % of
those seen to 95 % or more have less, and 1 % of the others; it is what a chord leaves of a circle
that cuts off 2.5 %."""

STEEPEST = float(np.deg2rad(65.0))
"""Mean angle from which on an area is a lower bound only: a leaf seen so nearly edge-on may go on
beyond its border, thinner than the beam, and on simulated leaves intervals fail."""


@dataclass(frozen=True, slots=True)
class Area:
    """Area of a leaf, square metres.

    Attributes
    ----------
    value, low, high : float
        The 95 % interval holds range noise, the border's place, the beam and the smoothing; on
        the high side also what a short hidden border may hide, and a steep rim lose.
    hidden : float
        Share of the border behind something nearer or at the end of the scan.
    omega : float
        Radians: mean angle of incidence over the area.
    parts : dict of str to float
        Standard deviations: noise, border, beam, smoothing.
    """

    value: float
    low: float
    high: float
    hidden: float
    omega: float
    parts: dict[str, float]

    @property
    def whole(self) -> bool:
        """Whether the leaf is seen whole; else the area is a lower bound of the leaf's."""
        return self.hidden < WHOLE

    @property
    def steep(self) -> bool:
        """Whether the leaf is seen so nearly edge-on that its area is a lower bound."""
        return self.omega > STEEPEST

    @property
    def sure(self) -> bool:
        """Whether the interval is one of the leaf's area."""
        return self.whole and not self.steep


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles on a leaf.

    Attributes
    ----------
    vertices : (v, 3) metres, world
    faces : (f, 3) int64
        Anticlockwise as the scanner sees them.
    omega : (f,) radians
        Incidence angle of the beam on each face.
    area : Area
    sigma : float
        Metres: noise of a range.
    width : float
        Cells over which ranges were smoothed beyond a second degree; infinite: none.
    radius : float
        Metres: 1/e² radius of the beam on the leaf; NaN: neither known nor to be told.
    told : bool
        The beam was known, not estimated from the scan.
    """

    vertices: Floats
    faces: Ints
    omega: Floats
    area: Area
    sigma: float
    width: float
    radius: float
    told: bool
    normals: Floats | None = None


def mesh_leaf(
    layout: Layout, members: Ints, ghosts: Bools | None = None,
    beam: tuple[float, float] | None = None, told: bool = True,
) -> Mesh:  # fmt: skip
    """Mesh a leaf and measure it.

    Parameters
    ----------
    layout : Layout
        See `lay_out`.
    members : (k,)
        Numbers of the leaf's points.
    ghosts : (n,) bool or None
        Points between surfaces, which were or are to be taken out.
    beam : (radius, half divergence) or None
        Radius at the exit, metres, and half of the divergence, radians; None estimates the
        beam's radius from points between surfaces.
    told : bool
        False: the beam was estimated (`estimate_beam`), and the interval is wider.

    Raises
    ------
    BadInput, UnusableGrid
        See `crop_leaf`.
    """
    crop = crop_leaf(layout, members, ghosts)
    known = None if beam is None else beam[0] + crop.distance * float(np.tan(beam[1]))
    outline = find_outline(crop, known, told)
    smooth = smooth_leaf(crop, outline)
    cuts = cut_triangles(outline.inside)
    vertices = _lift(crop, smooth, cuts)
    faces = cuts.faces
    across = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    double = np.linalg.norm(across, axis=1)
    beams = vertices[faces].mean(axis=1)
    facing = np.einsum("ij,ij->i", across, beams)
    omega = np.arctan2(np.linalg.norm(np.cross(across, beams), axis=1), np.abs(facing))
    faces = np.where((facing > 0.0)[:, None], faces[:, ::-1], faces)
    radius = outline.radius if outline.radius > 0.0 else USUAL
    lost = estimate_lost(vertices, faces, omega, radius)
    area = _measure(crop, outline, smooth, 0.5 * double, omega, lost)
    world = crop.scanner + vertices
    return Mesh(world, faces, omega, area, smooth.sigma, smooth.width, outline.radius, outline.told)


def estimate_beam(
    layout: Layout, leaves: Iterable[Ints], ghosts: Bools | None = None
) -> tuple[float, float] | None:
    """Radius of a beam from how wide points between surfaces lie on the borders of leaves.

    They lie as wide as the beam, or less wide where one surface is much the stronger one: the
    upper decile over the leaves tells.

    Returns
    -------
    (radius, 0.0) or None
        Metres, as `mesh_leaf` takes a beam, at the range of the leaves; None: too few borders.
    """
    found = []
    for members in leaves:
        try:
            radius = find_outline(crop_leaf(layout, members, ghosts)).radius
        except (BadInput, UnusableGrid):
            continue
        if np.isfinite(radius):
            found.append(radius)
    return (float(np.quantile(found, DECILE)), 0.0) if len(found) >= FEWEST_BORDERS else None


def _lift(crop: Crop, smooth: Smooth, cuts: Cuts) -> Floats:
    """Corners about the scanner: whole fit at their place, the rest from the nearest cell."""
    from scipy.ndimage import distance_transform_edt, map_coordinates

    nearest = distance_transform_edt(
        ~crop.members, sampling=crop.pitch, return_distances=False, return_indices=True
    )
    cell = np.rint(cuts.place).astype(np.int64)
    giver = nearest[:, cell[:, 0], cell[:, 1]].T
    off = cuts.place - giver
    rest = smooth.rest[giver[:, 0], giver[:, 1]]
    added = rest[:, 0] + (rest[:, 1:] * off).sum(axis=1)
    side, up = (map_coordinates(v, cuts.place.T, order=1) for v in (crop.side, crop.up))
    size = float(np.hypot(crop.side[crop.members], crop.up[crop.members]).max()) or 1.0
    a, b = side / size, up / size
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)
    depth = 1.0 / (terms @ smooth.whole + added)
    local = np.stack([np.ones_like(side), side, up], axis=1) * depth[:, None]
    return np.asarray(local @ crop.axes)


def _measure(
    crop: Crop, outline: Outline, smooth: Smooth, areas: Floats, omega: Floats, lost: float
) -> Area:
    total = float(areas.sum())
    cosine = np.maximum(np.cos(omega), 0.05)
    # What noise adds to slopes makes faces larger: by half its square over the squared length.
    steep = smooth.rough * crop.distance**2 * cosine**2
    inflated = float((areas * 0.5 * np.minimum(steep, 0.5)).sum())
    value = max(total - inflated, 0.0)
    facing = float((areas * cosine).sum()) / total if total > 0.0 else 1.0
    pitch = float(np.sqrt(crop.pitch[0] * crop.pitch[1]))
    border = border_length(outline.inside, pitch)
    parts = {
        "noise": total * _slope_error(crop, smooth, omega),
        "border": BORDER * pitch * np.sqrt(border * pitch) / facing,
        "beam": border * _rim_error(outline, pitch) / facing,
        "smoothing": 0.5 * inflated,
    }
    sigma = float(np.sqrt(sum(part**2 for part in parts.values())))
    reach = NORMAL * sigma
    beyond = lost + value * estimate_hidden(min(outline.hidden, WHOLE))
    mean = float((areas * omega).sum()) / total if total > 0.0 else 0.0
    low, high = max(value - reach, 0.0), value + reach + beyond
    return Area(value, low, high, outline.hidden, mean, parts)


def estimate_hidden(border: float) -> float:
    """Area behind a hidden border over the area seen, for a circle that a chord cuts.

    `border` is the chord's share of the border seen.
    """
    angle = np.linspace(0.0, np.pi, 400)
    chord = 2.0 * np.sin(angle / 2.0)
    cut = 0.5 * (angle - np.sin(angle))
    share = chord / (2.0 * np.pi - angle + chord)
    return float(np.interp(border, share, cut / (np.pi - cut)))


def _rim_error(outline: Outline, pitch: float) -> float:
    """Standard deviation, metres, of how far out the whole border lies."""
    if not outline.radius > 0.0:
        return UNKNOWN * pitch
    told = BEAM if outline.told else 2.0 * BEAM
    return float(np.hypot(told * outline.radius, 0.5 * outline.apart))


def _slope_error(crop: Crop, smooth: Smooth, omega: Floats) -> float:
    """Relative error of the area from that of the leaf's slope as a whole."""
    extent = float(np.sqrt(crop.members.sum() * crop.pitch[0] * crop.pitch[1]))
    slope = smooth.sigma / (extent / np.sqrt(12.0)) / np.sqrt(max(smooth.core - KNOWN_TERMS, 1))
    tilt = float(np.median(np.tan(np.minimum(omega, 1.4))))
    return float(slope * min(tilt, 5.0) * np.cos(np.arctan(tilt)) ** 2 + 0.5 * slope**2)
