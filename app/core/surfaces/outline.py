"""Where a leaf ends, between the beams that belong to it and those that do not.

A beam whose middle lies on the very border sends half of its light to the leaf. So

- where points between the leaf and another surface were taken out, they lie on both sides of the
  border; the stronger surface draws the range to itself, so that they reach farther over the
  weaker one. How far they reach together is seen, and the strengths tell where the border is;
- where a leaf meets the sky, beams that touch it with a small part still return its range: the
  leaf is stretched, and its border lies about a beam's radius inside of its last points;
- before a far surface without points between them (a pulsed scanner that reports the first
  return) it is the same, and a surface behind another is cut by as much.

All this is seen from the scanner, where a beam's section is round at any incidence.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.surfaces.crop import EMPTY, FARTHER, GHOST, MEMBER, NEARER, OUTSIDE, Crop
from app.core.surfaces.light import Echoes, carry_echoes, shift_by_light

STRETCH = 0.7
"""Beam radii (1/e²) beyond the border at which a leaf still returns its range."""
FIRST = 0.5
"""The same before a far surface: the first return needs a share of all light."""
BARE = 1.6
"""Cells between two surfaces up to which nothing was taken out between them."""
FAR = 0.03
"""Metres behind one another from which a beam on both gives no range of either."""
HOLE = 1.5
"""Beam diameters: a gap without returns that is no wider is no gap in the leaf."""
LEAST_HOLE = 2.0
"""Cells that a gap may be wide in any case: lost returns."""
WIDEST, REACH = 7.0, 2.5
"""Cells, or beam radii, from the leaf up to which a point between surfaces may lie on its border:
a beam on both lies a radius beside the border at most, and so does one on the leaf alone."""
ENOUGH = 8
"""Cells of a border by which a beam's width is told."""
USUAL = 0.0025
"""Metres: a beam's radius where none is known; it says how far to look for mixed light."""
NODES = 80
AROUND = 7
"""Cells over which shifts of the border are averaged."""
FILLED = 0.95
"""Beam radii on either side of a border within which points lie between surfaces."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Signed distance of cells to a leaf's border, and what it is made of.

    Attributes
    ----------
    inside : (h, w) metres
        Across the beam, positive on the leaf.
    beyond : (h, w) int8
        What lies beyond the border nearest to a cell: a state of `crop`.
    radius : float
        Metres: 1/e² radius of the beam there; NaN where it is unknown.
    told : bool
        The radius was given, not estimated.
    hidden : float
        Share of the border in front of which something nearer lies, or the scan ends.
    shifted : float
        Metres: mean of how far the border was moved for stretched or cut beams.
    filled : int
        Cells without a point of the leaf that lie inside it.
    lit : float
        Share of the border whose place the light told.
    apart : float
        Metres: by how much light and ranges differ about the border's place in the mean.
    """

    inside: Floats
    beyond: AnyArray
    radius: float
    told: bool
    hidden: float
    shifted: float
    filled: int
    lit: float
    apart: float


