"""Surfaces that touch or cross, told apart by their shapes.

Two leaves that cross join where the jump between them closes. Two surfaces of second degree then
fit the points far better than one does; on a single leaf, bent or wrinkled, they hardly do.
Besl & Jain (1988) grow such surfaces from seeds; here all points are shared out at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.holder import across_of
from app.core.progress import QUIET, Progress

SIDE = 36
"""Cells along the longer side of what is looked at; denser surfaces are thinned."""
APART = 0.5
"""Two surfaces leave at most so much of the mean square that one leaves. On scenes with truth,
single leaves keep 0.52 or more."""
FAR, FAR_APART = 0.003, 0.65
"""The same where one surface is off by so many metres, as no single leaf is that was seen: of a
chain of leaves two surfaces leave more."""
ALIKE = 0.7
"""Parts are one surface again when one leaves no more than the inverse of this."""
LEAST = 0.002
"""Metres: a surface that is off one of second degree by less is one leaf, flat or wrinkled."""
LEAST_AGAIN = 0.0012
"""The same for parts of what was parted already; what was cut too often is joined again."""
WHOLE = 0.6
"""Share of a part that lies in one piece. Waves of a wrinkled leaf are shared out in stripes."""
MOST = 0.006
"""Metres: what is farther off a surface counts as so much."""
TURNS = 8
"""Sharings among all parts at most."""
DIRECTIONS = 6
"""Directions of the cuts to start from."""
FEWEST = 12


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Points of a surface as depths over directions, (n,) arrays.

    `terms` (n, 6) are those of a second degree in the directions; `depth` is in metres, from
    one over the depth along the mean beam, of which a plane is linear in the directions.
    """

    terms: Floats
    depth: Floats
    row: Ints
    column: Ints


def part_touching(
    beams: Floats, row: Ints, column: Ints, label: Ints, chosen: Bools, noise: float, fewest: int,
    turn: int | None = None, progress: Progress = QUIET,
) -> None:  # fmt: skip
    """Give touching surfaces labels of their own, in place.

    Parameters
    ----------
    beams : (n, 3) metres
        Points about the scanner.
    row, column : (n,)
    label : (n,) int64
        -1 for points of no surface.
    chosen : (labels,) bool
        Surfaces to be looked at.
    noise : float
        Metres: σ of a range.
    fewest : int
        Points that a part has at least.
    turn : int or None
        Columns after which the first one comes again.
    """
    order = np.argsort(label, kind="stable")
    order = order[np.searchsorted(label[order], 0) :]
    bounds = np.searchsorted(label[order], np.arange(len(chosen) + 1))
    following = len(chosen)
    asked = np.flatnonzero(chosen & (np.diff(bounds) >= 2 * fewest))
    for place, number in enumerate(asked):
        progress.report(place / len(asked), "leaves")
        points = order[bounds[number] : bounds[number + 1]]
        across = unroll(column[points].astype(np.int64), turn)
        parts = part_surface(lay_sheet(beams[points], row[points], across), noise, fewest)
        for part in parts[1:]:
            label[points[part]] = following
            following += 1


def unroll(column: Ints, turn: int | None) -> Ints:
    """Columns without the seam: they count from behind the widest gap on."""
    if turn is None or 2 * np.ptp(column) < turn:
        return column
    filled = np.unique(column)
    gaps = np.diff(np.append(filled, filled[0] + turn))
    return np.asarray((column - filled[(gaps.argmax() + 1) % len(filled)]) % turn)


def lay_sheet(beams: Floats, row: AnyArray, column: Ints) -> Sheet:
    """Points about the scanner as a sheet."""
    ahead = (beams / np.linalg.norm(beams, axis=1)[:, None]).mean(axis=0)
    ahead /= np.linalg.norm(ahead)
    seen = beams @ np.vstack([ahead, *across_of(ahead)]).T
    depth = np.maximum(seen[:, 0], 1e-9)
    a, b = ((t := seen[:, k] / depth) - t.mean() for k in (1, 2))
    size = max(np.ptp(a), np.ptp(b), 1e-12) / 2
    a, b = a / size, b / size
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)
    middle = float(np.median(depth))
    flat = middle - middle**2 / depth
    down = row.astype(np.int64)
    return Sheet(terms, flat, down - down.min(), column - column.min())


def part_surface(sheet: Sheet, noise: float, fewest: int) -> list[Ints]:
    """Numbers of the points of each part, the largest first; a single one for one surface."""
    parts: list[Ints] = []
    todo = [np.arange(len(sheet.depth))]
    while todo:
        points = todo.pop()
        least = max(noise, LEAST_AGAIN if parts or todo else LEAST)
        second = _find_second(_take(sheet, points), least, fewest)
        if second is None:
            parts.append(points)
        else:
            todo += [points[~second], points[second]]
    if len(parts) > 2:
        _join_alike(sheet, parts)
    if len(parts) > 2:
        parts = share_points(sheet, parts, fewest)
        _join_alike(sheet, parts)
    return sorted(parts, key=len, reverse=True)


