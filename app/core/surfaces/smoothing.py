"""Ranges of a leaf smoothed within their noise.

What is smoothed is one over the depth: of a plane it is exactly linear in the beams' directions.
First comes a second degree over the whole leaf, then what it leaves, by local second degrees as
wide as leaving out one cell at a time finds best: a flat leaf keeps no noise and a wrinkled one
its wrinkles. Beams on the rim lie on the leaf in part and flatten it; they hardly count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.robust_plane import MEDIAN_TO_SIGMA
from app.core.surfaces.crop import Crop
from app.core.surfaces.outline import USUAL, Outline

WIDTHS = (1.3, 2.0, 3.0, 4.5, 7.0)
"""σ of the local weights, cells."""
TRIED = 400
"""Cells at most by which widths are compared."""
BETTER = 0.95
"""Share of the squares that a local fit must leave at most to be preferred to none."""
RIM = 0.05
"""Weight of cells that a beam's radius reaches over the border from."""
FEWEST = 12
CUT = 4.0
"""σ from the surface beyond which a range has no weight."""
PASSES = 6
SHARED, BLOCK = 1.5, 2
"""Neighbours share their noise (a filter in the scanner) where leaving out so many cells around
finds a mean square so much larger than leaving out one; then that is what widths go by."""
FILTER = 9.0
"""Cells that share noise then: a filter of 3 × 3 (Balduzzi 2011)."""


@dataclass(frozen=True, slots=True, eq=False)
class Smooth:
    """A leaf's surface.

    Attributes
    ----------
    inverse : (h, w) 1 / metres
        One over the depth at the leaf's cells; NaN elsewhere.
    rest : (h, w, 3)
        What the local fit adds to the whole one, and its change per row and per column.
    whole : (6,)
        Terms of the second degree over the leaf.
    width : float
        Cells; infinite where nothing local was kept.
    sigma : float
        Metres: noise of a range.
    rough : float
        Variance that noise leaves in the slope of one over the depth, per squared tangent.
    core : int
        Cells whose whole beam lies on the leaf.
    """

    inverse: Floats
    rest: Floats
    whole: Floats
    width: float
    sigma: float
    rough: float
    core: int


def smooth_leaf(crop: Crop, outline: Outline) -> Smooth:
    """Smooth the ranges of a leaf's cells."""
    member = crop.members
    reach = outline.radius if outline.radius > 0.0 else 0.5 * max(crop.pitch)
    if not outline.told:  # too small a radius would let mixed ranges into the surface
        reach = max(reach, USUAL)
    core = member & (outline.inside > reach)
    if core.sum() < FEWEST:
        core = member
    terms = list_terms(crop)
    weight = np.where(core, 1.0, RIM * member)
    whole, weight = _fit_whole(terms, crop.inverse, weight, member)
    left = np.where(member, crop.inverse - terms @ whole, 0.0)
    good = core & (weight > 0.5)
    freedom = max(int(good.sum()) - len(whole), 1)
    plain = _mean_square(left[good]) * int(good.sum()) / freedom
    width, square, shared = _choose_width(left, weight, good, crop)
    rest = np.zeros((*member.shape, 3))
    rough, variance = 0.0, plain
    if square < BETTER * plain:
        variance = square
        rest, rough = _smooth(left, weight, member, core, width, crop)
        rough *= variance * (FILTER if shared else 1.0)
    else:
        width = np.inf
    inverse = np.where(member, terms @ whole + rest[..., 0], np.nan)
    sigma = float(np.sqrt(variance) * crop.distance**2)
    return Smooth(inverse, rest, whole, width, sigma, rough, int(core.sum()))


def list_terms(crop: Crop) -> Floats:
    """Second degree of the tangents, (h, w, 6), of the size of 1 over the leaf."""
    member = crop.members
    size = float(np.hypot(crop.side[member], crop.up[member]).max()) or 1.0
    a, b = crop.side / size, crop.up / size
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=-1)


