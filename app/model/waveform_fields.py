"""Energies of returns as fields, from the waveforms that a scan may have.

All come from one pass over the samples, which belongs to `energy_sum`; the others read what it
found beside.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from app.core.arrays import AnyArray, Bools, Ints
from app.core.errors import BadInput
from app.core.progress import Progress
from app.core.radiometry.waveform import (
    CUT_OFF,
    MERGED,
    NO_FIT,
    NO_SIGNAL,
    SATURATED,
    Returns,
    measure_returns,
)
from app.model.fields import Compute, Computed, Evaluation, FieldSpec
from app.model.scan import Scan
from app.model.waveforms import Waveforms, split_points

SUM = "energy_sum"
TROUBLE = {
    NO_SIGNAL: "without_signal",
    MERGED: "merged",
    CUT_OFF: "cut_off",
    SATURATED: "saturated",
    NO_FIT: "without_gaussian",
}
"""Name of each mark in the notes."""


def waveform_fields(scan: Scan) -> tuple[FieldSpec, ...]:
    """The energies, for a scan that has waveforms."""
    return ENERGIES if scan.waveforms is not None else ()


def compute_energy_sum(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Energy of the return by the sum method (Hancock et al. 2017), V·ns.

    NaN where a point has no waveform, or nothing above the threshold. Beside it lie ``sigma``,
    ``peak``, ``peak_sigma``, ``gaussian``, ``gaussian_sigma``, ``marks`` (bits of
    `app.core.radiometry.waveform`) and ``saturated`` (number of samples).
    """
    scan = evaluation.subject.state.scan
    if scan.waveforms is None:
        raise BadInput(f"{scan.name} has no waveforms, and the energy of a return needs one.")
    asked = np.arange(len(scan)) if points is None else points
    sigmas = evaluation.subject.state.parameters.waveform_threshold
    found, has = measure_points(scan.waveforms, asked, sigmas, evaluation.progress)
    beside: dict[str, AnyArray] = {
        "sigma": found.sum_sigma.astype(np.float32),
        "peak": found.peak,
        "peak_sigma": found.peak_sigma.astype(np.float32),
        "gaussian": found.gaussian,
        "gaussian_sigma": found.gaussian_sigma.astype(np.float32),
        "marks": found.marks,
        "saturated": found.saturated,
    }
    return Computed(found.sum, _tell(found, has, sigmas), beside=beside)


def measure_points(
    waveforms: Waveforms, points: Ints, sigmas: float, progress: Progress
) -> tuple[Returns, Bools]:
    """The returns of some points, and which of them have a waveform; read piece by piece."""
    pieces = split_points(waveforms, points)
    parts: list[Returns] = []
    has: list[Bools] = []
    for i, piece in enumerate(pieces):
        part = progress.part(i / len(pieces), (i + 1) / len(pieces))
        part.report(0.0, "Reading waveforms")
        packets = waveforms.read(piece)
        parts.append(
            measure_returns(
                packets.samples, packets.offsets, packets.place, packets.step_ns, sigmas,
                packets.quantum, packets.ceiling, progress=part,
            )
        )  # fmt: skip
        has.append(np.diff(packets.offsets) > 0)
    names = [f.name for f in fields(Returns)]
    joined: dict[str, AnyArray] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in names
    }
    return Returns(**joined), np.concatenate(has)


def _tell(found: Returns, has: Bools, sigmas: float) -> dict[str, object]:
    """Threshold and noise, and how many returns are not as they should be."""
    noise = float(np.median(found.noise[has])) if has.any() else None
    counts = {name: int((found.marks[has] & bit > 0).sum()) for bit, name in TROUBLE.items()}
    return {
        "threshold_sigmas": sigmas,
        "median_noise_v": noise,
        "median_threshold_v": None if noise is None else noise * sigmas,
        "without_waveform": int((~has).sum()),
        **counts,
    }


def read_beside(what: str) -> Compute:
    """How a field gets what the sum's pass over the samples found besides."""

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        values = evaluation.read_beside(SUM, what, points).astype(np.float64)
        marks = evaluation.read_beside(SUM, "marks", points)
        counts = {name: int((marks & bit > 0).sum()) for bit, name in TROUBLE.items()}
        return Computed(values, counts)

    return compute


def _beside(name: str, title: str, unit: str, what: str) -> FieldSpec:
    return FieldSpec(name, title, unit, "scalar", read_beside(what), (SUM,))


ENERGIES = (
    FieldSpec(
        SUM,
        "Return energy, sum of samples",
        "V·ns",
        "scalar",
        compute_energy_sum,
        parameters=("waveform_threshold",),
    ),
    _beside("energy_peak", "Return peak", "V", "peak"),
    _beside("energy_gaussian", "Return energy, Gaussian", "V·ns", "gaussian"),
    _beside("energy_sum_sigma", "σ of the sum of samples", "V·ns", "sigma"),
    _beside("energy_peak_sigma", "σ of the peak", "V", "peak_sigma"),
    _beside("energy_gaussian_sigma", "σ of the Gaussian energy", "V·ns", "gaussian_sigma"),
)