def find_outline(crop: Crop, radius: float | None = None, told: bool = True) -> Outline:
    """Find the border of a leaf; `radius` is that of the beam at the leaf, metres.

    `told` says that it is known, not estimated.
    """
    from scipy.ndimage import distance_transform_edt

    member = crop.members
    away = distance_transform_edt(~member, sampling=crop.pitch)
    state = _settle(crop, away, radius)
    off = (state != MEMBER) & (state != GHOST)
    depth, nearest = distance_transform_edt(~off, sampling=crop.pitch, return_indices=True)
    beyond = state[nearest[0], nearest[1]]
    gap = away[nearest[0], nearest[1]]
    inside = np.where(off, -0.5 * away, depth - 0.5 * gap)
    rim = _find_rim(member)
    jump = np.abs(crop.ranges[nearest[0], nearest[1]] - crop.ranges)
    known = np.nan if radius is None else radius
    if radius is None:
        known = estimate_radius(gap[rim], beyond[rim], jump[rim], float(np.mean(crop.pitch)))
    shift, first = np.zeros(member.shape), False
    reach = known if known > 0.0 else USUAL
    echoes: Echoes = (None, None)
    if crop.light is not None:
        echoes = carry_echoes(crop.light, state, inside, reach)
    if known > 0.0:
        ratio = _compare_strengths(crop, nearest, rim, echoes)
        shift[rim] = _find_shifts(beyond[rim], gap[rim], jump[rim], ratio, known, crop.pitch)
        first = _is_first_return(beyond[rim], gap[rim], jump[rim], known, crop.pitch)
        shift = _average(shift, rim)
    lit, apart = 0.0, 0.0
    if crop.light is not None:
        cell = crop.pitch[0] * crop.pitch[1]
        length = border_length(inside, float(np.sqrt(cell))) / max(int(rim.sum()), 1)
        by_light = shift_by_light(
            crop.light, echoes, state, inside, rim, reach, cell, length, first
        )
        seen = np.isfinite(by_light)
        # Each errs by itself: one by what it takes for the scanner's way, one by its neighbours.
        by_range = shift[rim]
        apart = float(np.abs(np.mean((by_light - by_range)[seen]))) if seen.any() else 0.0
        shift[rim] = np.where(seen, 0.5 * (by_light + by_range), by_range)
        lit = float(seen.mean())
    toward = distance_transform_edt(~rim, return_distances=False, return_indices=True)
    inside = inside - shift[toward[0], toward[1]]
    hidden = np.isin(beyond[rim], (NEARER, OUTSIDE)).mean()
    moved = float(np.abs(shift[rim]).mean())
    filled = int(((inside > 0.0) & ~member).sum())
    given = told and radius is not None
    return Outline(inside, beyond, known, given, float(hidden), moved, filled, lit, apart)


def border_length(inside: Floats, pitch: float) -> float:
    """Length of the border across the beam, metres (Crofton: crossings of rows and columns)."""
    on = inside > 0.0
    crossings = (on[1:] != on[:-1]).sum() + (on[:, 1:] != on[:, :-1]).sum()
    return float(crossings) * pitch * np.pi / 4.0


def _settle(crop: Crop, away: Floats, radius: float | None) -> AnyArray:
    """States with small gaps taken for lost returns, and far ghosts for something else."""
    from scipy.ndimage import label

    state = crop.state.copy()
    widest = max(WIDEST * max(crop.pitch), REACH * (radius or 0.0))
    state[(state == GHOST) & (away > widest)] = FARTHER
    gaps, count = label(state == EMPTY)
    if count:
        tall, wide = crop.pitch
        size = np.bincount(gaps.ravel(), minlength=count + 1) * tall * wide
        width = max(LEAST_HOLE * max(crop.pitch), HOLE * 2.0 * (radius or 0.0))
        lost = size <= 0.25 * np.pi * width**2
        lost[0] = False
        # A gap at the end of the crop may go on beyond it.
        for edge in (gaps[0], gaps[-1], gaps[:, 0], gaps[:, -1]):
            lost[edge] = False
        state[lost[gaps]] = GHOST
    return state


def _find_rim(member: Bools) -> Bools:
    """Cells of the leaf beside one that is not."""
    from scipy.ndimage import binary_erosion

    rim: Bools = member & ~binary_erosion(member)
    return rim


def estimate_radius(gap: Floats, beyond: AnyArray, jump: Floats, pitch: float) -> float:
    """Radius of the beam from how wide points between surfaces lie; NaN where none do."""
    chosen = (beyond == FARTHER) & (jump > FAR)
    if chosen.sum() < ENOUGH:
        return float("nan")
    width = float(np.median(gap[chosen])) - pitch
    return width / (2.0 * FILLED) if width > 0.5 * pitch else float("nan")


