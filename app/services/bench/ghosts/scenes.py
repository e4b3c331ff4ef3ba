"""Scans whose ghost points are known: our simulator's, by seeds, and two of another one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.services.beams import beam_of_instrument, typed_beam
from app.services.bench.ghosts.parts import list_ranges
from app.services.bench.ghosts.plans import PLANS, Plan
from app.services.bench.ghosts.truth import WHOLE, Scene, cells_of, ranges_of, strip_truth
from app.services.reading import read_file
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.scene_file import decode_scene
from app.simulate.virtual_scan import arrange

FIRST_SEED = 100
"""Seeds below are for development; what is reported comes from here on."""
OTHERS = ("phase_shift", "pulsed")
NEEDED = ("distance_to_surface_m", "range_shift_m", "leaf", "range_sigma_m", "hit_fraction")


def list_plans() -> tuple[str, ...]:
    """Names of all scenes of our simulator."""
    return tuple(plan.name for plan in PLANS)


def make_scene(
    name: str, seed: int, quick: bool = False, others: bool = False, step_deg: float | None = None
) -> Scene:
    """Simulate a scene; the same arguments give the same one.

    Parameters
    ----------
    name : str
        One of `list_plans()`.
    seed : int
        Of leaves and noise. Below `FIRST_SEED` for development.
    quick : bool
        At a coarse step: few points.
    others : bool
        Tell the ranges of the second and third surface too, by a second scan.
    step_deg : float, optional
        Instead of the plan's.

    Raises
    ------
    WrongUse
        There is no scene of that name.
    """
    plan = next((plan for plan in PLANS if plan.name == name), None)
    if plan is None:
        raise WrongUse(f"There is no scene {name!r}.", f"Scenes: {', '.join(list_plans())}.")
    step = step_deg or (plan.quick_step if quick else plan.step)
    return scan_plan(plan, seed, step, others)


def scan_plan(plan: Plan, seed: int, step_deg: float, others: bool = False) -> Scene:
    """Simulate a plan at a step of its beams; see `make_scene`."""
    document = {"name": plan.name, "seed": seed} | plan.document
    tool = _tune(get_instrument(plan.instrument), plan.noise)
    setup = arrange(decode_scene(document, plan.name), tool, step_deg)
    scan = setup.scan().scan
    at = scan.attributes
    leaf = at["truth_leaf"].astype(np.int64)
    ranges = list_ranges(setup, scan) if others else np.full((len(leaf), 2), np.nan)
    return Scene(
        plan.name,
        plan.group,
        strip_truth(scan),
        beam_of_instrument(plan.instrument),
        seed,
        off=at["truth_distance"].astype(np.float64),
        full=(at["truth_hit_fraction"] > WHOLE) & (leaf >= 0),
        leaf=leaf,
        main=at["truth_range"] - at["truth_range_shift"],
        others=ranges,
        sigma=at["truth_sigma_range"].astype(np.float64),
        exact=np.ones(len(leaf), bool),
    )


def _tune(tool: Instrument, noise: float | None) -> Instrument:
    """The instrument with range noise of that σ at 90 % reflectance, at any range."""
    if noise is None:
        return tool
    return replace(tool, receiver=replace(tool.receiver, range_noise=noise, reference=None))


def read_other(folder: Path, name: str) -> Scene:
    """A scan of another simulator: `name` of `OTHERS`.

    Its noise-free ranges are not in the files. The wall is a known plane across x, so that the
    range of points dominated by it is exact. At leaves `main` is the scanned range less the
    shift: it holds the noise of that point. Ranges of other surfaces are not told.

    Raises
    ------
    BadInput
        A file is missing, or is not what it should be.
    """
    scan = read_file(folder / f"{name}.ptx")[0]
    cells_of(scan)
    off, shift, leaf, sigma, share = _read_truth(folder / f"{name}_truth.npz", len(scan))
    own, wall = ranges_of(scan), leaf < 0
    main, far = own - shift, (scan.xyz - scan.scanner("ghost points"))[:, 0]
    main[wall] = np.median(far[wall & (share > WHOLE)]) * own[wall] / far[wall]
    return Scene(
        f"other {name}",
        "phase shift" if name == "phase_shift" else "pulsed, close",
        scan,
        typed_beam(3.0, 0.014),
        seed=-1,
        off=off,
        full=(share > WHOLE) & ~wall,
        leaf=leaf.astype(np.int64),
        main=main,
        others=np.full((len(leaf), 2), np.nan),
        sigma=sigma,
        exact=wall,
    )


def _read_truth(path: Path, count: int) -> list[Floats]:
    """The columns of `NEEDED`, each of that length."""
    try:
        with np.load(path, allow_pickle=False) as file:
            found = [file[key].astype(np.float64) for key in NEEDED]
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"The truth in {path} cannot be read: {error}.") from error
    for values in found:
        if values.shape != (count,):
            raise BadInput(f"{path} tells of {values.shape} points, its scan has {count}.")
    return found
