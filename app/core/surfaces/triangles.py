"""Triangles between the cells of a leaf, cut at its border (marching triangles)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats, Ints


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """Corners in cells, and triangles of them.

    Attributes
    ----------
    place : (v, 2)
        Row and column of each corner, with decimals where a border cuts the way between cells.
    faces : (f, 3) int64
        Anticlockwise as rows count upwards and columns to the right.
    """

    place: Floats
    faces: Ints


def cut_triangles(inside: Floats) -> Cuts:
    """Triangles of the places where `inside` (h, w), linear between cells, is positive."""
    height, width = inside.shape
    number = np.arange(height * width).reshape(height, width)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    even = (np.add.outer(np.arange(height - 1), np.arange(width - 1)) % 2 == 0)[..., None]
    first = np.where(even, np.stack([a, b, d], -1), np.stack([a, b, c], -1))
    second = np.where(even, np.stack([a, d, c], -1), np.stack([b, d, c], -1))
    corners = np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])
    value = inside.ravel()
    positive = value > 0.0
    count = positive[corners].sum(axis=1)
    pieces = [_as_pairs(corners[count == 3])]
    pieces += _cut_one(corners[count == 1], positive)
    pieces += _cut_two(corners[count == 2], positive)
    pairs = np.concatenate(pieces)
    return _number_corners(pairs, value, width)


def _as_pairs(corners: Ints) -> Ints:
    """A corner that is a cell is a pair of that cell with itself, (f, 3, 2)."""
    return np.stack([corners, corners], axis=-1)


def _turn(corners: Ints, chosen: Bools) -> Ints:
    """Triangles turned so that the chosen corner comes first."""
    first = chosen.argmax(axis=1)[:, None]
    return np.take_along_axis(corners, (first + np.arange(3)) % 3, axis=1)


def _cut_one(corners: Ints, positive: Bools) -> list[Ints]:
    p, q, r = _turn(corners, positive[corners]).T
    return [_faces((p, p), (p, q), (p, r))]


def _cut_two(corners: Ints, positive: Bools) -> list[Ints]:
    p, q, r = _turn(corners, ~positive[corners]).T
    return [_faces((q, q), (r, r), (r, p)), _faces((q, q), (r, p), (q, p))]


def _faces(*pairs: tuple[Ints, Ints]) -> Ints:
    return np.stack([np.stack(pair, axis=-1) for pair in pairs], axis=1)


def _number_corners(pairs: Ints, value: Floats, width: int) -> Cuts:
    low, high = np.sort(pairs.reshape(-1, 2), axis=1).T
    unique, index = np.unique(low * len(value) + high, return_inverse=True)
    one, other = np.divmod(unique, len(value))
    low, high = value[one], value[other]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(one == other, 0.0, low / (low - high))
    rows, columns = (np.stack([one, other]) // width, np.stack([one, other]) % width)
    place = np.stack([v[0] + share * (v[1] - v[0]) for v in (rows, columns)], axis=1)
    return Cuts(place, index.reshape(-1, 3).astype(np.int64))
