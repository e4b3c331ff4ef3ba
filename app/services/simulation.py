"""One simulated scan, from what was asked for to its files and a report."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app import __version__
from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_target
from app.formats.cloud import Cloud
from app.model.truth_fields import describe_truth
from app.services.export import export, refuse_unwritable
from app.services.leaves import write_table
from app.services.simulation_order import Order, estimate, refuse_too_large, set_up
from app.services.truth_tables import (
    name_columns,
    refuse_waveforms,
    tabulate_truth,
    write_waveforms,
)
from app.simulate.instrument import Instrument
from app.simulate.ranging import Pulsed
from app.simulate.scene_file import Document
from app.simulate.simulation import Simulation
from app.simulate.virtual_scan import Setup

NO_POINT = "No beam brought back enough to be noticed: the scan has no points."


@dataclass(frozen=True, slots=True)
class Targets:
    """Files to write: the points, and if asked for the table of leaves and the waveforms."""

    points: Path
    leaves: Path | None = None
    waveforms: Path | None = None
    overwrite: bool = False

    def refuse(self) -> None:
        """Raise early where a file must not or cannot be written."""
        refuse_unwritable(self.points)
        wanted = [p for p in (self.points, self.leaves, self.waveforms) if p is not None]
        for path in wanted:
            refuse_target(path, self.overwrite)
        if len({path.resolve() for path in wanted}) < len(wanted):
            raise WrongUse("Two results cannot be one file.", "Name each differently.")


def simulate_file(order: Order, targets: Targets, progress: Progress = QUIET) -> dict[str, Any]:
    """Scan a scene and write points with their truth, and what else is asked for.

    The same order gives the same files, byte for byte (but for the date in a LAS header and the
    identifiers that E57 requires to be unique).

    Returns
    -------
    dict
        scene, instrument, seed, step_deg, beams, points, channels, ghosts (share of the points),
        seconds (of the scan, without building the scene and writing), million_beams_per_second,
        warnings (sentences), file;
        leaves_file and waveforms_file where they were asked for.

    Raises
    ------
    WrongUse, BadInput
        Before anything is computed: a file cannot be written, the scene, the instrument or a
        setting is no good, the scan would not fit into the memory.
    Cancelled
        The points were not written; an older file of them is as it was.
    """
    targets.refuse()
    document = order.document()
    setup = set_up(document, order.origin, order.noise)
    simulation, report = scan(setup, targets, progress.part(0.0, 0.8))
    made_of = describe_origin(order, document)
    return report | write(simulation, targets, made_of, progress.part(0.8, 1.0))


def scan(
    setup: Setup, targets: Targets, progress: Progress = QUIET
) -> tuple[Simulation, dict[str, Any]]:
    """Scan, and say what it came to; what cannot be done or written is refused before."""
    refuse_combination(setup.instrument, targets)
    progress.report(0.0, f"Building {setup.file.name}")
    waves = targets.waveforms is not None
    refuse_too_large(setup, estimate(setup), waves)
    start = time.perf_counter()
    simulation = setup.scan(waves, progress.part(0.05, 1.0))
    seconds = time.perf_counter() - start
    ghost = simulation.scan.attributes["truth_ghost"]
    return simulation, {
        "scene": setup.file.name,
        "instrument": setup.instrument.title,
        "seed": setup.file.seed,
        "step_deg": setup.file.step_deg or setup.instrument.step_deg,
        "beams": setup.beams,
        "points": len(ghost),
        "channels": [channel.name for channel in simulation.scan.channels],
        "ghosts": float(np.mean(ghost == 1)) if len(ghost) else 0.0,
        "seconds": seconds,
        "million_beams_per_second": setup.beams / seconds / 1e6,
        "warnings": [] if len(ghost) else [NO_POINT],
    }


def write(
    simulation: Simulation,
    targets: Targets,
    provenance: dict[str, object],
    progress: Progress = QUIET,
) -> dict[str, str]:
    """Write what the targets ask for, the points last; names of the files."""
    files = {}
    if targets.leaves is not None:
        columns = name_columns(simulation.scene.wavelengths_nm)
        write_table(tabulate_truth(simulation), targets.leaves, targets.overwrite, columns)
        files["leaves_file"] = str(targets.leaves)
    if targets.waveforms is not None:
        write_waveforms(simulation, targets.waveforms, targets.overwrite, progress.part(0, 0.5))
        files["waveforms_file"] = str(targets.waveforms)
    rest = progress.part(0.0 if targets.waveforms is None else 0.5, 1.0)
    rest.report(0.0, f"Writing {targets.points.name}")
    export(make_cloud(simulation, provenance), targets.points, targets.overwrite, rest)
    return {"file": str(targets.points)} | files


def make_cloud(simulation: Simulation, provenance: dict[str, object]) -> Cloud:
    """The scan with the units of its truth and where it came from."""
    known = {name: describe_truth(name) for name in simulation.scan.attributes}
    units = {name: field.unit for name, field in known.items() if field and field.unit}
    return Cloud(simulation.scan, {}, units, provenance)


def describe_origin(order: Order, document: Document) -> dict[str, object]:
    """All that is needed to simulate the same scan again."""
    return {
        "written_by": f"leafscope {__version__}",
        "simulated": order.origin,
        "noise": order.noise or "of the instrument",
        "scene": document,
    }


def refuse_combination(instrument: Instrument, targets: Targets) -> None:
    """Raise `WrongUse` where this instrument cannot give what is asked for."""
    if targets.waveforms is not None:
        refuse_waveforms(instrument)
    ranging = instrument.ranging
    several = isinstance(ranging, Pulsed) and ranging.pick == "all"
    if several and targets.points.suffix.lower() == ".ptx":
        raise WrongUse(
            f"{instrument.title} may give several points per beam; PTX holds one per cell.",
            "Write LAZ, E57 or NPZ.",
        )
