"""Pieces of one surface, told from pieces of two: one second degree fits both as well as each.

A steep leaf breaks where its points lie between surfaces, and a stalk before a leaf cuts it.
"""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.touching import Sheet, lay_sheet

MEETING = 2
"""Beams at least by which two pieces must meet."""
LOOKED_AT = 600
"""Points of a piece at most that are fitted."""
FIRM = 3.0
"""One surface may leave so much of the mean square that a piece leaves by itself."""
OFF = 0.0005
"""Metres: and so much more, squared."""
BEYOND, ROUGH = 0.004, 4.0
"""Metres: the smaller piece lies so near to the surface of the larger one, carried on; or within
so many times what the larger one itself is off it, as wrinkled leaves are."""


def rejoin_pieces(
    beams: Floats, row: AnyArray, column: Ints, label: Ints, meeting: AnyArray, noise: float
) -> None:
    """Give pieces of one surface the label of the largest, in place.

    Parameters
    ----------
    beams : (n, 3) metres
        Points about the scanner.
    row, column : (n,)
    label : (n,) int64
    meeting : (k, 2)
        Labels of the pieces that meet, once for each beam by which they do.
    noise : float
        Metres: σ of a range.
    """
    if not len(meeting):
        return
    pairs, counts = np.unique(np.sort(meeting, axis=1), axis=0, return_counts=True)
    pairs = pairs[counts >= MEETING]
    order = np.argsort(label, kind="stable")
    bounds = np.searchsorted(label[order], np.arange(label.max(initial=-1) + 2))
    sizes = np.diff(bounds)
    # The largest pieces gather theirs first.
    pairs = np.take_along_axis(pairs, np.argsort(-sizes[pairs], axis=1), axis=1)
    pairs = pairs[np.argsort(-sizes[pairs[:, 0]], kind="stable")]
    leader = np.arange(len(sizes))

    def take(number: int) -> Ints:
        points = order[bounds[number] : bounds[number + 1]]
        return points[:: max(1, len(points) // LOOKED_AT)]

    for large, small in pairs.tolist():
        if leader[large] == leader[small]:
            continue
        both = [take(large), take(small)]
        points = np.concatenate(both)
        sheet = lay_sheet(beams[points], row[points], column[points])
        if _is_one(sheet, len(both[0]), noise):
            leader[leader == leader[small]] = leader[large]
    known = label >= 0
    label[known] = leader[label[known]]


def _is_one(sheet: Sheet, first: int, noise: float) -> bool:
    """Whether the first points and the others lie on one surface."""
    one, other = np.arange(len(sheet.depth)) < first, np.arange(len(sheet.depth)) >= first
    joint, large, small = (_fit(sheet, part) for part in (one | other, one, other))
    off = _square(sheet, one, large) ** 0.5
    if _square(sheet, other, large) > max(BEYOND, 2.0 * noise, ROUGH * off) ** 2:
        return False
    return all(
        _square(sheet, part, joint)
        <= FIRM * max(_square(sheet, part, own), noise**2 / FIRM) + OFF**2
        for part, own in ((one, large), (other, small))
    )


def _fit(sheet: Sheet, part: AnyArray) -> Floats:
    terms = sheet.terms[part]
    found = np.linalg.lstsq(terms.T @ terms, terms.T @ sheet.depth[part], rcond=1e-9)[0]
    return np.asarray(found, np.float64)


def _square(sheet: Sheet, part: AnyArray, found: Floats) -> float:
    return float(np.mean((sheet.depth[part] - sheet.terms[part] @ found) ** 2))
