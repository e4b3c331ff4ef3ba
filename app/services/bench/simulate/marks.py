"""What two simulators can be compared by: the same facts of each point, however it was made."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.units import to_degrees
from app.services.bench.simulate.other_scene import COLUMNS, ROWS, SCENES, Name, imitate, rebuild
from app.services.bench.simulate.rig import HERE
from app.simulate.ranging import PhaseShift
from app.simulate.scanner import Echoes, trace_beams
from app.simulate.surfaces import Scene
from app.simulate.truth import GHOST, UNSURE, tell_truth

FULL = 0.99999
"""Part of the energy from one surface above which a point counts as a full hit."""
FEW = 30
"""Points that tell where a leaf stands."""


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """Truth of every point of a scan of leaves before a wall.

    Attributes
    ----------
    cell : (n,) row · COLUMNS + column
    leaf : (n,) leaf of the point's surface, −1 the wall
    kind : (n,) 0 flat, 1 bent, 2 wrinkled, −1 the wall
    ghost, unsure : (n,)
    distance : (n,) to the nearest surface that the beam touched, metres
    range : (n,) reported, metres
    before_wall : (n,) how far before the wall that is
    shift : (n,) reported range less that of the surface that sent most, metres
    strongest : (n,) part of the energy that came from the surface that sent most
    incidence : (n,) degrees
    rho : (n, 2) at 1063 and 1545 nm
    """

    cell: Ints
    leaf: Ints
    kind: Ints
    ghost: Bools
    unsure: Bools
    distance: Floats
    range: Floats
    before_wall: Floats
    shift: Floats
    strongest: Floats
    incidence: Floats
    rho: Floats

    @property
    def full(self) -> Bools:
        """All sub-rays on one surface."""
        return self.strongest > FULL

    def ranges_of_leaves(self) -> Floats:
        """Median range of the full hits on each leaf that has some, metres."""
        full = self.full
        leaf, away = self.leaf[full], self.range[full]
        counts = {k: (leaf == k).sum() for k in np.unique(leaf) if k >= 0}
        return np.array([np.median(away[leaf == k]) for k, n in counts.items() if n >= FEW])

    def image(self) -> Ints:
        """Leaf of each cell, −9 without return."""
        found = np.full(ROWS * COLUMNS, -9)
        found[self.cell] = self.leaf
        return found.reshape(ROWS, COLUMNS)


def read_marks(folder: Path, name: Name) -> Marks:
    """The other simulator's scan.

    Raises
    ------
    BadInput
        A file is missing, or is not what its README says.
    """
    try:
        with np.load(folder / f"{name}_truth.npz", allow_pickle=False) as file:
            truth = {key: file[key] for key in file.files}
        points = np.loadtxt(folder / f"{name}.ptx", skiprows=10, usecols=(0, 1, 2))
        points = points[(points != 0).any(axis=1)]
        distance = np.linalg.norm(points, axis=1)
        facing = points[:, 0] / distance
        return Marks(
            truth["row"] * COLUMNS + truth["col"],
            truth["leaf"].astype(np.int64),
            truth["leaf_kind"],
            truth["ghost"],
            truth["unsure"],
            truth["distance_to_surface_m"].astype(float),
            distance,
            SCENES[name].wall / facing - distance,
            truth["range_shift_m"].astype(float),
            truth["hit_fraction"].astype(float),
            truth["incidence_deg"].astype(float),
            np.stack([truth["rho_1063"], truth["rho_1545"]], axis=1).astype(float),
        )
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"{folder}: {name} cannot be read: {error}.", "Check the folder.") from error


def scan_marks(name: Name, ranges: Floats, seed: int) -> Marks:
    """Our scan of a scene of the same kind.

    The other simulator speaks of all that a beam met, even of what a pulse does not report: so
    beams are traced by phase too, which takes all.
    """
    scene, kinds = rebuild(name, ranges, seed)
    tool, grid = imitate(name)
    whole = trace_beams(scene, grid, replace(tool, ranging=PhaseShift()), HERE)
    echoes = whole if name == "phase_shift" else trace_beams(scene, grid, tool, HERE)
    main = whole.surface[:, 0].astype(np.int64)
    leaf = np.where(main < len(kinds), main, -1)
    wall = SCENES[name].wall / grid.directions_of(echoes.cell)[:, 0]
    off = echoes.off_surface
    return Marks(
        echoes.cell,
        leaf,
        np.append(kinds, -1)[leaf],
        off > GHOST,
        (off > UNSURE) & (off <= GHOST),
        off,
        echoes.distance,
        wall - echoes.distance,
        echoes.distance - whole.distance + whole.shift,
        measure_strongest(scene, whole, tool.ranging_channel),
        to_degrees(whole.incidence),
        whole.energy,
    )


def measure_strongest(scene: Scene, echoes: Echoes, channel: int) -> Floats:
    """Part of each beam's energy that came from its main surface, (n,); 1 for full hits alone."""
    nm = scene.wavelengths_nm[channel]
    reflectance = tell_truth(scene, echoes, echoes.distance)[f"truth_reflectance_{nm:.0f}"]
    away = echoes.distance - echoes.shift
    sent = echoes.share[:, 0] * reflectance / away**2
    part = np.clip(sent * echoes.distance**2 / echoes.energy[:, channel], 0.0, FULL)
    return np.where(echoes.touched == 1, 1.0, part)