def share_points(sheet: Sheet, parts: list[Ints], fewest: int) -> list[Ints]:
    """Share all points out among all parts by turns: a first cut may have gone through a leaf.

    Parts that come out smaller than `fewest` are shared out among the others.
    """
    from app.core.kernels.two_surfaces import spread_squares

    shape = sheet.row.max() + 1, sheet.column.max() + 1
    work, rounds = np.empty(shape), max(1, max(shape) // SIDE) ** 2
    owner = np.zeros(len(sheet.depth), np.int64)
    for _ in range(TURNS):
        squares = np.empty((len(parts), len(sheet.depth)))
        for place, part in enumerate(parts):
            terms = sheet.terms[part]
            found = np.linalg.lstsq(terms.T @ terms, terms.T @ sheet.depth[part], rcond=1e-9)[0]
            cells = np.zeros(shape)
            off = (sheet.depth - sheet.terms @ found) ** 2
            cells[sheet.row, sheet.column] = np.minimum(off, MOST**2)
            for _ in range(rounds):
                spread_squares(cells, work)
            squares[place] = cells[sheet.row, sheet.column]
        before, owner = owner, squares.argmin(axis=0)
        shared = [np.flatnonzero(owner == place) for place in range(len(parts))]
        parts = [part for part in shared if len(part) >= fewest]
        if len(parts) < len(shared):
            continue
        if (owner == before).all():
            break
    left = np.setdiff1d(np.arange(len(owner)), np.concatenate(parts))
    parts = sorted(parts, key=len)
    return [*parts[:-1], np.append(parts[-1], left)]


def _take(sheet: Sheet, points: Ints) -> Sheet:
    row, column = sheet.row[points], sheet.column[points]
    return Sheet(sheet.terms[points], sheet.depth[points], row - row.min(), column - column.min())


def _find_second(sheet: Sheet, least: float, fewest: int) -> Bools | None:
    """Points of the second of two surfaces; None: there is one."""
    from app.core.kernels.two_surfaces import fit_one, fit_two, share_out

    if len(sheet.depth) < 2 * fewest:
        return None
    step = int(-(-(max(sheet.row.max(), sheet.column.max()) + 1) // SIDE))
    kept = np.flatnonzero((sheet.row % step == step // 2) & (sheet.column % step == step // 2))
    few = max(FEWEST, fewest // step**2)
    if len(kept) < 2 * few:
        return None
    terms, depth = sheet.terms[kept], sheet.depth[kept]
    single = fit_one(terms, depth)
    if single < least**2:
        return None
    thin = sheet.row[kept] // step, sheet.column[kept] // step
    starts = _list_starts(terms, depth)
    found, left = np.empty((len(starts), 2, 6)), np.empty(len(starts))
    fit_two(terms, depth, *thin, starts, few, MOST**2, found, left)
    enough = (FAR_APART if single > FAR**2 else APART) * single
    shape = sheet.row.max() + 1, sheet.column.max() + 1
    sheets = (np.empty(shape), np.empty(shape), np.empty(shape))
    for k in np.argsort(left):
        if not left[k] < enough:
            break
        owner = np.zeros(len(sheet.depth), np.int64)
        share_out(
            sheet.terms, sheet.depth, sheet.row, sheet.column, found[k], MOST**2, step**2, owner,
            *sheets,
        )  # fmt: skip
        second: Bools = owner == 1
        if min(second.sum(), (~second).sum()) >= fewest and is_whole(sheet, second):
            return second
    return None


def is_whole(sheet: Sheet, second: Bools) -> bool:
    """Whether most of each part lies in one piece; gaps of a cell or two are none."""
    from scipy.ndimage import binary_dilation, label

    for part in (second, ~second):
        there = np.zeros((sheet.row.max() + 1, sheet.column.max() + 1), np.bool_)
        there[sheet.row[part], sheet.column[part]] = True
        pieces, _ = label(binary_dilation(there, np.ones((3, 3), np.bool_)))
        sizes = np.bincount(pieces[sheet.row[part], sheet.column[part]])
        if sizes.max() < WHOLE * part.sum():
            return False
    return True


def _list_starts(terms: Floats, depth: Floats) -> AnyArray:
    """Cuts across the surface in several directions, and by depth, (k, n)."""
    a, b = terms[:, 1] - np.median(terms[:, 1]), terms[:, 2] - np.median(terms[:, 2])
    turns = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    cuts = [np.cos(turn) * a + np.sin(turn) * b > 0.0 for turn in turns]
    cuts += [depth > np.median(depth), depth > 0.5 * (depth.min() + depth.max())]
    return np.stack(cuts).astype(np.int64)


def _join_alike(sheet: Sheet, parts: list[Ints]) -> None:
    """Join parts again that are one surface: a cut may have gone through it by the way."""
    from app.core.kernels.two_surfaces import fit_one

    def measure(points: Ints) -> float:
        thin = points[:: max(1, len(points) // SIDE**2)]
        return float(fit_one(sheet.terms[thin], sheet.depth[thin]))

    squares = [measure(part) for part in parts]
    first = 0
    while first < len(parts):
        second = first + 1
        while second < len(parts):
            both = np.concatenate([parts[first], parts[second]])
            sizes = len(parts[first]), len(parts[second])
            apart = (sizes[0] * squares[first] + sizes[1] * squares[second]) / len(both)
            together = measure(both)
            if apart > ALIKE * together:
                parts[first], squares[first] = both, together
                del parts[second], squares[second]
                second = first + 1
            else:
                second += 1
        first += 1
