"""A scan of a scene file in one call: what the command, the window and a script use."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import msgspec

from app.core.progress import QUIET, Progress
from app.simulate.beam import BeamGrid
from app.simulate.detector import Detector, Ideal
from app.simulate.instrument import Instrument, get_instrument, read_instrument
from app.simulate.ranging import Pulsed, Ranging
from app.simulate.scene_building import build_scene, lay_grid
from app.simulate.scene_file import SceneFile, get_scene, read_scene
from app.simulate.simulation import Simulation, run_simulation
from app.simulate.surfaces import Scene

Noise = Literal["none", "white", "filtered"]


@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """All that a scan needs, ready to run."""

    file: SceneFile
    instrument: Instrument
    scene: Scene
    grid: BeamGrid

    @property
    def beams(self) -> int:
        """Number of beams."""
        return self.grid.rows * self.grid.columns

    def scan(self, keep_waveforms: bool = False, progress: Progress = QUIET) -> Simulation:
        """Send out all beams."""
        place, seed = self.file.position, self.file.seed
        return run_simulation(
            self.scene, self.grid, self.instrument, place, seed, progress, keep_waveforms
        )


def simulate(
    scene: SceneFile | Path | str,
    instrument: Instrument | str | None = None,
    seed: int | None = None,
    step_deg: float | None = None,
    noise: Noise | None = None,
    keep_waveforms: bool = False,
    progress: Progress = QUIET,
) -> Simulation:
    """Scan a scene with an instrument; the same arguments give the same scan, bit for bit.

    Parameters
    ----------
    scene : SceneFile, Path or str
        A scene; text is the name of a ready one, or ends in .toml and is a file.
    instrument : Instrument or str, optional
        Text is a preset's name, or ends in .toml and is a file; the scene's own when left out.
    seed : int, optional
        Of the scene and of the noise; the scene's own when left out.
    step_deg : float, optional
        Step between beams; the scene's, or the instrument's, when left out.
    noise : {"none", "white", "filtered"}, optional
        Range noise, for filtered averaged over 3 × 3 neighbours; none takes all other noise
        away too, and dropouts. The instrument's when left out.
    keep_waveforms : bool
        Keep the digitised returns, where the instrument digitises.

    Raises
    ------
    BadInput
        The scene or the instrument cannot be understood.
    WrongUse
        There is no scene or instrument of that name.
    Cancelled
    """
    known = scene if isinstance(scene, SceneFile) else find_scene(scene)
    if seed is not None:
        known = msgspec.structs.replace(known, seed=seed)
    tool = known.instrument if instrument is None else instrument
    tool = tool if isinstance(tool, Instrument) else find_instrument(tool)
    tool = tool if noise is None else set_noise(tool, noise)
    return arrange(known, tool, step_deg).scan(keep_waveforms, progress)


def arrange(scene: SceneFile, instrument: Instrument, step_deg: float | None = None) -> Setup:
    """Build a scene and lay the beams; raises as `simulate` does."""
    built = build_scene(scene, instrument.wavelengths_nm)
    own = instrument.step_deg if scene.step_deg is None else scene.step_deg
    grid = lay_grid(scene, built, own if step_deg is None else step_deg)
    return Setup(scene, instrument, built, grid)


def find_scene(name: Path | str) -> SceneFile:
    """A scene by its file, or by the name of a ready one."""
    if isinstance(name, Path) or name.lower().endswith(".toml"):
        return read_scene(Path(name))
    return get_scene(name)


def find_instrument(name: str) -> Instrument:
    """An instrument by its file, or by the name of a preset."""
    if name.lower().endswith(".toml"):
        return read_instrument(Path(name))
    return get_instrument(name)


def set_noise(instrument: Instrument, noise: Noise) -> Instrument:
    """The instrument with its range noise white, filtered, or no noise at all.

    DN stay whole numbers: rounding is no noise.
    """
    receiver = instrument.receiver
    if noise != "none":
        return replace(instrument, receiver=replace(receiver, correlation=noise))
    silent = replace(receiver, range_noise=0.0, intensity_noise=0.0, dropout=0.0)
    return replace(
        instrument,
        receiver=silent,
        detector=_silence_detector(instrument.detector),
        ranging=_silence_ranging(instrument.ranging),
    )


def _silence_detector(detector: Detector) -> Detector:
    if isinstance(detector, Ideal):
        return detector
    return replace(detector, scale=replace(detector.scale, electronic_noise=0.0))


def _silence_ranging(ranging: Ranging) -> Ranging:
    if not isinstance(ranging, Pulsed) or ranging.waveform is None:
        return ranging
    return replace(ranging, waveform=replace(ranging.waveform, noise=0.0))