def _compare_strengths(crop: Crop, nearest: AnyArray, rim: Bools, echoes: Echoes) -> Floats:
    """Echo of a full hit beyond the border over one of the leaf, at each rim cell.

    By the light where it is known, else as if both were equally bright.
    """
    there = nearest[:, rim]
    behind = crop.ranges[there[0], there[1]]
    ratio = (crop.ranges[rim] / behind) ** 2
    own, other = echoes
    if own is not None and other is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            seen = other[rim] / own[rim]
        ratio = np.where(np.isfinite(seen) & (seen > 0.0), seen, ratio)
    return np.asarray(np.where(np.isfinite(ratio), ratio, 0.0))


def _find_shifts(
    beyond: AnyArray, gap: Floats, jump: Floats, ratio: Floats, radius: float,
    pitch: tuple[float, float],
) -> Floats:  # fmt: skip
    """How far the border lies inside of the middle between the beams; negative: outside."""
    shift = np.where(beyond == EMPTY, STRETCH * radius, 0.0)
    step = float(np.mean(pitch))
    first = _is_first_return(beyond, gap, jump, radius, pitch)
    for kind, sign in ((FARTHER, 1.0), (NEARER, -1.0)):
        chosen = beyond == kind
        middle = _find_middles(gap[chosen] - step, ratio[chosen], radius)
        shift[chosen] = -middle
        if first:
            shift[chosen & (jump > FAR)] = sign * FIRST * radius
    return shift


def _is_first_return(
    beyond: AnyArray, gap: Floats, jump: Floats, radius: float, pitch: tuple[float, float]
) -> bool:
    """Whether far surfaces meet without points between them, though beams lie on both."""
    if 2.0 * FILLED * radius <= 1.5 * max(pitch):
        return False
    far = ((beyond == FARTHER) | (beyond == NEARER)) & (jump > FAR)
    return bool(far.sum() >= ENOUGH and np.median(gap[far]) < BARE * max(pitch))


def _find_middles(width: Floats, ratio: Floats, radius: float) -> Floats:
    """Where the middle between two surfaces lies for a true border at 0, metres, + on the leaf.

    `width` is how wide points between them lie. A point lies between surfaces when the echoes
    differ by less than a factor c either way, from the weaker to the stronger; c follows from
    the width. A beam's share on a half plane is that of a Gaussian, cut at its radius.
    """
    places, shares = tabulate_shares()
    strength = np.geomspace(1e-6, 1.0, NODES)
    with np.errstate(divide="ignore"):
        on_leaf = 1.0 / (1.0 + strength / np.maximum(ratio, 1e-9)[:, None])
        beyond = strength * ratio[:, None] / (1.0 + strength * ratio[:, None])
        one, other = (radius * np.interp(h, shares, places) for h in (on_leaf, beyond))
    best = np.abs(one - other - width[:, None]).argmin(axis=1)
    rows = np.arange(len(width))
    return np.asarray(0.5 * (one[rows, best] + other[rows, best]))


@cache
def tabulate_shares() -> tuple[Floats, Floats]:
    """Places from −1 to 1, beam radii, and the share of a beam there on a half plane."""
    across = np.linspace(-1.0, 1.0, 801)
    half = np.sqrt(1.0 - across**2)
    along = half[:, None] * np.linspace(-1.0, 1.0, 201)
    rows = np.exp(-2.0 * (across[:, None] ** 2 + along**2)).mean(axis=1) * half
    total = np.cumsum(rows)
    return across, np.asarray((total - 0.5 * rows) / total[-1])


def _average(shift: Floats, rim: Bools) -> Floats:
    """Mean over the rim cells around each one: a gap is told in whole cells."""
    from scipy.ndimage import uniform_filter

    count = uniform_filter(rim.astype(np.float64), AROUND)
    total = uniform_filter(shift, AROUND)
    return np.asarray(np.where(rim, total / np.maximum(count, 1e-12), 0.0))