def _fit_whole(
    terms: Floats, inverse: Floats, weight: Floats, member: Bools
) -> tuple[Floats, Floats]:
    """The second degree over the leaf, and weights without what lies far off it."""
    rows, wanted, heavy = terms[member], inverse[member], weight[member]
    kept = np.ones(len(wanted))
    for _ in range(PASSES):
        weighed = (rows * (heavy * kept)[:, None]).T
        found = np.linalg.lstsq(weighed @ rows, weighed @ wanted, rcond=1e-12)[0]
        off = np.abs(wanted - rows @ found)
        scale = MEDIAN_TO_SIGMA * float(np.median(off[heavy * kept > 0.0])) if kept.any() else 0.0
        chosen = (off <= CUT * scale + 1e-12).astype(np.float64)
        if (chosen == kept).all() or (heavy * chosen).sum() < FEWEST:
            break
        kept = chosen
    # Wrinkles may lie far off the second degree; only rims and strays lose their weight there.
    strong = weight.copy()
    strong[member] = np.where(off <= 3.0 * CUT * scale + 1e-12, heavy, 0.0)
    return np.asarray(found, np.float64), strong


def _choose_width(
    left: Floats, weight: Floats, good: Bools, crop: Crop
) -> tuple[float, float, bool]:
    """Best width, the mean square found for it by cells left out, and whether noise is shared."""
    asked = np.argwhere(good)
    asked = asked[:: max(1, -(-len(asked) // TRIED))]
    wanted = left[asked[:, 0], asked[:, 1]]

    def compare(hole: int, widths: tuple[float, ...]) -> Floats:
        found = [_run(left, weight, asked, width, crop, hole)[:, 0] for width in widths]
        return np.array([_mean_square(wanted - values) for values in found])

    squares = compare(0, WIDTHS)
    best = int(squares.argmin())
    shared = bool(compare(BLOCK, WIDTHS[best : best + 1])[0] > SHARED * squares[best])
    if shared:
        squares = compare(BLOCK, WIDTHS)
        best = int(squares.argmin())
    return WIDTHS[best], float(squares[best]), shared


def _mean_square(off: Floats) -> float:
    """Mean of squares, the largest 2 % of them cut: a few strays must not choose a width."""
    square = off**2
    return float(np.mean(np.minimum(square, np.quantile(square, 0.98))))


def _smooth(
    left: Floats, weight: Floats, member: Bools, core: Bools, width: float, crop: Crop
) -> tuple[Floats, float]:
    from scipy.ndimage import distance_transform_edt

    found = _run(left, weight, np.argwhere(core), width, crop, -1)
    rest = np.zeros((*member.shape, 3))
    rest[core] = found[:, :3]
    # On the rim a polynomial from inside would swing: it goes on level, beside the whole fit.
    nearest = distance_transform_edt(~core, return_distances=False, return_indices=True)
    outside = ~core
    rest[outside, 0] = rest[nearest[0], nearest[1], 0][outside]
    tall, wide = (p / crop.distance for p in crop.pitch)
    rough = np.median(found[:, 3] / tall**2 + found[:, 4] / wide**2)
    return rest, float(rough)


def _run(
    left: Floats, weight: Floats, asked: AnyArray, width: float, crop: Crop, hole: int
) -> Floats:
    """Local fits at the asked cells, those up to `hole` around them left out; -1: none."""
    from app.core.kernels.leaf_smoothing import smooth_cells, sum_rows

    mean = float(np.sqrt(crop.pitch[0] * crop.pitch[1]))
    widths = np.maximum(width * mean / np.array(crop.pitch), 0.7)
    lines = np.empty((13, *left.shape))
    sum_rows(left, weight, widths[1], lines)
    found = np.empty((len(asked), 5))
    smooth_cells(left, weight, np.ascontiguousarray(asked), widths, hole, lines, found)
    return found
