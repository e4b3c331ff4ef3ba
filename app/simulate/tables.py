"""A scene and an instrument as the arrays that the tracer reads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.phase import get_model
from app.simulate.detector import tabulate_strength
from app.simulate.instrument import Instrument
from app.simulate.material import Sheen
from app.simulate.range_effect import LATTICE
from app.simulate.ranging import PhaseShift, count_octaves
from app.simulate.surfaces import Leaf, Scene, Stem, Wall, stack_frames

if TYPE_CHECKING:
    from app.core.kernels.echoes import BeamTable, OpticsTable
    from app.core.kernels.leaves import LeafTable
    from app.core.kernels.surfaces import StemTable, SurfaceTable, WallTable

SAMPLES = 2049
"""Values of a phase function over √(1 − cos ω): linear between them, to some 1e-6."""


def tabulate_surfaces(scene: Scene) -> SurfaceTable:
    """All surfaces of a scene as arrays."""
    from app.core.kernels.surfaces import SurfaceTable

    return SurfaceTable(
        _tabulate_leaves(scene.leaves), _tabulate_stems(scene.stems), _tabulate_walls(scene.walls)
    )


def tabulate_optics(scene: Scene) -> OpticsTable:
    """Reflectance at ω = 0 and phase function of every surface and channel.

    Raises
    ------
    WrongUse
        A material has another number of channels than the scene, or a phase function is not
        positive at ω = 0.
    """
    from app.core.kernels.echoes import OpticsTable

    channels = len(scene.wavelengths_nm)
    rows: dict[tuple[str, tuple[tuple[str, float], ...]], int] = {}
    rho, curve = [], []
    for material in scene.materials():
        if len(material) != channels:
            raise WrongUse(f"A material has {len(material)} channels, the scene {channels}.")
        rho.append([sheen.rho for sheen in material])
        curve.append([rows.setdefault((s.model, s.parameters), len(rows)) for s in material])
    curves = [sample_phase(Sheen(1.0, *key)) for key in rows]
    return OpticsTable(
        np.array(rho, float).reshape(-1, channels),
        np.array(curve, np.int64).reshape(-1, channels),
        np.array(curves, float).reshape(-1, SAMPLES),
    )


def sample_phase(sheen: Sheen) -> Floats:
    """Phase function of a sheen over √(1 − cos ω), (SAMPLES,), 1 at ω = 0, never negative.

    In √(1 − cos ω) every model is smooth, which in cos ω it is not at 0°.
    """
    model = get_model(sheen.model)
    omega = 2 * np.arcsin(np.linspace(0.0, 1.0, SAMPLES) / np.sqrt(2.0))
    scales = [p.name for p in model.parameters if p.scales]
    given = {**(dict.fromkeys(scales, 1.0) if len(scales) == 1 else {}), **dict(sheen.parameters)}
    missing = [p.name for p in model.parameters if p.name not in given]
    if missing:
        raise WrongUse(f"The phase function {model.name} needs {', '.join(missing)}.")
    values = np.asarray(model.evaluate(np.minimum(omega, np.pi / 2), given), float)
    if not values[0] > 0:
        raise WrongUse(
            f"The phase function {model.name} is {values[0]:.3g} at ω = 0.",
            "A reflectance is stated there, so the function must be positive.",
        )
    return np.asarray(np.maximum(values / values[0], 0.0), float)


def tabulate_beam(instrument: Instrument) -> BeamTable:
    """Bundle and ranging of an instrument."""
    from app.core.kernels import echoes

    bundle, ranging = instrument.bundle, instrument.ranging
    channels, reach = len(instrument.wavelengths_nm), instrument.receiver.farthest
    strength = tabulate_strength(instrument.detector, channels, reach)
    shape = (
        np.ascontiguousarray(bundle.subrays().T),
        bundle.exit_diameter / 2,
        float(np.tan(bundle.half_divergence)),
        instrument.ranging_channel,
    )
    if isinstance(ranging, PhaseShift):
        waves = np.array(ranging.wavelengths, float)
        octaves = count_octaves(ranging.wavelengths)
        return echoes.BeamTable(
            *shape, waves, octaves, 0.0, 0.0, 0.0, 1, 0, 0.0, 0.0, 0.0, strength, LATTICE
        )
    pick = {
        "first": echoes.FIRST,
        "strongest": echoes.STRONGEST,
        "last": echoes.LAST,
        "all": echoes.ALL,
    }[ranging.pick]
    wave = ranging.waveform
    digitiser = (0.0, 0.0) if wave is None else (wave.step, wave.noise)
    return echoes.BeamTable(
        *shape,
        np.empty(0),
        np.empty(0, np.int64),
        ranging.blend,
        ranging.least,
        instrument.receiver.threshold,
        ranging.most if ranging.pick == "all" else 1,
        pick,
        ranging.pulse,
        *digitiser,
        strength,
        LATTICE,
    )


def _tabulate_leaves(leaves: tuple[Leaf, ...]) -> LeafTable:
    from app.core.kernels.leaves import LeafTable

    waves = [
        (s.wrinkle_height, *(2 * np.pi / np.array(s.wrinkle_lengths)), *s.wrinkle_phases)
        for s in leaves
    ]
    bends = [(s.curvature, np.cos(s.bend_direction), np.sin(s.bend_direction)) for s in leaves]
    outlines = [(s.length / 2, s.width / 2, s.taper, s.lobes, s.lobe_depth) for s in leaves]
    return LeafTable(
        _stack([s.centre for s in leaves], 3),
        stack_frames(leaves),
        _stack(outlines, 5),
        _stack(bends, 3),
        _stack(waves, 5),
        _stack([s.slab() for s in leaves], 2),
        _stack([(s.reach(), s.steepest()) for s in leaves], 2),
        _stack([(*s.sway, s.sway_rate, s.sway_phase) for s in leaves], 5),
    )


def _tabulate_stems(stems: tuple[Stem, ...]) -> StemTable:
    from app.core.kernels.surfaces import StemTable

    return StemTable(
        _stack([s.start for s in stems], 3),
        _stack([s.end for s in stems], 3),
        np.array([s.radius for s in stems], float),
    )


def _tabulate_walls(walls: tuple[Wall, ...]) -> WallTable:
    from app.core.kernels.surfaces import WallTable

    edges = [np.array((w.across, w.up), float) for w in walls]
    half = _stack([np.linalg.norm(pair, axis=1) for pair in edges], 2)
    frames = [np.vstack([*pair, np.cross(*pair)]) for pair in edges]
    frames = [frame / np.linalg.norm(frame, axis=1)[:, None] for frame in frames]
    return WallTable(
        _stack([w.centre for w in walls], 3), np.array(frames, float).reshape(-1, 3, 3), half
    )


def _stack(rows: Any, width: int) -> Floats:
    """Rows as an array that keeps its width even when there are none."""
    return np.array(rows, float).reshape(-1, width)
