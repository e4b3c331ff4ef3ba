"""The virtual scanner: a scene and a grid of beams in, echoes that know their truth out."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.chunks import run_in_pieces
from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.model.scan import Vector
from app.simulate.beam import BeamGrid
from app.simulate.bounds import enclose, plant_tree, widen
from app.simulate.instrument import Instrument
from app.simulate.ranging import Pulsed, Waveform
from app.simulate.surfaces import Scene
from app.simulate.tables import tabulate_beam, tabulate_optics, tabulate_surfaces

if TYPE_CHECKING:
    from app.core.kernels.beams import ReturnTable

BAND = 8
"""Rows that one thread takes at a time: a cancel waits for no more than these."""


@dataclass(frozen=True, slots=True, eq=False)
class Waveforms:
    """Digitised returns of the beams that came back.

    Attributes
    ----------
    samples : (w, channels, samples) float32
        In units of the reflectance of a full hit.
    start : (w,) range of the first sample, metres
    step : float
        Metres of range between samples.
    of_return : (n,) row of each return's beam
    """

    samples: AnyArray
    start: Floats
    step: float
    of_return: Ints

    def take(self, rows: Ints) -> Waveforms:
        """The waveforms of some of the returns."""
        used, of_return = np.unique(self.of_return[rows], return_inverse=True)
        return Waveforms(self.samples[used], self.start[used], self.step, of_return)


@dataclass(frozen=True, slots=True, eq=False)
class Echoes:
    """Noise-free outcome of every beam that brought something back, row by row.

    Attributes
    ----------
    cell : (n,) row · columns + column
    distance : (n,) range that the scanner reports, metres
    off_surface : (n,) from there to the nearest surface touched, metres
    shift : (n,) reported range minus the energy-weighted one of the main surface, metres
    incidence : (n,) angle there, at the sub-ray nearest to the beam's centre, radians
    normal : (n, 3) unit normal of the facet there, facing the scanner
    energy : (n, channels) reflectance × share, for the reported range
    received : (n, channels) the same with the noise of a digitised waveform
    wander : (n, 4) what that noise did to the range, metres; σ of that, of an energy in the
        ranging channel and of one in another
    surface, share : (n, 3) surfaces and their shares of the beam; −1 and 0. The main surface,
        the one that sends back most in the ranging channel, comes first, and so on
    touched : (n,) how many surfaces the return is made of
    waveforms : Waveforms or None
    """

    cell: Ints
    distance: Floats
    off_surface: Floats
    shift: Floats
    incidence: Floats
    normal: Floats
    energy: Floats
    received: Floats
    wander: Floats
    surface: AnyArray
    share: Floats
    touched: AnyArray
    waveforms: Waveforms | None = None

    def __len__(self) -> int:
        return len(self.cell)

    def take(self, rows: Ints) -> Echoes:
        """Some of the returns, and the waveforms of their beams."""
        names = [f.name for f in fields(self) if f.name != "waveforms"]
        kept = {name: getattr(self, name)[rows] for name in names}
        return Echoes(**kept, waveforms=self.waveforms and self.waveforms.take(rows))


def trace_beams(
    scene: Scene,
    grid: BeamGrid,
    instrument: Instrument,
    origin: Vector,
    seed: int = 0,
    progress: Progress = QUIET,
    keep_waveforms: bool = False,
    hierarchy: bool = True,
) -> Echoes:
    """Send every beam of a grid into a scene.

    The energy of a sub-ray falls off with the square of its distance and follows the phase
    function of what it hits; the instrument's ranging makes returns of them.

    Parameters
    ----------
    seed : int
        Of the noise in waveforms; nothing else here is random.
    keep_waveforms : bool
        Give the waveforms too, where the instrument digitises; they are large.
    hierarchy : bool
        False: look at every surface for every beam, to compare with.

    Raises
    ------
    WrongUse
        The scene's wavelengths are not the instrument's.
    Cancelled
    """
    from app.core.kernels.beams import trace

    if scene.wavelengths_nm != instrument.wavelengths_nm:
        raise WrongUse(
            f"The scene {scene.name} is made for {scene.wavelengths_nm} nm, "
            f"{instrument.title} measures {instrument.wavelengths_nm} nm."
        )
    tables = _tabulate(scene, grid, instrument, np.array(origin, np.float64), hierarchy)
    found: dict[int, ReturnTable] = {}

    def trace_band(first: int, end: int) -> None:
        noise = _draw_waveform_noise(instrument, (end - first) * grid.columns, (seed, first))
        room = _make_room((end - first) * grid.columns, instrument, keep_waveforms)
        count, waves = trace(*tables, (first, end), noise, room)
        found[first] = _cut(room, count, waves)

    # Compiled here, the first time, where a cancel of the command line can reach it.
    progress.report(0.0, "Preparing the virtual scanner")
    trace_band(0, 0)
    borders = np.append(np.arange(0, grid.rows, BAND), grid.rows)
    run_in_pieces(trace_band, borders, progress, f"Scanning {scene.name}")
    return _join([found[first] for first in sorted(found)], instrument)


def _tabulate(
    scene: Scene, grid: BeamGrid, instrument: Instrument, origin: Floats, hierarchy: bool
) -> tuple[Any, ...]:
    """What the tracer gets of everything that it does not write to."""
    corners = widen(enclose(scene), instrument.bundle, origin)
    return (
        tabulate_surfaces(scene),
        plant_tree(*corners, split=hierarchy),
        tabulate_optics(scene),
        tabulate_beam(instrument),
        origin,
        grid.elevation,
        grid.azimuth,
    )


def _waveform(instrument: Instrument) -> Waveform | None:
    ranging = instrument.ranging
    return ranging.waveform if isinstance(ranging, Pulsed) else None


def _draw_waveform_noise(instrument: Instrument, beams: int, seed: tuple[int, int]) -> AnyArray:
    """Unit noise for each sample of a band, float32; no rows where nothing is digitised."""
    wave, channels = _waveform(instrument), len(instrument.wavelengths_nm)
    if wave is None:
        return np.empty((0, channels, 0), np.float32)
    random = np.random.default_rng(seed)
    return random.standard_normal((beams, channels, wave.samples), np.float32)


def _make_room(beams: int, instrument: Instrument, keep_waveforms: bool) -> ReturnTable:
    from app.core.kernels import beams as kernel

    ranging, channels = instrument.ranging, len(instrument.wavelengths_nm)
    most = ranging.most if isinstance(ranging, Pulsed) and ranging.pick == "all" else 1
    wave, rows = _waveform(instrument) if keep_waveforms else None, beams * most
    return kernel.ReturnTable(
        np.empty((rows, kernel.ENERGY + channels * (2 if _waveform(instrument) else 1))),
        np.zeros((rows, kernel.WAVE + 1), np.int64),
        np.empty((beams if wave else 0, channels, wave.samples if wave else 0), np.float32),
        np.empty(beams if wave else 0),
    )


def _cut(room: ReturnTable, count: int, waves: int) -> ReturnTable:
    """The rows that were filled, so that a band holds no more memory than its returns."""
    return room._replace(
        values=room.values[:count].copy(),
        labels=room.labels[:count].copy(),
        wave=room.wave[:waves].copy(),
        wave_start=room.wave_start[:waves].copy(),
    )


def _join(bands: list[ReturnTable], instrument: Instrument) -> Echoes:
    from app.core.kernels import beams as kernel

    values = np.concatenate([band.values for band in bands])
    labels = np.concatenate([band.labels for band in bands])
    wave, waveforms = _waveform(instrument), None
    channels = len(instrument.wavelengths_nm)
    if wave is not None and bands[0].wave.shape[2]:
        before = np.cumsum([0, *(len(band.wave) for band in bands[:-1])])
        waveforms = Waveforms(
            np.concatenate([band.wave for band in bands]),
            np.concatenate([band.wave_start for band in bands]),
            wave.step,
            labels[:, kernel.WAVE] + np.repeat(before, [len(band.labels) for band in bands]),
        )
    return Echoes(
        cell=labels[:, kernel.CELL],
        distance=values[:, kernel.DISTANCE],
        off_surface=values[:, kernel.OFF],
        shift=values[:, kernel.SHIFT],
        incidence=values[:, kernel.OMEGA],
        normal=values[:, kernel.NORMAL : kernel.SHARE],
        energy=values[:, kernel.ENERGY : kernel.ENERGY + channels],
        received=values[:, -channels:],
        wander=values[:, kernel.WANDER : kernel.ENERGY] if wave else np.zeros((len(values), 4)),
        surface=labels[:, kernel.SURFACE : kernel.TOUCHED].astype(np.int32),
        share=values[:, kernel.SHARE : kernel.WANDER],
        touched=labels[:, kernel.TOUCHED],
        waveforms=waveforms,
    )
