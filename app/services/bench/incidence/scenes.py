"""Scans with exact truth: without noise first, then with noise of a stated σ along the beam.

All are made anew from fixed seeds, but for the files of the other simulator.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.neighbours.steps import Cells
from app.core.units import to_degrees
from app.model.scan import Scan
from app.services.reading import read_file
from app.simulate.beam import BeamGrid
from app.simulate.large import large_scan
from app.simulate.receiver import Correlation, draw_noise
from app.simulate.simulation import Simulation
from app.simulate.virtual_scan import simulate

FLAT, BENT, WRINKLED, OTHER = 0, 1, 2, 9
KIND_NAMES = {FLAT: "flat", BENT: "bent", WRINKLED: "wrinkled"}
CLEAN_POINTS, WHOLE_POINTS, QUICK_POINTS = 6_100_000, 2_000_000, 250_000
CLEAN_SEED, HARD_SEED, NOISE_SEED = 3, 1, 7
FINE_STEP, OWN_STEP, QUICK_STEP = 0.0105, 0.018, 0.05
"""Degrees between beams of the hard scene: 2 million points, 683 000, and a few."""
CLEAN, HARD, FINE = "clean", "hard", "hard, 2 million points"
WHOLE = "clean leaves and wall"
OTHERS = ("phase_shift", "pulsed")

Kind = Literal["white", "correlated", "as scanned"]


@dataclass(frozen=True, slots=True)
class Noise:
    """Range noise: its kind, and its σ in metres (NaN where the file's maker alone knows)."""

    kind: Kind
    sigma: float


USUAL = Noise("white", 0.0007)
STRONG = Noise("white", 0.0026)
FILTERED = Noise("correlated", 0.0007)
"""White noise of 2.1 mm, averaged over 3 × 3 cells."""
GIVEN = Noise("as scanned", float("nan"))


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """A scan without noise, and what is true of it.

    Attributes
    ----------
    name : str
    xyz : (n, 3) metres
    grid : Cells
    scanner : (3,) metres
    omega : (n,) degrees
    leaf : (n,) number of the leaf, −1 elsewhere
    kind : (n,) FLAT, BENT, WRINKLED or OTHER
    judged : (n,) bool
        True leaf points: the figures speak of these alone.
    """

    name: str
    xyz: Floats
    grid: Cells
    scanner: Floats
    omega: Floats
    leaf: Ints
    kind: Ints
    judged: Bools

    @property
    def cells(self) -> int:
        """Cells of the grid."""
        return self.grid.rows * self.grid.columns

    def add_noise(self, noise: Noise, seed: int = NOISE_SEED) -> Floats:
        """The points with noise along their beams, (n, 3); σ is the same for all of them."""
        if noise is GIVEN or noise.sigma == 0.0:
            return self.xyz
        correlation: Correlation = "filtered" if noise.kind == "correlated" else "white"
        cell = self.grid.row.astype(np.int64) * self.grid.columns + self.grid.column
        random = np.random.default_rng(seed)
        drawn = draw_noise((self.grid.rows, self.grid.columns), cell, correlation, random)
        beams = self.xyz - self.scanner
        away = np.linalg.norm(beams, axis=1)
        return np.asarray(self.xyz + beams * (noise.sigma * drawn / away)[:, None])


def make_clean(quick: bool = False) -> Truth:
    """Round flat leaves at 2.5 to 4 m, seen by point beams, with nothing behind them."""
    scan = large_scan(QUICK_POINTS if quick else CLEAN_POINTS, CLEAN_SEED)
    leaf = scan.attributes["truth_leaf"]
    on = leaf >= 0
    omega = scan.attributes["truth_incidence"]
    kind = np.full(int(on.sum()), FLAT)
    return _cut(CLEAN, scan, on, omega, leaf, kind, np.ones(len(kind), bool))


def make_whole() -> Truth:
    """2 million points: the clean scene's 324 leaves, and the wall behind them."""
    scan = large_scan(WHOLE_POINTS, CLEAN_SEED)
    leaf, omega = scan.attributes["truth_leaf"], scan.attributes["truth_incidence"]
    every, kind = np.ones(len(leaf), bool), np.where(leaf >= 0, FLAT, OTHER)
    return _cut(WHOLE, scan, every, omega, leaf, kind, leaf >= 0)


def make_hard(step: float, name: str) -> Truth:
    """250 flat, bent and wrinkled leaves before a wall, wide beams, mixed pixels at borders."""
    made = simulate("scattered", seed=HARD_SEED, step_deg=step, noise="none")
    values = made.scan.attributes
    leaf = values["truth_leaf"]
    kinds = np.append(_kinds_of(made), OTHER)
    judged = (leaf >= 0) & (values["truth_ghost"] == 0)
    every = np.ones(len(leaf), bool)
    return _cut(name, made.scan, every, values["truth_incidence"], leaf, kinds[leaf], judged)


def _kinds_of(made: Simulation) -> Ints:
    kinds = [
        WRINKLED if leaf.wrinkle_height else BENT if leaf.curvature else FLAT
        for leaf in made.scene.leaves
    ]
    return np.array(kinds)


def _cut(
    name: str, scan: Scan, kept: Bools, omega: AnyArray, leaf: AnyArray, kind: Ints, judged: Bools
) -> Truth:
    """`kind` and `judged` are those of the kept points already."""
    grid = scan.grid
    if grid is None:
        raise BadInput(f"The scan {scan.name} has no rows and columns.")
    row, column = (np.ascontiguousarray(a[kept], np.int32) for a in (grid.row, grid.column))
    cells = Cells(grid.rows, grid.columns, row, column)
    xyz = np.ascontiguousarray(scan.xyz[kept])
    at = np.array(scan.scanner("the angle of incidence"), np.float64)
    true = omega[kept].astype(np.float64)
    return Truth(name, xyz, cells, at, true, leaf[kept].astype(np.int64), kind, judged)


def read_other(folder: Path, name: str) -> Truth:
    """A scan of another simulator, as it made it.

    Raises
    ------
    BadInput
        A file is missing, or is not what it should be.
    """
    path = folder / f"{name}.ptx"
    scan = read_file(path)[0]
    try:
        with np.load(folder / f"{name}_truth.npz", allow_pickle=False) as file:
            truth = {key: file[key] for key in ("row", "leaf", "ghost", "incidence_deg")}
            kinds = file["leaf_kind"].astype(np.int64)
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"{folder}: the truth of {name} cannot be read: {error}.") from error
    leaf, omega = truth["leaf"], truth["incidence_deg"]
    if len(leaf) != len(scan.xyz):
        raise BadInput(f"{path} has {len(scan.xyz)} points, its truth tells of {len(leaf)}.")
    kind = kinds if len(kinds) == len(leaf) else np.append(kinds, OTHER)[leaf]
    judged = (leaf >= 0) & ~truth["ghost"].astype(bool)
    return _cut(name, scan, np.ones(len(leaf), bool), omega, leaf, kind, judged)


