"""Teach the networks of ghost points on simulated scans, and write them as files.

``python -m app.services.bench.ghosts.learning FOLDER`` makes the files of `resources/ghosts`
anew, in about a quarter of an hour.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.footprint import BeamShape
from app.core.ghosts import THRESHOLD, context, lay_out
from app.core.ghosts.correction import CLEAN
from app.core.ghosts.evidence import NAMES, find_doubtful, gather
from app.core.ghosts.image import GhostImage
from app.core.ghosts.network import Name, Network, Stored, build_network
from app.core.ghosts.score import MIXED, score_by_networks, see_all
from app.formats.atomic import atomic_path
from app.model.ghost_fields import light_of
from app.model.state import ScanState
from app.services.bench.ghosts.lessons import Lesson, list_lessons
from app.services.bench.ghosts.training import teach
from app.services.bench.ghosts.truth import GHOST, GOOD, Scene

ROWS = {"glance": 40_000, "judgement": 25_000, "confidence": 20_000}
"""Of each scan at most."""
DARK = 0.25
"""Share of the scans whose light the networks do not see: they must do without."""
SEEN = (0.005, 0.998)
"""A wider span than that of `UNDECIDED`: the borders of a lesson are learned badly."""


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """A scan laid out, with its truth."""

    scene: Scene
    image: GhostImage
    light: Floats | None

    @property
    def beam(self) -> BeamShape:
        return BeamShape(self.scene.beam.radius, self.scene.beam.half_divergence)


def learn(lessons: Sequence[Lesson], folder: Path, seed: int = 0) -> Iterator[str]:
    """Teach the three networks one after the other, and say what was done."""
    random = np.random.default_rng(seed)
    scans = [_look(lesson, random) for lesson in lessons]
    yield f"{len(scans)} scans of {sum(len(seen.scene) for seen in scans):,} points"
    rows = [_ask_glance(seen, random) for seen in scans]
    glance = _teach("glance", "Ghost or not, by the beams around.", NAMES, rows, (48, 24), 12)
    yield _write(glance, folder, "glance")
    first = build_network(glance)
    rows = [_ask_judgement(seen, first, random) for seen in scans]
    judgement = _teach(
        "judgement", "Ghost or not, by the surfaces around.", context.NAMES, rows, (48, 24), 20
    )
    yield _write(judgement, folder, "judgement")
    second = build_network(judgement)
    rows = [_ask_confidence(seen, first, second, random) for seen in scans]
    confidence = _teach(
        "confidence",
        "Right when put back on the nearest surface.",
        context.NAMES,
        rows,
        (24, 12),
        16,
    )
    yield _write(confidence, folder, "confidence")


def _look(lesson: Lesson, random: np.random.Generator) -> _Seen:
    scene = lesson.scan()
    image = lay_out(scene.xyz, scene.scanner, scene.grid)
    light = None if random.random() < DARK else light_of(ScanState.fresh(scene.scan))
    return _Seen(scene, image, light)


def _teach(
    name: Name, about: str, names: tuple[str, ...], rows: Sequence[tuple[AnyArray, Bools]],
    hidden: tuple[int, ...], rounds: int,
) -> Stored:  # fmt: skip
    evidence = np.concatenate([row[0] for row in rows])
    truth = np.concatenate([row[1] for row in rows])
    batch = 4096 if name == "glance" else 2048
    return teach(about, names, evidence, truth, hidden, rounds, batch)


def _write(network: Stored, folder: Path, name: Name) -> str:
    path = folder / f"{name}.json"
    with atomic_path(path, overwrite=True) as temporary:
        temporary.write_bytes(msgspec.json.encode(network))
    return f"{path} written"


def _draw(points: Ints, most: int, random: np.random.Generator) -> Ints:
    return np.sort(random.permutation(points)[:most])


def _certain(scene: Scene, points: Ints) -> Ints:
    """Those points that are ghosts or none by the truth, not in between."""
    off = scene.off[points]
    return points[(off > GHOST) | (off <= GOOD)]


def _ask_glance(seen: _Seen, random: np.random.Generator) -> tuple[AnyArray, Bools]:
    everyone = np.arange(len(seen.scene))
    doubtful = find_doubtful(seen.image, everyone, 0, len(everyone))
    some = _draw(_certain(seen.scene, doubtful), ROWS["glance"], random)
    return gather(seen.image, everyone, some, seen.beam), seen.scene.off[some] > GHOST


def _ask_judgement(
    seen: _Seen, glance: Network, random: np.random.Generator
) -> tuple[AnyArray, Bools]:
    told, _ = see_all(seen.image, np.arange(len(seen.scene)), seen.beam, glance)
    undecided = np.flatnonzero((told > SEEN[0]) & (told < SEEN[1]))
    some = _draw(_certain(seen.scene, undecided), ROWS["judgement"], random)
    around = context.Surroundings(seen.image, told > MIXED, told, seen.beam, seen.light)
    rows, _ = around.describe(some)
    return rows, seen.scene.off[some] > GHOST


def _ask_confidence(
    seen: _Seen, glance: Network, judgement: Network, random: np.random.Generator
) -> tuple[AnyArray, Bools]:
    scene, image = seen.scene, seen.image
    everyone = np.arange(len(scene))
    score, _ = score_by_networks(image, everyone, seen.beam, seen.light, glance, judgement)
    some = _draw(np.flatnonzero(score >= THRESHOLD), ROWS["confidence"], random)
    glanced = np.where(np.isnan(score), 1.0, score)
    around = context.Surroundings(image, ~(score <= CLEAN), glanced, seen.beam, seen.light)
    rows, ranges = around.describe(some)
    after = np.abs(ranges - scene.main[some])
    before = np.abs(scene.own[some] - scene.main[some])
    with np.errstate(invalid="ignore"):
        return rows, (after <= 2.0 * scene.sigma[some]) & (after <= before)


if __name__ == "__main__":
    for line in learn(list(list_lessons()), Path(sys.argv[1])):
        print(line, flush=True)
