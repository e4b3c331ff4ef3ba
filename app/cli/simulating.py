"""The command that simulates scans; `app.cli.commands` knows it by name and loads it late."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from app.cli.commands import Json, Overwrite
from app.cli.console import watch
from app.cli.printing import print_json, print_warnings, say
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from app.services.simulation import Targets


@Parameter(name="*")
@dataclass(frozen=True)
class Choice:
    """What the scene and the instrument would otherwise say."""

    instrument: str | None = None
    "A ready instrument, or a TOML file (default: the one that the scene names)."
    seed: int | None = None
    "Of everything random (default: the scene's)."
    step_deg: float | None = None
    "Step between beams, degrees (default: the scene's, else the instrument's)."
    noise: Literal["none", "white", "filtered"] | None = None
    "Of the range: white, or filtered (neighbours alike, σ the same). none: no noise of any kind."
    settings: Annotated[tuple[str, ...], Parameter(name="--set")] = ()
    "Another value for the scene, PATH=VALUE: stage.angle_deg=30 (may be repeated)."


AS_SAID = Choice()


def simulate(
    scene: str | None = None,
    /,
    *,
    out: Path | None = None,
    choice: Choice = AS_SAID,
    series: Annotated[tuple[str, ...] | None, Parameter(consume_multiple=(0, 1))] = None,
    leaves: Path | None = None,
    waveforms: Path | None = None,
    offers: Annotated[bool, Parameter(name="--list")] = False,
    show: str | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Scan a simulated scene: points with everything that is true about them.

    Parameters
    ----------
    scene
        A ready scene (see --list), or a TOML file.
    out
        File to write: .laz, .las, .e57, .ptx or .ply; .csv or .npz for tables and numpy. With
        --series a folder, or a file whose name the files of the series begin with.
    series
        A scan for each of PATH=VALUES: stage.angle_deg=0:85:5, or hours=0,3,6. Alone: the
        series that the scene is for.
    leaves
        CSV file to write, the truth about each leaf.
    waveforms
        NPZ file to write, the digitised returns.
    offers
        Show the ready scenes and instruments.
    show
        Show a ready scene or instrument as TOML, to copy and change.
    """
    if offers:
        _list(json)
    elif show is not None:
        from app.services.simulation_offers import show_offer

        say(show_offer(show).rstrip())
    elif scene is None or out is None:
        raise WrongUse("Say which scene, and --out FILE.", "See leafscope simulate --list.")
    else:
        from app.services.simulation import Targets

        targets = Targets(out, leaves, waveforms, overwrite)
        _simulate(scene, choice, targets, None if series is None else "".join(series), json)


def _simulate(
    scene: str, choice: Choice, targets: Targets, series: str | None, as_json: bool
) -> None:
    from app.services.simulation import simulate_file
    from app.services.simulation_order import Order
    from app.services.simulation_series import simulate_series
    from app.simulate.series import parse_settings

    settings = parse_settings(choice.settings)
    order = Order(scene, choice.instrument, choice.seed, choice.step_deg, choice.noise, settings)
    if series is None:
        _print_scan(simulate_file(order, targets, watch()), as_json)
    else:
        _print_series(simulate_series(order, series, targets, watch()), as_json)


def _list(as_json: bool) -> None:
    from app.services.simulation_offers import list_offers

    found = list_offers()
    if as_json:
        print_json(found)
        return
    scenes, instruments = found["scenes"], found["instruments"]
    width = max(len(offer["name"]) for offer in (*scenes, *instruments)) + 2
    say("Scenes")
    for scene in scenes:
        say(f"  {scene['name']:{width}}{scene['description']}")
        series = scene["series"]
        if series is not None:
            ends = f"{series['values'][0]:g} to {series['values'][-1]:g}"
            say(f"  {'':{width}}--series: {series['path']}, {ends}")
    say("Instruments")
    for tool in instruments:
        nm = ", ".join(f"{nm:g}" for nm in tool["wavelengths_nm"])
        say(f"  {tool['name']:{width}}{tool['title']}: {nm} nm, step {tool['step_deg']:.3g}°")


def _print_scan(report: Mapping[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(report)
        return
    say(f"{report['scene']}, {report['instrument']}: {_sum_up(report)}")
    print_warnings(report["warnings"])
    for key in ("leaves_file", "waveforms_file", "file"):
        if key in report:
            say(f"{report[key]} written.")


def _print_series(report: Mapping[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(report)
        return
    for step in report["steps"]:
        say(f"{report['key']} {step['value']}: {step['points']:,} points, {step['file']}")
    over = f"{len(report['steps'])} scans over {report['key']}"
    say(f"{report['scene']}, {'; '.join(report['instruments'])}, {over}: {_sum_up(report)}")
    print_warnings(report["warnings"])
    for key in ("leaves_file", "table"):
        if key in report:
            say(f"{report[key]} written.")


def _sum_up(report: Mapping[str, Any]) -> str:
    return (
        f"{report['points']:,} points of {report['beams']:,} beams, {report['ghosts']:.2%} ghosts, "
        f"{report['seconds']:.1f} s, {report['million_beams_per_second']:.2f} M beams/s."
    )