def make_plane(degrees: float, side: int, step_deg: float = 0.018, distance: float = 3.0) -> Truth:
    """An endless plane seen by `side` × `side` point beams, its middle at `degrees`."""
    step = float(np.deg2rad(step_deg))
    half = step * (side - 1) / 2
    beams = BeamGrid(half, half, step, side, side).directions.reshape(-1, 3)
    tilt = float(np.deg2rad(degrees))
    # Turned about an axis between row and column, so that neither is a special case.
    normal = np.array([-np.cos(tilt), np.sin(tilt) * np.sqrt(0.7), np.sin(tilt) * np.sqrt(0.3)])
    facing = beams @ normal
    seen = -facing > np.cos(np.deg2rad(86.0))
    xyz = (distance * normal[0] / facing[seen])[:, None] * beams[seen]
    row, column = (a.ravel()[seen].astype(np.int32) for a in np.mgrid[:side, :side])
    across = np.linalg.norm(np.cross(beams[seen], normal), axis=1)
    omega = to_degrees(np.arctan2(across, -facing[seen]))
    leaf, judged = np.zeros(len(xyz), np.int64), np.ones(len(xyz), bool)
    cells = Cells(side, side, row, column)
    return Truth("plane", xyz, cells, np.zeros(3), omega, leaf, np.full(len(xyz), FLAT), judged)
