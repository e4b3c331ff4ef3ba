"""Scans of millions of points in a moment: plane patches before a wall, no beam width."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.model.scan import Channel, Pose, Scan
from app.simulate.beam import BeamGrid, grid_of_field
from app.simulate.simulation import place_in_grid

FIELD = 25.0
"""Degrees, both ways."""
PATCHES = 18
"""Patches along each side of the field, one in each square of a raster."""
PATCH_FILL = 0.4
"""Radius of a patch in sides of its square."""
WALL = 6.0


def large_scan(points: int, seed: int = 0) -> Scan:
    """A grid of about `points` points: 324 round plane patches at 2.5–4 m before a wall.

    Point beams without noise, so it is exact and made in a moment; for measuring speed.
    `truth_leaf`, `truth_incidence` (degrees), and both reflectance channels, Lambertian.
    """
    grid = grid_of_field(FIELD / np.sqrt(points), (-FIELD / 2, FIELD / 2), (-FIELD / 2, FIELD / 2))
    patch = _find_patches(grid)
    centre, normal, rho = _draw_patches(seed)
    offset = np.einsum("ij,ij->i", centre, normal)
    beams = grid.directions.reshape(-1, 3)
    facing = np.einsum("ij,ij->i", beams, normal[patch])
    distance = offset[patch] / facing
    reflectance = rho[patch] * np.abs(facing)[:, None]
    names = ("reflectance_1063", "reflectance_1545")
    attributes: dict[str, AnyArray] = {
        name: reflectance[:, k].astype(np.float32) for k, name in enumerate(names)
    }
    attributes["truth_leaf"] = patch.astype(np.int32)
    attributes["truth_incidence"] = np.rad2deg(np.arccos(np.abs(facing))).astype(np.float32)
    return Scan(
        name=f"{len(beams)} points",
        xyz=distance[:, None] * beams,
        attributes=attributes,
        channels=tuple(Channel(n, n, float(n[-4:]), "reflectance", "simulated") for n in names),
        pose=Pose((0.0, 0.0, 0.0)),
        grid=place_in_grid(grid, np.arange(len(beams))),
    )


def _find_patches(grid: BeamGrid) -> AnyArray:
    """Patch of each beam, −1 (the last row of the tables) between them."""
    down = (np.arange(grid.rows) + 0.5) / grid.rows * PATCHES
    across = (np.arange(grid.columns) + 0.5) / grid.columns * PATCHES
    index = down.astype(np.int64)[:, None] * PATCHES + across.astype(np.int64)
    inside = ((down % 1 - 0.5) ** 2)[:, None] + (across % 1 - 0.5) ** 2 < PATCH_FILL**2
    return np.where(inside, index, -1).ravel()


def _draw_patches(seed: int) -> tuple[Floats, Floats, Floats]:
    """Centres, normals and reflectances of the patches, the wall last."""
    random = np.random.default_rng(seed)
    angle = np.deg2rad(FIELD * (0.5 - (np.arange(PATCHES) + 0.5) / PATCHES))
    up, side = (a.ravel() for a in np.meshgrid(angle, angle, indexing="ij"))
    flat = np.cos(up)
    beam = np.stack([flat * np.cos(side), flat * np.sin(side), np.sin(up)], axis=1)
    lean = random.normal(0.0, 0.5, beam.shape)
    normal = beam + lean - beam * np.einsum("ij,ij->i", lean, beam)[:, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    centre = random.uniform(2.5, 4.0, (len(beam), 1)) * beam
    rho = np.array([0.48, 0.27]) * random.uniform(0.85, 1.15, (len(beam), 2))
    return (
        np.vstack([centre, [[WALL, 0.0, 0.0]]]),
        np.vstack([normal, [[1.0, 0.0, 0.0]]]),
        np.vstack([rho, [[0.6, 0.5]]]),
    )
