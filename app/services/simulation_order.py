"""What a user asks to be simulated, and the scene, instrument and beams that it stands for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import ceil, isqrt
from pathlib import Path
from typing import Any

import psutil

from app.core.chunks import count_processors
from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.core.units import group_digits
from app.services.reading import SHARE_OF_FREE
from app.services.truth_tables import count_samples
from app.simulate.scanner import BAND
from app.simulate.scene_file import Document, decode_scene, load_document
from app.simulate.series import vary
from app.simulate.virtual_scan import Noise, Setup, arrange, find_instrument, set_noise

PROBED = 2500
"""Beams that an estimate sends out."""
_BYTES_PER_BEAM, _BYTES_PER_POINT, _BYTES_PER_VALUE, _BYTES_PER_SAMPLE = 20, 400, 150, 4


@dataclass(frozen=True, slots=True)
class Order:
    """A scan as it is asked for; what is None is left to the scene and the instrument.

    Attributes
    ----------
    scene, instrument : str
        Name of a ready one, or a TOML file.
    settings : tuple of (path, value)
        Values of the scene file that are to be others: see `app.simulate.series.vary`.
    """

    scene: str
    instrument: str | None = None
    seed: int | None = None
    step_deg: float | None = None
    noise: Noise | None = None
    settings: tuple[tuple[str, Any], ...] = ()

    @property
    def origin(self) -> str:
        """How errors call the scene."""
        return Path(self.scene).name if self.is_file else self.scene

    @property
    def is_file(self) -> bool:
        """Whether the scene is a user's own file."""
        return self.scene.lower().endswith(".toml")

    def document(self) -> Document:
        """The scene's document with everything that is asked for in it.

        Raises
        ------
        WrongUse
            There is no such scene, or a setting does not fit it.
        BadInput
            The file cannot be understood.
        """
        document = load_document(Path(self.scene) if self.is_file else self.scene)
        decode_scene(document, self.origin)  # its own faults first, before those of settings
        own = {"instrument": self.instrument, "seed": self.seed, "step_deg": self.step_deg}
        wanted = [(path, value) for path, value in own.items() if value is not None]
        return change(document, (*wanted, *self.settings), self.origin)


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a scan will cost: beams exactly, points about."""

    beams: int
    points: int


def change(document: Document, settings: Iterable[tuple[str, Any]], origin: str) -> Document:
    """A scene's document with other values; refuses those that do not fit as wrong use."""
    for path, value in settings:
        document = vary(document, path, value)
    try:
        decode_scene(document, origin)
    except BadInput as error:
        raise WrongUse(error.what, error.hint) from error
    return document


def set_up(document: Document, origin: str, noise: Noise | None = None) -> Setup:
    """Build the scene of a document and lay the beams; raises as `virtual_scan.simulate`."""
    file = decode_scene(document, origin)
    tool = find_instrument(file.instrument)
    tool = tool if noise is None else set_noise(tool, noise)
    return arrange(file, tool)


def estimate(setup: Setup, progress: Progress = QUIET) -> Estimate:
    """Count beams, and points by a scan with few of them; loads the compiled code too."""
    grid = setup.grid
    coarser = max(1, isqrt(setup.beams // PROBED))
    few = replace(
        grid,
        step=grid.step * coarser,
        rows=max(1, grid.rows // coarser),
        columns=max(1, grid.columns // coarser),
    )
    probe = replace(setup, grid=few)
    returns = len(probe.scan(progress=progress).scan) / probe.beams
    return Estimate(setup.beams, round(returns * setup.beams))


def refuse_too_large(setup: Setup, found: Estimate, waveforms: bool = False) -> None:
    """Raise `BadInput` for a scan that the memory would not hold, `waveforms` kept or not."""
    channels, samples = len(setup.instrument.wavelengths_nm), count_samples(setup.instrument)
    per_point = _BYTES_PER_POINT + channels * (_BYTES_PER_VALUE + 8 * samples * waveforms)
    bands = min(count_processors(), ceil(setup.grid.rows / BAND))  # being traced at one time
    per_band = BAND * setup.grid.columns * channels * samples * _BYTES_PER_SAMPLE
    need = found.beams * _BYTES_PER_BEAM + found.points * per_point
    need += bands * per_band * (1 + waveforms)  # the noise of the samples; room for the samples
    may = psutil.virtual_memory().available * SHARE_OF_FREE
    if need > may:
        raise BadInput(
            f"{setup.file.name}: {group_digits(found.beams)} beams need about {need / 1e9:.1f} GB "
            f"of memory; {may / 1e9:.1f} GB may be used.",
            "Take a larger step or a smaller field.",
        )
