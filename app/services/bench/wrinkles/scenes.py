"""Leaves with the true angle at every point: of our simulator, and of another one's files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.footprint import footprint_axis
from app.core.phase import get_model
from app.core.progress import QUIET, Progress
from app.core.radiometry.partial_hits import FULL_HIT, hit_fraction
from app.core.synthetic_footprint import find_lines
from app.core.units import to_radians
from app.core.wrinkling.leaf import LeafPoints
from app.core.wrinkling.means import cut_grid
from app.core.wrinkling.offset import Scale
from app.model.scan import Scan
from app.services.bench.simulate.other_scene import GLOSS, SCENES, Name
from app.services.reading import read_file
from app.simulate.detector import Logarithmic
from app.simulate.instrument import get_instrument
from app.simulate.material import Sheen
from app.simulate.surfaces import Leaf
from app.simulate.virtual_scan import simulate

KINDS = ("flat", "bent", "wrinkled")
FIRST_SEED = 201
LEAST_FULL = 50
"""Full hits from which a leaf is looked at."""
LB = get_model("lambert-beckmann")
DIVERGENCE = float(to_radians(0.014))
BEAM_RADIUS = 0.0015
QUICK_STEP = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class TrueLeaf:
    """A leaf and what is true of it.

    Attributes
    ----------
    scene : str
    kind : str
        One of `KINDS`.
    points : LeafPoints
    omega : (k,) radians
        True angle of incidence.
    full : (k,) bools
        Hits that are full in truth: the points that figures speak of, beside all.
    sheen : dict of str to float
        f, k_d and m of its curve, in reflectance.
    scale : {'linear', 'log'}
    per_decade, zero : float
        DN = per_decade · log10 ρ + zero of a logarithmic scale.
    """

    scene: str
    kind: str
    points: LeafPoints
    omega: Floats
    full: Bools
    sheen: dict[str, float]
    scale: Scale = "linear"
    per_decade: float | None = None
    zero: float = 0.0

    def respond(self, angle: Floats) -> Floats:
        """What the instrument gives at an angle, without noise."""
        value = LB.evaluate(angle, self.sheen)
        if self.per_decade is None:
            return value
        return np.asarray(self.per_decade * np.log10(value) + self.zero, np.float64)


@dataclass(frozen=True, slots=True)
class Plan:
    """A scene of our simulator."""

    title: str
    instrument: str
    channel: str
    seed: int
    step_deg: float | None = None


def list_plans(quick: bool) -> tuple[Plan, ...]:
    """Scenes: two colours at 1545 and 1063 nm, and the logarithmic LS880; seeds from 201 on."""
    first = FIRST_SEED
    if quick:
        return (Plan("two colours, 1545 nm", "two_colour", "reflectance_1545", first, QUICK_STEP),)
    return (
        Plan("two colours, 1545 nm", "two_colour", "reflectance_1545", first),
        Plan("two colours, 1545 nm", "two_colour", "reflectance_1545", first + 1),
        Plan("two colours, 1063 nm", "two_colour", "reflectance_1063", first + 2),
        Plan("LS880, 785 nm, DN", "ls880", "intensity_785", first + 3),
    )


def scan_plan(plan: Plan, progress: Progress = QUIET) -> list[TrueLeaf]:
    """Simulate a scene, and take its leaves."""
    made = simulate("scattered", plan.instrument, plan.seed, plan.step_deg, progress=progress)
    scan, tool = made.scan, get_instrument(plan.instrument)
    truth = scan.attributes
    values = _level_range(scan, plan)
    place = [channel.name for channel in scan.channels].index(plan.channel)
    decade, zero = None, 0.0
    if isinstance(tool.detector, Logarithmic):
        decade, zero = tool.detector.a0[place], tool.detector.a1[place]
    on_leaf = truth["truth_ghost"] == 0
    numbers = np.where(on_leaf, truth["truth_leaf"], -1)
    saturated = truth.get("truth_saturated", np.zeros(len(scan), np.uint8)) > 0
    sheens = [_read_sheen(leaf.material[place]) for leaf in made.scene.leaves]
    kinds = [_name_kind(leaf) for leaf in made.scene.leaves]
    whole = truth["truth_hit_fraction"] > FULL_HIT
    omega = to_radians(truth["truth_incidence"].astype(np.float64))
    title = f"{plan.title}, seed {plan.seed}"
    return [
        TrueLeaf(title, kinds[k], points, omega[own], whole[own], sheens[k],
                 "linear" if decade is None else "log", decade, zero)
        for k, own, points in _take_leaves(scan, values, numbers, saturated)
    ]  # fmt: skip


def _level_range(scan: Scan, plan: Plan) -> Floats:
    """Values without the effect of the range, which other benches judge."""
    values = scan.channel_values(plan.channel)
    detector = get_instrument(plan.instrument).detector
    if not isinstance(detector, Logarithmic):
        return values
    away = np.linalg.norm(scan.xyz - scan.scanner("ranges"), axis=1)
    strength = detector.range_effect.strength(away, 0)
    return np.asarray(values - detector.a0[0] * np.log10(strength), np.float64)


def _read_sheen(sheen: Sheen) -> dict[str, float]:
    return {"f": sheen.rho, **dict(sheen.parameters)}


def _name_kind(leaf: Leaf) -> str:
    if leaf.wrinkle_height:
        return "wrinkled"
    return "bent" if leaf.curvature else "flat"


def _take_leaves(
    scan: Scan, values: Floats, leaf: Ints, saturated: Bools
) -> Iterator[tuple[int, Ints, LeafPoints]]:
    scanner = scan.scanner("angles")
    lines = find_lines(scan.xyz, scanner, scan.grid)
    full = hit_fraction(scan.xyz, scanner, scan.grid, BEAM_RADIUS, DIVERGENCE) >= FULL_HIT
    for k in range(int(leaf.max()) + 1):
        own = np.flatnonzero(leaf == k)
        if full[own].sum() < LEAST_FULL:
            continue
        xyz = scan.xyz[own]
        away = float(np.median(np.linalg.norm(xyz - scanner, axis=1)))
        cells, part = (None, None)
        if lines is not None and scan.grid is not None:
            cells, part = cut_grid(scan.grid, lines, own)
        diameter = float(footprint_axis(away, 0.0, BEAM_RADIUS, DIVERGENCE))
        yield (
            k,
            own,
            LeafPoints(values[own], xyz, scanner, diameter, full[own], saturated[own], cells, part),
        )


def read_other(folder: Path, name: Name) -> list[TrueLeaf]:
    """Leaves of the other simulator at 1545 nm.

    How bright each leaf is, is not told: the median of ρ over the curve at its full hits is taken,
    as its goniometer would find it.

    Raises
    ------
    BadInput
        A file is missing, or is not what its README says.
    """
    try:
        with np.load(folder / f"{name}_truth.npz", allow_pickle=False) as file:
            truth = {key: file[key] for key in file.files}
        scan = read_file(folder / f"{name}.ptx")[0]
        leaf, kind = truth["leaf"].astype(np.int64), truth["leaf_kind"]
        value, share = truth["rho_1545"].astype(float), truth["hit_fraction"]
        omega = to_radians(truth["incidence_deg"].astype(float))
        bad = truth["ghost"] | truth["unsure"]
    except (OSError, KeyError) as error:
        raise BadInput(f"{folder}: {name} cannot be read: {error}.", "Check the folder.") from error
    if len(scan) != len(leaf):
        raise BadInput(f"{folder}: {name}.ptx has {len(scan)} points, its truth {len(leaf)}.")
    whole, (k_d, m) = share > FULL_HIT, GLOSS[1]
    shape = {"f": 1.0, "k_d": k_d, "m": m}
    found = []
    off = np.zeros(len(scan), bool)
    for _, own, points in _take_leaves(scan, value, np.where(bad, -1, leaf), off):
        sure = whole[own]
        if sure.sum() < LEAST_FULL:
            continue
        height = float(np.median((value[own] / LB.evaluate(omega[own], shape))[sure]))
        title = f"other simulator, {name}"
        kind_name = KINDS[int(np.median(kind[own]))]
        found.append(TrueLeaf(title, kind_name, points, omega[own], sure, {**shape, "f": height}))
    return found


OTHERS: tuple[Name, ...] = tuple(SCENES)
