"""A scan and what is true of its ghost points, in the one form that every method is judged by."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.neighbours.steps import Cells, as_cells
from app.model.parameters import Beam
from app.model.scan import Scan

GHOST, GOOD = 0.006, 0.002
"""Metres off every surface: more is a ghost, no more is none, between counts for neither."""
WHOLE = 0.9999
"""Share of the footprint from which all of it lies on a surface."""
ENOUGH = 50
"""Full hits from which a leaf is large enough to correct ghosts to it."""

Group = Literal["phase shift", "crown", "pulsed, close", "pulsed, apart", "clean"]


@dataclass(frozen=True, eq=False)
class Scene:
    """A scan as a method gets it, and what is true of it, which no method may look at.

    Attributes
    ----------
    name : str
    group : str
        Which goals it is judged by.
    scan : Scan
        Without any truth: points, channels, grid and scanner.
    beam : Beam
    seed : int
        −1 for files.
    off : (n,) metres
        e: from the noise-free range to the nearest surface that the beam touched.
    full : (n,) bool
        The footprint lies wholly on one leaf.
    leaf : (n,) int
        Leaf with most of the energy; −1 elsewhere.
    main : (n,) metres
        Energy-weighted range of the surface with most energy, free of noise where `exact`.
    others : (n, 2) metres
        The same of the second and third surface; NaN where there is none, or it is not told.
    sigma : (n,) metres
        σ of each point's own range noise.
    exact : (n,) bool
        Where `main` is free of noise; elsewhere it holds the noise of the point itself.
    """

    name: str
    group: Group
    scan: Scan
    beam: Beam
    seed: int
    off: Floats
    full: Bools
    leaf: Ints
    main: Floats
    others: Floats
    sigma: Floats
    exact: Bools

    def __len__(self) -> int:
        return len(self.scan)

    @property
    def title(self) -> str:
        """Name and seed."""
        return self.name if self.seed < 0 else f"{self.name} ({self.seed})"

    @property
    def xyz(self) -> Floats:
        """Points, (n, 3) metres."""
        return self.scan.xyz

    @property
    def scanner(self) -> Floats:
        """Position, (3,) metres."""
        return self.scan.scanner("ghost points")

    @property
    def grid(self) -> Cells:
        """Rows and columns."""
        return cells_of(self.scan)

    @property
    def channels(self) -> dict[str, Floats]:
        """Values of each channel as recorded: reflectances, or DN."""
        return {one.name: self.scan.channel_values(one.name) for one in self.scan.channels}

    @property
    def own(self) -> Floats:
        """Ranges as scanned, (n,) metres."""
        return ranges_of(self.scan)

    @cached_property
    def ghost(self) -> Bools:
        """Points that are ghosts."""
        return np.asarray(self.off > GHOST)

    @cached_property
    def good(self) -> Bools:
        """Points that are none."""
        return np.asarray(self.off <= GOOD)

    @cached_property
    def large(self) -> Bools:
        """Points whose dominant surface is a leaf with at least `ENOUGH` full hits."""
        count = np.bincount(self.leaf[self.full], minlength=int(self.leaf.max(initial=0)) + 1)
        return np.asarray((self.leaf >= 0) & (count[self.leaf] >= ENOUGH))


def cells_of(scan: Scan) -> Cells:
    """Rows and columns of a scan; raises `BadInput` where it has none."""
    if scan.grid is None:
        raise BadInput(f"The scan {scan.name} has no rows and columns.")
    return as_cells(scan.grid)


def ranges_of(scan: Scan) -> Floats:
    """Ranges as scanned, (n,) metres."""
    away: Floats = np.linalg.norm(scan.xyz - scan.scanner("ghost points"), axis=1)
    return away


def strip_truth(scan: Scan) -> Scan:
    """The scan without the fields that tell its truth, and without words on them."""
    kept = {key: value for key, value in scan.attributes.items() if not key.startswith("truth_")}
    facts = {key: text for key, text in scan.metadata.items() if not key.startswith("truth_")}
    return replace(scan, attributes=kept, metadata=facts)
