"""The keys of an instrument's TOML file, in the units of data sheets, and what they make.

A key says its unit, and of a divergence whether it is the full or the half angle.
"""

from __future__ import annotations

from math import degrees, inf
from typing import Annotated

import msgspec

from app.core.errors import WrongUse
from app.core.units import MM_PER_M, to_radians
from app.simulate import range_effect as effects
from app.simulate.beam import Bundle
from app.simulate.detector import Digitiser, Ideal, Linear, Logarithmic, Salca
from app.simulate.ranging import PhaseShift, Pick, Pulsed, Waveform
from app.simulate.receiver import Correlation, Receiver

Numbers = tuple[float, ...]

METRES_PER_NS = 0.299792458 / 2
"""Range that a nanosecond of a pulse stands for: there and back."""
WIDEST = float(to_radians(5.0))
"""Half divergence, radians."""
Wavelength = Annotated[float, msgspec.Meta(ge=100, le=20_000)]
"""Nanometres: from the ultraviolet to the thermal infrared."""


def pick_one(given: dict[str, tuple[float | None, float]]) -> float:
    """The one value that is given, times its factor; raises `WrongUse` for none or several."""
    found = [(value, factor) for value, factor in given.values() if value is not None]
    if len(found) != 1:
        raise WrongUse(
            f"Of the keys {', '.join(given)}, {len(found)} are there.",
            "Give exactly one of them.",
        )
    value, factor = found[0]
    return value * factor


class Beam(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Table ``beam``; one of the four divergences is given."""

    exit_diameter_mm: Annotated[float, msgspec.Meta(ge=0, le=1000)]
    full_divergence_mrad: float | None = None
    half_divergence_mrad: float | None = None
    full_divergence_deg: float | None = None
    half_divergence_deg: float | None = None
    rays: Annotated[int, msgspec.Meta(ge=1, le=5000)] = 37

    def build(self) -> Bundle:
        given = {
            "full_divergence_mrad": (self.full_divergence_mrad, 0.5e-3),
            "half_divergence_mrad": (self.half_divergence_mrad, 1e-3),
            "full_divergence_deg": (self.full_divergence_deg, float(to_radians(0.5))),
            "half_divergence_deg": (self.half_divergence_deg, float(to_radians(1.0))),
        }
        half = pick_one(given)
        if not 0 <= half <= WIDEST:
            raise WrongUse(
                f"A beam cannot diverge by {degrees(half):g}° (half angle).",
                f"Give 0 to {degrees(WIDEST):g}°; mind the unit, and full or half angle.",
            )
        return Bundle(self.exit_diameter_mm / MM_PER_M, half, self.rays)


class PhaseShiftTable(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="phase-shift"
):
    """Table ``ranging``."""

    wavelengths_m: Numbers

    def build(self) -> PhaseShift:
        return PhaseShift(self.wavelengths_m)


class WaveformTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Table ``ranging.waveform``."""

    step_m: float
    samples: int
    noise: float = 0.0

    def build(self) -> Waveform:
        return Waveform(self.step_m, self.samples, self.noise)


class PulsedTable(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="pulsed"
):
    """Table ``ranging``."""

    pulse_ns: float
    blend_m: float
    pick: Pick = "first"
    least: float = 0.05
    most: int = 5
    waveform: WaveformTable | None = None

    def build(self) -> Pulsed:
        waveform = None if self.waveform is None else self.waveform.build()
        pulse = self.pulse_ns * METRES_PER_NS
        return Pulsed(pulse, self.blend_m, self.pick, self.least, self.most, waveform)


class ReceiverTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Table ``receiver``."""

    range_noise_mm: float
    intensity_noise: float
    range_noise_power: float = Receiver().range_noise_power
    threshold: float = 0.01
    correlation: Correlation = "white"
    dropout: float = 0.0
    nearest_m: float = 0.0
    farthest_m: float = inf
    range_noise_at_m: float | None = None

    def build(self) -> Receiver:
        return Receiver(
            self.range_noise_mm / MM_PER_M,
            self.range_noise_power,
            self.intensity_noise,
            self.threshold,
            self.correlation,
            self.dropout,
            self.nearest_m,
            self.farthest_m,
            self.range_noise_at_m,
        )


class InverseSquareTable(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="inverse-square"
):
    """Table ``detector.range_effect``."""

    reference_m: float
    near_m: float = 0.0

    def build(self) -> effects.InverseSquare:
        return effects.InverseSquare(self.reference_m, self.near_m)


class HancockTable(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="hancock"
):
    """Table ``detector.range_effect``."""

    a: Numbers
    k2: Numbers
    k3: Numbers
    reference_m: float = 8.0

    def build(self) -> effects.Hancock:
        return effects.Hancock(self.a, self.k2, self.k3, self.reference_m)


class NoEffectTable(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="none"
):
    """Table ``detector.range_effect``."""

    def build(self) -> effects.NoEffect:
        return effects.NoEffect()


class IdealTable(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="ideal"
):
    """Table ``detector``."""

    def build(self) -> Ideal:
        return Ideal()


class AmplifierTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the tables ``detector`` of all amplifiers share; numbers in DN."""

    dark: float
    saturated: float
    quantum: float = 1.0
    electronic_noise: float = 0.0
    range_effect: NoEffectTable | InverseSquareTable | HancockTable = NoEffectTable()

    def scale(self) -> Digitiser:
        return Digitiser(self.dark, self.saturated, self.quantum, self.electronic_noise)


class LinearTable(AmplifierTable, frozen=True, tag_field="kind", tag="linear", kw_only=True):
    """Table ``detector``."""

    a: Numbers
    b: Numbers

    def build(self) -> Linear:
        return Linear(self.a, self.b, self.scale(), self.range_effect.build())


class LogarithmicTable(
    AmplifierTable, frozen=True, tag_field="kind", tag="logarithmic", kw_only=True
):
    """Table ``detector``."""

    a0: Numbers
    a1: Numbers

    def build(self) -> Logarithmic:
        return Logarithmic(self.a0, self.a1, self.scale(), self.range_effect.build())


class SalcaTable(AmplifierTable, frozen=True, tag_field="kind", tag="salca", kw_only=True):
    """Table ``detector``."""

    m: Numbers
    c: Numbers
    k: Numbers

    def build(self) -> Salca:
        return Salca(self.m, self.c, self.k, self.scale(), self.range_effect.build())


class InstrumentTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The whole file."""

    name: str
    title: str
    wavelengths_nm: tuple[Wavelength, ...]
    beam: Beam
    ranging: PhaseShiftTable | PulsedTable
    receiver: ReceiverTable
    detector: IdealTable | LinearTable | LogarithmicTable | SalcaTable
    step_deg: float | None = None
    step_mrad: float | None = None
    ranging_channel: int = 0
    notes: tuple[str, ...] = ()

    def step(self) -> float:
        """Degrees."""
        given = {"step_deg": (self.step_deg, 1.0), "step_mrad": (self.step_mrad, degrees(1e-3))}
        return pick_one(given)
