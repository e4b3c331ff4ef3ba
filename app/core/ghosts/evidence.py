"""What the beams around a point say about it, for the first glance."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.footprint import BeamShape
from app.core.ghosts.image import GhostImage
from app.core.ghosts.network import Network

LEAST_JUMP, JUMP_IN_SIGMAS = 0.004, 5.0
STEEPEST = 4.0
"""Tangent of the steepest surface within which a point needs no look."""

_CLASSES = ("0", *(f"{0.5 * 2**k:g} mm" for k in range(9)))
NAMES = (
    *(
        f"{ring}, {side} from {start}"
        for ring in ("8 around", "40 beyond")
        for side in ("farther", "nearer")
        for start in _CLASSES
    ),
    "8 around, missing",
    "40 beyond, missing",
    *(f"bend through {k}" for k in (1, 2, 3, 4, 6, 8, 11)),
    *(f"bend away {k}" for k in (1, 2, 3, 5, 7)),
    "beam diameter over step",
    "step",
    "noise",
)


def find_doubtful(image: GhostImage, points: Ints, first: int, last: int) -> Ints:
    """Places, in the list of points, of those of `first` to `last` that something is off from."""
    from app.core.kernels import ghost_evidence as kernels

    cells, steps = image.cells, image.steps
    jump = max(LEAST_JUMP, JUMP_IN_SIGMAS * steps.noise)
    places = np.empty(last - first, np.int64)
    count = kernels.pick_doubtful(
        points, first, last, image.own, cells.row, cells.column, image.ranges,
        steps.down, steps.across, jump, STEEPEST, places,
    )  # fmt: skip
    return places[:count]


def gather(image: GhostImage, points: Ints, places: Ints, beam: BeamShape) -> AnyArray:
    """Evidence on the points at these places, (places, NAMES) float32."""
    from app.core.kernels import ghost_evidence as kernels

    evidence = np.empty((len(places), len(NAMES)), np.float32)
    kernels.gather_evidence(places, points, *_describe(image, beam), evidence)
    return evidence


def glance(
    image: GhostImage, points: Ints, places: Ints, beam: BeamShape, network: Network
) -> Floats:
    """What the network says of the points at these places, (places,)."""
    from app.core.kernels import ghost_evidence as kernels

    score = np.empty(len(places))
    kernels.glance_at(places, points, *_describe(image, beam), *network.layers, score)
    return score


def _describe(image: GhostImage, beam: BeamShape) -> tuple[object, ...]:
    """What both kernels are told of the scan."""
    cells, steps = image.cells, image.steps
    spread = float(np.tan(beam.half_divergence))
    return (
        image.own, cells.row, cells.column, image.ranges, steps.down, steps.across,
        beam.radius, spread, steps.noise,
    )  # fmt: skip
