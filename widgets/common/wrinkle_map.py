"""Δω of one leaf, made ready to show: its map as the scanner saw it, and its numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import BadInput
from app.core.intensity_angle import Curve, Doubt, invert_intensity
from app.core.planes import leaf_plane
from app.core.units import to_degrees, to_radians
from app.core.wrinkles import Distribution, distribution, shift_of_mean
from app.model.project import Project
from app.render.palettes import colour_table

FAINT = 90
LEAST_CELLS, MOST_CELLS = 8, 400
NEIGHBOURS_TO_FILL = 4


@dataclass(frozen=True, slots=True, eq=False)
class SeenLeaf:
    """Δω of a leaf in the directions in which the scanner saw it.

    Attributes
    ----------
    spread : Distribution
        Radians.
    plane : float
        ω of the leaf's plane, degrees.
    doubtful : float
        Share of the points whose angle from intensity is not to be trusted.
    delta, doubt : (rows, columns)
        Mean Δω per cell in degrees, NaN where there is none; share of doubtful points.
    azimuth, elevation : (float, float)
        Borders of the map in degrees about the middle of the leaf.
    """

    spread: Distribution
    plane: float
    doubtful: float
    delta: Floats
    doubt: Floats
    azimuth: tuple[float, float]
    elevation: tuple[float, float]

    @property
    def limit(self) -> float:
        """Δω, degrees, that all but a few points stay within: the ends of the colours."""
        finite = np.abs(self.delta[np.isfinite(self.delta)])
        return max(float(np.ceil(np.quantile(finite, 0.98))), 2.0) if len(finite) else 2.0


def see_leaf(project: Project, scan: str, members: Ints, sigma: float = 0.0) -> SeenLeaf:
    """Describe the Δω of a leaf; the field must be known or cheap.

    Parameters
    ----------
    members : (k,) array
        Points of the leaf; deleted ones are left out.
    sigma : float
        Standard deviation of one intensity; 0 when unknown.

    Raises
    ------
    BadInput
        No curve in use, no plane, or no point whose intensity is on the curve.
    """
    state = project.state.scan(scan)
    curve = state.parameters.curve
    if curve is None:
        raise BadInput("No angular curve is in use.", "Fit one first.")
    points = members[state.alive[members]]
    delta = project.field(scan, "delta_omega", points)
    intensity = project.field(scan, curve.channel, points)
    scanner = state.scan.scanner("Δω")
    plane = leaf_plane(state.scan.xyz[points], scanner, state.parameters.plane_gate).incidence
    model = curve.angular_model
    read = Curve(
        lambda angle: model.evaluate(angle, curve.values),
        lambda value: model.inverse(value, curve.values),
        lambda angle: model.slope(angle, curve.values),
    )
    doubt = invert_intensity(intensity, sigma, read).doubt != Doubt.NONE
    spread = distribution(to_radians(delta), shift_of_mean(intensity, plane, read))
    azimuth, elevation = directions(state.scan.xyz[points] - scanner)
    cells = _count_cells(azimuth, elevation)
    return SeenLeaf(
        spread,
        float(to_degrees(plane)),
        float(doubt[np.isfinite(delta)].mean()),
        _average(azimuth, elevation, delta, cells),
        _average(azimuth, elevation, np.where(np.isfinite(delta), doubt, np.nan), cells),
        (float(azimuth.min()), float(azimuth.max())),
        (float(elevation.min()), float(elevation.max())),
    )


def directions(beams: Floats) -> tuple[Floats, Floats]:
    """Azimuth to the right and elevation upwards of beams, degrees about their mean.

    Near the zenith azimuth alone says nothing, so both are taken in a frame that looks
    along the mean beam, with its upright axis as near to the vertical as it can be.
    """
    unit = beams / np.linalg.norm(beams, axis=1, keepdims=True)
    ahead = unit.mean(axis=0)
    ahead /= np.linalg.norm(ahead)
    upright = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = np.cross(ahead, upright)
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    depth, across, above = unit @ ahead, unit @ right, unit @ up
    return (
        to_degrees(np.arctan2(across, depth)),
        to_degrees(np.arctan2(above, np.hypot(across, depth))),
    )


def _count_cells(azimuth: Floats, elevation: Floats) -> tuple[int, int]:
    """Rows and columns of nearly square cells that hold about one point each."""
    wide, high = (max(float(np.ptp(side)), 1e-9) for side in (azimuth, elevation))
    side = np.sqrt(wide * high / len(azimuth))
    return (
        int(np.clip(high / side, LEAST_CELLS, MOST_CELLS)),
        int(np.clip(wide / side, LEAST_CELLS, MOST_CELLS)),
    )


def _average(
    azimuth: Floats, elevation: Floats, values: AnyArray, cells: tuple[int, int]
) -> Floats:
    known = np.isfinite(values)
    place = [
        np.minimum(((side - side.min()) / max(np.ptp(side), 1e-9) * n).astype(np.int64), n - 1)
        for side, n in ((elevation, cells[0]), (azimuth, cells[1]))
    ]
    cell = np.ravel_multi_index((place[0][known], place[1][known]), cells)
    count = np.bincount(cell, minlength=cells[0] * cells[1]).reshape(cells)
    total = np.bincount(cell, values[known], cells[0] * cells[1]).reshape(cells)
    with np.errstate(invalid="ignore"):
        return _close_holes(total / count)


def _close_holes(image: Floats) -> Floats:
    """Fill cells that lie among filled ones: a fine pattern of gaps is no news of a leaf."""
    padded = np.pad(image, 1, constant_values=np.nan)
    rows, columns = image.shape
    around = np.stack(
        [
            padded[i : i + rows, j : j + columns]
            for i in range(3)
            for j in range(3)
            if (i, j) != (1, 1)
        ]
    )
    known = np.isfinite(around)
    number = known.sum(axis=0)
    mean = np.where(known, around, 0.0).sum(axis=0) / np.maximum(number, 1)
    fill = np.isnan(image) & (number >= NEIGHBOURS_TO_FILL)
    filled: Floats = np.where(fill, mean, image)
    return filled


def paint(seen: SeenLeaf, limit: float) -> AnyArray:
    """Colours of the map, (rows, columns, 4); doubtful cells faint, empty ones clear."""
    share = np.clip((np.nan_to_num(seen.delta) + limit) / (2 * limit), 0.0, 1.0)
    rgba = colour_table("delta-omega")[np.round(share * 255).astype(np.int64)].copy()
    rgba[seen.doubt > 0.5, 3] = FAINT
    rgba[~np.isfinite(seen.delta), 3] = 0
    return rgba
