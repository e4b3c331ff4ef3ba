"""Truth beside a simulated scan: a table of its leaves, and the waveforms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.formats.atomic import atomic_path
from app.formats.npz import write_arrays
from app.services.leaves import Row
from app.simulate.instrument import Instrument
from app.simulate.leaf_table import LeafTruth, tabulate_leaves
from app.simulate.ranging import Pulsed
from app.simulate.simulation import Simulation

WHOLE = 0.999
"""A share of the beam above this is a full hit."""


def tabulate_truth(simulation: Simulation) -> list[Row]:
    """A row per leaf of the scene, also of those that no beam met.

    Returns
    -------
    list of dict
        ``leaf`` (its `truth_leaf`), ``kind``, ``points`` and ``points_whole`` (those with a
        `truth_hit_fraction` above 0.999), ``area_m2`` of one side, ``length_m``, ``width_m``,
        ``centre_x`` … in metres, ``normal_x`` …, ``tilt_deg`` of the leaf's plane against the
        beam to its centre, ``water`` as a share of a fresh leaf's, ``rho_<nm>`` at 0°.
    """
    scan, scene = simulation.scan, simulation.scene
    place = scan.scanner("the tilt of a leaf")
    leaves = tabulate_leaves(scene, (float(place[0]), float(place[1]), float(place[2])))
    label, share = scan.attributes["truth_leaf"], scan.attributes["truth_hit_fraction"]
    size = max((leaf.number for leaf in leaves), default=-1) + 1
    points, whole = (
        np.bincount(label[mask], minlength=size)
        for mask in (label >= 0, (label >= 0) & (share > WHOLE))
    )
    return [
        _describe(leaf, int(points[leaf.number]), int(whole[leaf.number]), scene.wavelengths_nm)
        for leaf in leaves
    ]


def name_columns(wavelengths_nm: tuple[float, ...]) -> tuple[str, ...]:
    """The columns of `tabulate_truth`."""
    vectors = (f"{name}_{axis}" for name in ("centre", "normal") for axis in "xyz")
    sizes = ("area_m2", "length_m", "width_m")
    rho = (f"rho_{nm:.0f}" for nm in wavelengths_nm)
    return ("leaf", "kind", "points", "points_whole", *sizes, *vectors, "tilt_deg", "water", *rho)


def refuse_waveforms(instrument: Instrument) -> None:
    """Raise `WrongUse` for an instrument that digitises no waveform."""
    if count_samples(instrument) == 0:
        raise WrongUse(
            f"{instrument.title} digitises no waveform.",
            "Leave --waveforms out, or take an instrument that does, such as salca or hsl.",
        )


def count_samples(instrument: Instrument) -> int:
    """Samples of a waveform; 0 where nothing is digitised."""
    ranging = instrument.ranging
    wave = ranging.waveform if isinstance(ranging, Pulsed) else None
    return 0 if wave is None else wave.samples


def write_waveforms(
    simulation: Simulation, path: Path, overwrite: bool = False, progress: Progress = QUIET
) -> None:
    """Write the waveforms of the beams that came back, for ``numpy.load``.

    The arrays, for w beams, c channels, s samples and n points:

    - ``samples`` (w, c, s) float32, in units of the reflectance of a full hit;
    - ``start_m`` (w,) range of the first sample, metres;
    - ``step_m`` () metres of range from sample to sample;
    - ``channels`` (c,) wavelengths, nanometres;
    - ``row_of_point`` (n,) which of the w waveforms a point was found in, in the order of the
      points as they were simulated; PTX files order them anew, so match these by the next two;
    - ``row``, ``column`` (w,) cell of each waveform's beam in the grid of the scan.
    """
    waves, grid = simulation.waveforms, simulation.scan.grid
    if waves is None or grid is None:
        raise WrongUse(f"{simulation.scan.name} holds no waveforms.")
    cells = np.zeros((2, len(waves.start)), np.int32)
    cells[:, waves.of_return] = grid.row, grid.column
    arrays = {
        "samples": waves.samples,
        "start_m": waves.start,
        "step_m": np.array(waves.step),
        "channels": np.array(simulation.scene.wavelengths_nm),
        "row_of_point": waves.of_return.astype(np.int64),
        "row": cells[0],
        "column": cells[1],
    }
    with atomic_path(path, overwrite) as temporary:
        write_arrays(temporary, arrays, progress)


def _describe(leaf: LeafTruth, points: int, whole: int, wavelengths: tuple[float, ...]) -> Row:
    sizes = (leaf.area, leaf.length, leaf.width)
    numbers = (*leaf.centre, *leaf.normal, leaf.tilt_deg, leaf.water, *leaf.rho)
    values = (leaf.number, leaf.kind, points, whole, *sizes, *map(float, numbers))
    return dict(zip(name_columns(wavelengths), values, strict=True))
