"""A simulated scan: echoes, noise, the instrument's numbers, and the truth beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Ints, read_only
from app.core.progress import QUIET, Progress
from app.model.scan import Channel, Grid, Pose, Scan, Vector
from app.simulate.beam import BeamGrid
from app.simulate.detector import Recorded, record
from app.simulate.instrument import Instrument
from app.simulate.ranging import PhaseShift
from app.simulate.receiver import choose_returns, draw_noise, range_sigma
from app.simulate.scanner import Waveforms, trace_beams
from app.simulate.surfaces import Scene
from app.simulate.truth import name_surfaces, tell_truth


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """A scan with its truth, the scene that it shows, and waveforms if they were kept."""

    scan: Scan
    scene: Scene
    waveforms: Waveforms | None = None


def run_simulation(
    scene: Scene,
    grid: BeamGrid,
    instrument: Instrument,
    origin: Vector = (0.0, 0.0, 0.0),
    seed: int = 0,
    progress: Progress = QUIET,
    keep_waveforms: bool = False,
) -> Simulation:
    """Scan a scene; the same seed gives the same scan, bit for bit.

    Returns
    -------
    Simulation
        The scan has the instrument's channels, the grid with its no-return cells, the truth of
        `truth.tell_truth`, ``truth_sigma_<channel>`` and, where the detector has limits,
        ``truth_saturated``; ``return_number`` and ``number_of_returns`` where a beam may have
        several returns.

    Raises
    ------
    WrongUse
        The scene's wavelengths are not the instrument's.
    Cancelled
    """
    echoes = trace_beams(scene, grid, instrument, origin, seed, progress, keep_waveforms)
    random = np.random.default_rng(seed)
    receiver, ranging = instrument.receiver, instrument.ranging_channel
    chosen = choose_returns(echoes.distance, echoes.energy[:, ranging], receiver, random)
    if not chosen.all():  # a copy of everything takes as long as the noise
        echoes = echoes.take(np.flatnonzero(chosen))
    sigma = range_sigma(echoes.energy[:, ranging], echoes.distance, receiver)
    shape = (grid.rows, grid.columns)
    noise = draw_noise(shape, echoes.cell, receiver.correlation, random)
    own = np.arange(len(instrument.wavelengths_nm)) == ranging
    spread = np.where(own, echoes.wander[:, 2:3], echoes.wander[:, 3:])
    recorded = record(
        echoes.received, echoes.distance, instrument.detector, receiver, random, spread
    )
    beams = grid.directions_of(echoes.cell)
    reported = echoes.distance + echoes.wander[:, 0] + sigma * noise
    xyz = np.array(origin) + reported[:, None] * beams
    attributes = _name_values(instrument, recorded) | tell_truth(
        scene, echoes, np.hypot(sigma, echoes.wander[:, 1])
    )
    attributes |= _name_deviations(instrument, recorded)
    if not isinstance(instrument.ranging, PhaseShift) and instrument.ranging.pick == "all":
        attributes |= number_returns(echoes.cell)
    scan = Scan(
        name=scene.name,
        xyz=read_only(xyz),
        attributes={key: read_only(column) for key, column in attributes.items()},
        channels=name_channels(instrument),
        pose=Pose((float(origin[0]), float(origin[1]), float(origin[2]))),
        grid=place_in_grid(grid, echoes.cell),
        metadata=_describe(scene, instrument, seed),
    )
    return Simulation(scan, scene, echoes.waveforms)


def scan_scene(
    scene: Scene,
    grid: BeamGrid,
    instrument: Instrument,
    origin: Vector = (0.0, 0.0, 0.0),
    seed: int = 0,
) -> Scan:
    """The scan alone of `run_simulation`."""
    return run_simulation(scene, grid, instrument, origin, seed).scan


def place_in_grid(grid: BeamGrid, hit: AnyArray) -> Grid:
    """Cells of the returns `hit` (row · columns + column); the rest had no return."""
    silent = np.ones(grid.rows * grid.columns, bool)
    silent[hit] = False
    return Grid(
        grid.rows,
        grid.columns,
        read_only((hit // grid.columns).astype(np.int32)),
        read_only((hit % grid.columns).astype(np.int32)),
        read_only(np.flatnonzero(silent)),
    )


def number_returns(cell: Ints) -> dict[str, AnyArray]:
    """Which return of its beam each point is, and of how many; a beam's returns are in order."""
    _, first, beam, count = np.unique(
        cell, return_index=True, return_inverse=True, return_counts=True
    )
    return {
        "return_number": (np.arange(len(cell)) - first[beam] + 1).astype(np.uint8),
        "number_of_returns": count[beam].astype(np.uint8),
    }


def name_channels(instrument: Instrument) -> tuple[Channel, ...]:
    """The channels that a scan of this instrument has."""
    kind = instrument.detector.kind
    stem = "reflectance" if kind == "reflectance" else "intensity"
    note = f"simulated {instrument.title}, noise {instrument.receiver.intensity_noise:.1%}"
    names = [f"{stem}_{nm:.0f}" for nm in instrument.wavelengths_nm]
    pairs = zip(names, instrument.wavelengths_nm, strict=True)
    return tuple(Channel(name, name, nm, kind, note) for name, nm in pairs)


def _name_values(instrument: Instrument, recorded: Recorded) -> dict[str, AnyArray]:
    names = [channel.attribute for channel in name_channels(instrument)]
    return {name: recorded.values[:, k].astype(np.float32) for k, name in enumerate(names)}


def _name_deviations(instrument: Instrument, recorded: Recorded) -> dict[str, AnyArray]:
    names = [f"truth_sigma_{channel.attribute}" for channel in name_channels(instrument)]
    found = {name: recorded.sigma[:, k].astype(np.float32) for k, name in enumerate(names)}
    if instrument.detector.kind == "DN":
        found["truth_saturated"] = np.any(recorded.saturated, axis=1).astype(np.uint8)
    return found


def _describe(scene: Scene, instrument: Instrument, seed: int) -> dict[str, str]:
    facts = {"instrument": f"simulated: {instrument.title}", "seed": str(seed)}
    silent = instrument.receiver.range_noise == 0
    facts["range noise"] = "none" if silent else instrument.receiver.correlation
    notes = {f"instrument note {k}": note for k, note in enumerate(instrument.notes, start=1)}
    return facts | notes | name_surfaces(scene)
