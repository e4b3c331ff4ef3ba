"""The demo: a simulated branch with leaves, and a run of the main job on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import platformdirs

from app import __version__
from app.core.progress import QUIET, Progress
from app.core.units import count_points, group_digits
from app.formats.atomic import refuse_target
from app.formats.cloud import Cloud
from app.model.project import Project
from app.model.view_state import ViewState
from app.services.cleaning import mark_ghosts
from app.services.curves import fit_leaves, use_fit
from app.services.export import export, gather
from app.services.leaves import find_leaves, measure_leaves, write_table
from app.services.opening import Opening, open_file
from app.services.sessions import save_session
from app.services.snapshot import write_picture

CHANNEL = "reflectance_1063"
PICTURES = (CHANNEL, "ndi", "incidence", "delta_omega", "ghost_score", "leaf")
FILES = (*(f"{name}.png" for name in PICTURES), "leaves.csv", "points.laz", "demo.leafscope")
SIZE = (1280, 800)


def demo_file(progress: Progress = QUIET) -> Path:
    """The demo scan as a file in the user's cache; simulated when it is not there yet."""
    folder = Path(platformdirs.user_cache_dir("leafscope")) / f"demo-{__version__}"
    path = folder / "demo-branch.laz"
    if not path.is_file():
        from app.simulate.scenes import demo_scan

        folder.mkdir(parents=True, exist_ok=True)
        progress.report(0.1, "Simulating the demo scan")
        export(Cloud(demo_scan()), path, True, progress)
    return path


def run_demo(out: Path, overwrite: bool = False, progress: Progress = QUIET) -> Iterator[str]:
    """Open, find leaves, fit, mark ghosts, write pictures and tables; a line about each."""
    for name in FILES:
        refuse_target(out / name, overwrite, folder_follows=True)
    project, (key,) = open_file(Opening(demo_file(progress)), progress)
    scan = project.state.scan(key).scan
    yield f"Opened {scan.name}: {count_points(len(scan))}."
    leaves = find_leaves(project, key, progress)
    yield f"Found {len(leaves)} leaves."
    record = fit_leaves(project, key, leaves, "lambert-beckmann", CHANNEL, progress)
    use_fit(project, record)
    yield f"Fitted {record.model} to {record.channel}: {_describe(record.result)}."
    yield f"Marked {group_digits(mark_ghosts(project, key, progress))} ghosts."
    yield from _write(project, key, out, overwrite, progress)


def _write(
    project: Project, key: str, out: Path, overwrite: bool, progress: Progress
) -> Iterator[str]:
    out.mkdir(parents=True, exist_ok=True)
    rows = measure_leaves(project, key, None, progress)
    write_table(rows, out / "leaves.csv", overwrite)
    for field in PICTURES:
        project.field(key, field, None, progress)
        view = ViewState(current=key, colour=field, show_ghosts=False)
        write_picture(project, view, out / f"{field}.png", SIZE, "light", overwrite)
    export(gather(project, key, PICTURES), out / "points.laz", overwrite, progress)
    save_session(project, ViewState(current=key, colour=CHANNEL), out / "demo.leafscope", overwrite)
    yield f"Pictures, leaves.csv, points.laz and demo.leafscope are in {out.resolve()}."


def _describe(result: dict[str, object]) -> str:
    from app.core.fitting import FitResult

    values = FitResult.from_dict(result).values
    return ", ".join(f"{name} {value:.3g}" for name, value in values.items())
