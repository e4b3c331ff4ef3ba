"""A scene and a beam as the arrays that the tracer reads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from app.core.arrays import Floats
from app.simulate.beam import BeamGrid, Bundle, angles_of
from app.simulate.surfaces import Leaf, Scene

if TYPE_CHECKING:
    from app.core.kernels.simulate import LeafTable, SceneTable, StemTable, TileTable, WallTable

TILE = 8
"""Beams along the side of a tile; a smaller tile has fewer surfaces to look through."""


def tabulate_scene(scene: Scene) -> SceneTable:
    """All surfaces of a scene as arrays."""
    from app.core.kernels.simulate import SceneTable

    return SceneTable(
        _tabulate_leaves(scene.leaves),
        _tabulate_stems(scene),
        _tabulate_walls(scene),
        scene.spheres(),
        scene.optics(),
    )


def tabulate_tiles(grid: BeamGrid, bundle: Bundle, spheres: Floats, origin: Floats) -> TileTable:
    """Surfaces that each tile of the grid can meet: spheres projected to windows of tiles."""
    from app.core.kernels.simulate import TileTable

    rows, columns = -(-grid.rows // TILE), -(-grid.columns // TILE)
    window = _project_spheres(grid, bundle, spheres, origin) // TILE
    window = np.clip(window, [0, -1, 0, -1], [rows, rows - 1, columns, columns - 1])
    tiles, surfaces = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for index, (top, bottom, left, right) in enumerate(window):
        down, across = np.arange(top, bottom + 1), np.arange(left, right + 1)
        tiles.append((down[:, None] * columns + across).ravel())
        surfaces.append(np.full(tiles[-1].size, index))
    tile, surface = np.concatenate(tiles), np.concatenate(surfaces)
    order = np.argsort(tile, kind="stable")
    start = np.searchsorted(tile[order], np.arange(rows * columns + 1))
    return TileTable(TILE, columns, start, surface[order])


def _project_spheres(grid: BeamGrid, bundle: Bundle, spheres: Floats, origin: Floats) -> Any:
    """First and last row and column that can touch each sphere, (n, 4) int64."""
    elevation, azimuth = angles_of(spheres[:, :3], origin)
    away = np.linalg.norm(spheres[:, :3] - origin, axis=1)
    reach = spheres[:, 3] + np.array([bundle.radius(d) for d in away])
    high = np.arcsin(np.minimum(reach / away, 1.0))
    # Meridians close in towards the poles: at the zenith every azimuth can meet the sphere.
    ratio = np.sin(high) / np.maximum(np.cos(elevation), 1e-9)
    wide = np.where(ratio < 1, np.arcsin(np.minimum(ratio, 1.0)), np.pi)
    middle = grid.left - grid.step * (grid.columns - 1) / 2
    side = middle + (azimuth - middle + np.pi) % (2 * np.pi) - np.pi
    first = np.stack([grid.top - elevation - high, grid.left - side - wide], axis=1)
    last = np.stack([grid.top - elevation + high, grid.left - side + wide], axis=1)
    low, top = np.floor(first / grid.step), np.ceil(last / grid.step)
    return np.stack([low[:, 0], top[:, 0], low[:, 1], top[:, 1]], axis=1).astype(np.int64)


def _tabulate_leaves(leaves: tuple[Leaf, ...]) -> LeafTable:
    from app.core.kernels.simulate import LeafTable

    waves = [
        (s.wrinkle_height, *(2 * np.pi / np.array(s.wrinkle_lengths)), *s.wrinkle_phases)
        for s in leaves
    ]
    bends = [(s.curvature, np.cos(s.bend_direction), np.sin(s.bend_direction)) for s in leaves]
    return LeafTable(
        _stack([s.centre for s in leaves], 3),
        np.array([s.frame() for s in leaves], float).reshape(-1, 3, 3),
        _stack([(s.length / 2, s.width / 2, s.taper) for s in leaves], 3),
        _stack(bends, 3),
        _stack(waves, 5),
        _stack([s.slab() for s in leaves], 2),
    )


def _tabulate_stems(scene: Scene) -> StemTable:
    from app.core.kernels.simulate import StemTable

    stems = scene.stems
    return StemTable(
        _stack([s.start for s in stems], 3),
        _stack([s.end for s in stems], 3),
        np.array([s.radius for s in stems], float),
    )


def _tabulate_walls(scene: Scene) -> WallTable:
    from app.core.kernels.simulate import WallTable

    edges = [np.array((w.across, w.up), float) for w in scene.walls]
    half = _stack([np.linalg.norm(pair, axis=1) for pair in edges], 2)
    frames = [np.vstack([*pair, np.cross(*pair)]) for pair in edges]
    frames = [frame / np.linalg.norm(frame, axis=1)[:, None] for frame in frames]
    return WallTable(
        _stack([w.centre for w in scene.walls], 3),
        np.array(frames, float).reshape(-1, 3, 3),
        half,
    )


def _stack(rows: Any, width: int) -> Floats:
    """Rows as an array that keeps its width even when there are none."""
    return np.array(rows, float).reshape(-1, width)
