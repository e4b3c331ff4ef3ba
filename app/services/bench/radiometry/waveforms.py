"""Energies of digitised returns: sum, peak and Gaussian against what is simpler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log, pi, sqrt

import numpy as np

from app.core.arrays import Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry.waveform import MERGED, SIGMAS, measure_returns
from app.services.bench.results import ResultTable, Value
from app.services.bench.timing import time_in_turns, use_threads
from app.simulate.waveform import Waveform, sample_waveform

NAME = "radiometry_waveforms"
RECORDS, QUICK_RECORDS = 2000, 200
FITTED, QUICK_FITTED = 200, 20
"""Records for a fit that is called for each."""
TURNS, QUICK_TURNS = 5, 2
PULSE, STEP, SAMPLES = 0.15, 0.075, 256
"""Metres (1 ns), and how SALCA is simulated."""
WIDTH = PULSE / sqrt(8 * log(2))
AREA = PULSE * sqrt(pi / (4 * log(2)))
"""Of a pulse of height 1, metres."""
DARKEST, BRIGHTEST = 0.05, 1.0
NOTE = (
    "Records as the simulator makes them for SALCA: a pulse of 1 ns, two samples per nanosecond, "
    "reflectances 0.05 to 1 (even in their logarithm), noise in parts of a white full hit. rms and "
    "bias of the energy, percent of it; known: of the bias where it is taken out, as a calibration "
    "does; lost: no energy. Ours gives sum, peak and Gaussian in one go, so that their time is the "
    "same. highest sample, sum over all: of the whole record, its background known to be 0. "
    "Overlapping: two returns, so many pulses apart; the second, half as strong, is told as well."
)

Energies = dict[str, Floats]


@dataclass(frozen=True, slots=True)
class Case:
    """Noise of a sample, threshold in σ, and pulses to a second return (0: there is none)."""

    noise: float
    sigmas: float = SIGMAS
    apart: float = 0.0


CASES = (
    *(Case(noise) for noise in (0.0002, 0.001, 0.005, 0.02)),
    *(Case(0.001, sigmas) for sigmas in (3.0, 8.0, 16.0)),
    *(Case(0.001, apart=apart) for apart in (1.0, 1.5, 2.0, 3.0)),
)
QUICK_CASES = (Case(0.001), Case(0.001, apart=1.5))


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """Waveforms, (n, samples), where their first returns are, in samples, and the energies."""

    samples: Floats
    place: Floats
    energy: Floats


def measure_waveforms(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """All cases, all ways.

    Raises
    ------
    Cancelled
    """
    rows: list[dict[str, Value]] = []
    cases = QUICK_CASES if quick else CASES
    for place, case in enumerate(cases):
        part = progress.part(place / len(cases), (place + 1) / len(cases))
        rows += _measure(case, quick, part)
    return ResultTable(NAME, "Energies of digitised returns", rows, NOTE)


def draw_records(case: Case, count: int, seed: int = 3) -> Records:
    """Records of one return, or of two."""
    random = np.random.default_rng(seed)
    waveform = Waveform(STEP, SAMPLES, case.noise)
    energy = np.exp(random.uniform(log(DARKEST), log(BRIGHTEST), count))
    # The record begins at a sample that the trigger, not the pulse, decides.
    away = 10.0 + random.uniform(0.0, STEP, count)
    rows, places = [], []
    for k in range(count):
        distances, energies = [10.0 - 20 * STEP, away[k]], [0.0, energy[k]]
        if case.apart:
            distances.append(away[k] + case.apart * PULSE)
            energies.append(energy[k] / 2)
        ranges, values = sample_waveform(
            np.array(distances),
            np.array(energies),
            PULSE,
            waveform,
            random.standard_normal(SAMPLES),
        )
        rows.append(values)
        places.append((away[k] - ranges[0]) / STEP)
    return Records(np.array(rows), np.array(places), energy)


def _measure(case: Case, quick: bool, progress: Progress) -> list[dict[str, Value]]:
    records = draw_records(case, QUICK_RECORDS if quick else RECORDS)
    few = QUICK_FITTED if quick else FITTED
    some = Records(*(part[:few] for part in (records.samples, records.place, records.energy)))
    found: Energies = {}
    merged = _measure_ours(records, case, found)
    found["highest sample"] = take_highest(records)
    found["sum over all"] = sum_all(records, case)
    found["curve_fit"] = fit_each(some)
    runs: dict[str, Callable[[], object]] = {
        "ours": lambda: _measure_ours(records, case, {}),
        "highest sample": lambda: take_highest(records),
        "sum over all": lambda: sum_all(records, case),
        "curve_fit": lambda: fit_each(some),
    }
    with use_threads(1):
        timings = time_in_turns(runs, QUICK_TURNS if quick else TURNS, progress)
    rows = []
    for way, energy in found.items():
        taken = timings[way if way in timings else "ours"].median / len(energy)
        row = _tell(case, way, energy, records.energy[: len(energy)], taken)
        rows.append(
            row | {"merged": merged if way in ("sum", "peak", "gaussian") else float("nan")}
        )
    return rows


def _tell(case: Case, way: str, found: Floats, true: Floats, taken: float) -> dict[str, Value]:
    away = found / true - 1.0
    known = away[np.isfinite(away)]
    return {
        "noise_percent": 100 * case.noise,
        "threshold_sigma": case.sigmas,
        "pulses_apart": case.apart or float("nan"),
        "way": way,
        "us_per_return": float(f"{1e6 * taken:.3g}"),
        "rms_percent": float(f"{100 * np.sqrt(np.mean(known**2)):.3g}"),
        "bias_percent": float(f"{100 * known.mean():.3g}"),
        "sd_percent": float(f"{100 * known.std():.3g}"),
        "lost_percent": float(f"{100 * (1 - len(known) / len(away)):.3g}"),
    }


def _measure_ours(records: Records, case: Case, found: Energies) -> float:
    """Put our three energies into `found`; share of merged returns."""
    count, length = records.samples.shape
    offsets = np.arange(count + 1, dtype=np.int64) * length
    returns = measure_returns(records.samples.ravel(), offsets, records.place, STEP, case.sigmas)
    found["sum"], found["gaussian"] = returns.sum / AREA, returns.gaussian / AREA
    found["peak"] = returns.peak
    return float(np.mean((returns.marks & MERGED) > 0))


def take_highest(records: Records) -> Floats:
    """The highest sample."""
    return np.asarray(records.samples.max(axis=1))


def sum_all(records: Records, case: Case) -> Floats:
    """All samples above the threshold."""
    gate = case.sigmas * case.noise
    return np.asarray(
        np.where(records.samples > gate, records.samples, 0.0).sum(axis=1) * STEP / AREA
    )


def fit_each(records: Records) -> Floats:
    """A Gaussian by scipy's curve_fit, one record after the other."""
    from scipy.optimize import curve_fit

    x = np.arange(records.samples.shape[1], dtype=float)

    def pulse(at: Floats, height: float, middle: float, width: float, level: float) -> Floats:
        return np.asarray(level + height * np.exp(-0.5 * ((at - middle) / width) ** 2))

    found = np.full(len(records.samples), np.nan)
    for k, values in enumerate(records.samples):
        start = (values.max(), records.place[k], WIDTH / STEP, 0.0)
        try:
            height, _, width, _ = curve_fit(pulse, x, values, start)[0]
        except RuntimeError:  # it gave up
            continue
        found[k] = height * abs(width) * STEP * sqrt(2 * pi) / AREA
    return found
