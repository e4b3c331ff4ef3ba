"""Scans with leaves of known area: ours by seed, and those of another simulator."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import Bools, Ints
from app.core.errors import BadInput
from app.core.neighbours.steps import Cells, as_cells
from app.core.surfaces.crop import Layout, lay_out
from app.model.parameters import Beam
from app.model.project import Project
from app.model.scan import Scan
from app.services.bench.area.truth import TrueLeaf, tell_leaves
from app.services.opening import add_scans, set_parameters
from app.services.reading import read_file
from app.services.surfaces.echoes import find_echo
from app.simulate.instrument import get_instrument
from app.simulate.virtual_scan import simulate

KINDS = ("flat", "bent", "wrinkled")
OTHERS = ("phase_shift", "pulsed")
FIRST_SEED = 300
"""What is below was used to tune."""
FULL = 0.98
STEPS = (0.018, 0.012, 0.03)


@dataclass(frozen=True, slots=True)
class Plan:
    """A scan to make: scene, instrument (None: the scene's), seed, step in degrees."""

    scene: str
    instrument: str | None
    seed: int
    step: float


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A scan, its truth, and the ghosts by truth."""

    name: str
    layout: Layout
    cells: Cells
    leaf: Ints
    full: Bools
    ghosts: Bools
    leaves: list[TrueLeaf]
    beam: tuple[float, float]
    scan: Scan


def list_plans(quick: bool) -> list[Plan]:
    """Scans that figures are told of."""
    if quick:
        return [Plan("scattered", None, FIRST_SEED, 0.03)]
    near = [Plan("scattered", None, FIRST_SEED + k, step) for k, step in enumerate(STEPS)]
    return [
        *near,
        Plan("scattered", "ls880_filtered", FIRST_SEED + 3, 0.018),
        Plan("pulsed_leaves", None, FIRST_SEED + 4, 0.018),
        Plan("pulsed_leaves", None, FIRST_SEED + 5, 0.03),
        Plan("branch", None, FIRST_SEED + 6, 0.018),
        Plan("crown", None, FIRST_SEED + 7, 0.036),
    ]


def make_case(plan: Plan) -> Case:
    """Scan a plan's scene."""
    made = simulate(plan.scene, plan.instrument, plan.seed, plan.step)
    scan, values = made.scan, made.scan.attributes
    if scan.grid is None:
        raise BadInput("The simulated scan has no rows and columns.")
    cells = as_cells(scan.grid)
    name = f"{plan.scene}, {plan.instrument or 'its own'}, {plan.step:g}°, seed {plan.seed}"
    # Crowns hide nearly all of their leaves in part: they are there for segmentation.
    leaves = [] if plan.scene == "crown" else tell_leaves(made)
    bundle = get_instrument(plan.instrument or _own(plan.scene)).bundle
    return Case(
        name, _lay(scan, cells), cells, values["truth_leaf"].astype(np.int64),
        values["truth_hit_fraction"] >= FULL, values["truth_ghost"] == 1, leaves,
        (bundle.exit_diameter / 2, bundle.half_divergence), scan,
    )  # fmt: skip


def _own(scene: str) -> str:
    return "pulsed" if scene == "pulsed_leaves" else "two_colour"


def _lay(scan: Scan, cells: Cells) -> Layout:
    scanner = scan.scanner("the area of leaves")
    return lay_out(scan.xyz, scanner, cells, False, *find_echo(scan))


def read_other(folder: Path, name: str) -> Case:
    """A scan of another simulator; which of its leaves are hidden is not told.

    Raises
    ------
    BadInput
        A file is missing, or is not what it should be.
    """
    scan = read_file(folder / f"{name}.ptx")[0]
    try:
        with np.load(folder / f"{name}_truth.npz", allow_pickle=False) as file:
            truth = {key: file[key] for key in file.files}
        leaf = truth["leaf"].astype(np.int64)
        kinds = truth["leaf_kind"]
        on = leaf >= 0
        leaves = []
        for k, area in enumerate(truth["leaf_area_m2"]):
            mine = on & (leaf == k)
            kind = KINDS[int(kinds[mine][0])] if mine.any() else "flat"
            omega = float(np.mean(truth["incidence_deg"][mine])) if mine.any() else np.nan
            leaves.append(TrueLeaf(kind, float(area), omega, np.nan, np.nan))
        full, ghosts = truth["hit_fraction"] >= FULL, truth["ghost"].astype(np.bool_)
    except (OSError, KeyError, ValueError, IndexError) as error:
        raise BadInput(f"{folder}: the truth of {name} cannot be read: {error}.") from error
    if scan.grid is None or len(leaf) != len(scan.xyz):
        raise BadInput(f"{folder / name}.ptx is not the scan that its truth tells of.")
    cells = as_cells(scan.grid)
    beam = (0.0015, float(np.deg2rad(0.014)))
    return Case(
        f"other simulator, {name}", _lay(scan, cells), cells, leaf, full, ghosts, leaves, beam,
        scan,
    )  # fmt: skip


def find_ghosts(case: Case) -> Bools:
    """Ghosts as the program finds them with this beam, (n,)."""
    project = Project()
    (key,) = add_scans(project, [case.scan])
    set_parameters(project, key, beam=Beam(*case.beam, "known"))
    return np.asarray(project.field(key, "ghost", None) == 1.0)
