"""From a scene file to surfaces in space and the beams that scan them."""

from __future__ import annotations

import zlib
from collections import Counter

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.core.units import group_digits, to_degrees
from app.model.scan import Vector
from app.simulate.beam import BeamGrid, angles_of, grid_of_field
from app.simulate.bounds import enclose
from app.simulate.parts import AnyPart, Pieces, Surroundings, assemble
from app.simulate.parts.wall import BACKGROUND
from app.simulate.scene_file import SceneFile
from app.simulate.surfaces import Scene, Stem
from app.simulate.wind import apply_wind

MOST_BEAMS = 200_000_000

Interval = tuple[float, float]


def build_scene(scene_file: SceneFile, wavelengths_nm: tuple[float, ...]) -> Scene:
    """The surfaces of a scene; the same file gives the same scene.

    Each part draws from a generator of its own, made of the seed, its kind and its place among
    those of its kind: a part more or less, of another kind or behind it, does not change it.

    Raises
    ------
    BadInput
        A part cannot be built as it is told, or the scanner is inside one of its stems, or a
        material is unknown, or not at these wavelengths; names the part.
    """
    seen: Counter[str] = Counter()
    pieces = []
    for index, part in enumerate(scene_file.part):
        kind = str(part.__struct_config__.tag)
        surroundings = Surroundings(
            _make_generator(scene_file.seed, f"{kind} {seen[kind]}"),
            scene_file.position,
            tuple(wavelengths_nm),
            scene_file.hours,
        )
        seen[kind] += 1
        pieces.append(_build(part, f"{scene_file.name}: part.{index} ({kind})", surroundings))
    scene = assemble(tuple(pieces), scene_file.name, tuple(wavelengths_nm))
    if scene_file.wind is None:
        return scene
    return apply_wind(scene, scene_file.wind, _make_generator(scene_file.seed, "wind"))


def lay_grid(scene_file: SceneFile, scene: Scene, step_deg: float) -> BeamGrid:
    """The beams of a scan of `scene`, which was built of `scene_file`.

    Raises
    ------
    BadInput
        More than 200 million beams.
    WrongUse
        The step does not fit the field.
    """
    if scene_file.field == "fit":
        azimuth, elevation = fit_field(scene, scene_file.position, scene_file.margin_deg)
    else:
        azimuth, elevation = scene_file.field.azimuth_deg, scene_file.field.elevation_deg
    if step_deg > 0:
        beams = (azimuth[1] - azimuth[0]) * (elevation[1] - elevation[0]) / step_deg**2
        if beams > MOST_BEAMS:
            raise BadInput(
                f"{scene_file.name}: a step of {step_deg:g}° makes {beams:.2g} beams; "
                f"{group_digits(MOST_BEAMS)} are the most.",
                "Take a larger step or a smaller field.",
            )
    return grid_of_field(step_deg, azimuth, elevation)


def fit_field(
    scene: Scene, scanner: tuple[float, float, float], margin_deg: float
) -> tuple[Interval, Interval]:
    """Azimuths and elevations, degrees, around all surfaces but walls and ground.

    Raises
    ------
    BadInput
        There is nothing but walls.
    """
    background = np.array([w.name in BACKGROUND for w in scene.walls], bool)
    rest = len(scene.leaves) + len(scene.stems)
    kept = np.concatenate([np.ones(rest, bool), ~background])
    low, high = (corner[kept] for corner in enclose(scene))
    if not len(low):
        raise BadInput(
            f"{scene.name} has nothing but walls, to which no field can be fitted.",
            "Give `field` with azimuth_deg and elevation_deg.",
        )
    place = np.array(scanner)
    across = _widen(to_degrees(_turn(low, high, place)), margin_deg, np.inf)
    above = ((low[:, :2] <= scanner[:2]) & (high[:, :2] >= scanner[:2])).all(axis=1)
    if above.any() or across[1] - across[0] > 360:
        across = (-180.0, 180.0)
    return across, _widen(to_degrees(_rise(low, high, place)), margin_deg, 90.0)


def _build(part: AnyPart, where: str, surroundings: Surroundings) -> Pieces:
    try:
        pieces = part.build(surroundings)
        _check_outside(pieces.stems, surroundings.scanner)
    except LeafscopeError as error:
        raise BadInput(f"{where}: {error.what}", error.hint) from error
    return pieces


def _check_outside(stems: tuple[Stem, ...], scanner: Vector) -> None:
    """Refuse a scanner inside a stem, which would see through the wood."""
    ends = np.array([(stem.start, stem.end) for stem in stems], float).reshape(-1, 2, 3)
    axis, away = ends[:, 1] - ends[:, 0], np.array(scanner) - ends[:, 0]
    place = np.clip((away * axis).sum(axis=1) / (axis * axis).sum(axis=1), 0.0, 1.0)
    distance = np.linalg.norm(away - place[:, None] * axis, axis=1)
    if (distance <= [stem.radius for stem in stems]).any():
        raise WrongUse(f"The scanner, at {scanner}, is inside a stem.", "Move one of them.")


def _make_generator(seed: int, key: str) -> np.random.Generator:
    number = zlib.crc32(key.encode())
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))


def _turn(low: Floats, high: Floats, scanner: Floats) -> Floats:
    """Azimuths of the upright edges of boxes, (2, 2, n) radians.

    No box is torn apart where azimuth jumps by a circle.
    """
    _, middle = angles_of((low + high) / 2, scanner)
    home = np.arctan2(np.sin(middle).mean(), np.cos(middle).mean())
    x, y = (np.stack([low[:, k], high[:, k]]) - scanner[k] for k in (0, 1))
    edges = np.arctan2(y, x[:, None])
    turned: Floats = home + _wrap(middle - home) + _wrap(edges - middle)
    return turned


def _rise(low: Floats, high: Floats, scanner: Floats) -> Floats:
    """Lowest and highest elevation of boxes, (2, n) radians.

    A box above the scanner is highest where it is nearest, on an edge or a face as may be.
    """
    under, over = low - scanner, high - scanner
    near = np.hypot(*np.maximum(np.maximum(under, -over), 0.0)[:, :2].T)
    far = np.hypot(*np.maximum(np.abs(under), np.abs(over))[:, :2].T)
    lowest = np.arctan2(under[:, 2], np.where(under[:, 2] < 0, near, far))
    return np.stack([lowest, np.arctan2(over[:, 2], np.where(over[:, 2] > 0, near, far))])


def _wrap(angle: Floats) -> Floats:
    """Angles within half a circle of 0, radians."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _widen(angles: Floats, margin: float, most: float) -> Interval:
    return max(float(angles.min()) - margin, -most), min(float(angles.max()) + margin, most)
