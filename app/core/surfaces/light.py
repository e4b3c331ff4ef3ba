"""Where a leaf ends, from the light: a beam on two surfaces returns a mixture of their echoes.

A beam brings back h · (echo of the leaf) + (1 − h) · (echo beyond); the border is where the
share h of the leaf sums to. This needs no range, and no word on which points were taken out.
"""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.surfaces.crop import FARTHER, GHOST, MEMBER, OUTSIDE

ZONE = 1.1
"""Beam radii on either side of the border within which beams may lie on both surfaces."""
CONTRAST = 0.35
"""Least difference of the two echoes, as a share of the leaf's, that tells a share."""
AROUND = 7
"""Cells over which echoes of whole beams are averaged."""
ALONG = 17
"""Cells over which the border's shift is averaged."""
TOLD = 0.6
"""Share of the beams around a place of the border that must tell."""
WILD = 0.3
"""A share of light may lie so far outside of 0 to 1, by noise; more is cut."""


Echoes = tuple[Floats | None, Floats | None]
"""Light of whole beams on the leaf and beyond its border, (h, w) each; None: there are none."""


def shift_by_light(
    light: Floats, echoes: Echoes, state: AnyArray, inside: Floats, rim: Bools, reach: float,
    cell: float, length: float, first: bool = False,
) -> Floats:  # fmt: skip
    """How far the border lies inside of where `inside` is 0, at each rim cell; NaN: not told.

    Parameters
    ----------
    light : (h, w)
        Power received, in any unit; NaN where unknown, 0 without a return.
    echoes : pair of (h, w)
        See `carry_echoes`.
    state : (h, w)
        States of the cells, see `crop`.
    inside : (h, w) metres
        Signed distance to the border so far.
    rim : (h, w) bool
    reach : float
        Metres: radius of the beam.
    cell : float
        Square metres of a cell across the beam.
    length : float
        Metres of border per rim cell.
    first : bool
        The scanner reports the first return: its echo holds nothing of what lies behind.
    """
    known = np.isfinite(light)
    zone = np.abs(inside) <= ZONE * reach
    there = find_beyond(state)
    own, other = echoes
    shift = np.full(rim.shape, np.nan)
    if own is None or other is None:
        return shift[rim]
    if first:
        light = np.where(there & (state == FARTHER), 0.0, light)
        other = np.where(_nearest_is_farther(state, there), 0.0, other)
    gain = own - other
    tells = zone & known & (np.abs(gain) > CONTRAST * np.abs(own))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip((light - other) / gain, -WILD, 1.0 + WILD)
    excess = np.where(tells, share - (inside > 0.0), 0.0)
    return _gather(excess, tells, zone, rim, cell, length)


def find_beyond(state: AnyArray) -> Bools:
    """Cells of other surfaces, or without a return."""
    beyond: Bools = (state != MEMBER) & (state != GHOST) & (state != OUTSIDE)
    return beyond


def carry_echoes(light: Floats, state: AnyArray, inside: Floats, reach: float) -> Echoes:
    """Light of whole beams on the leaf and beyond its border, carried on to all cells, (h, w)."""
    known = np.isfinite(light)
    own = _carry(light, known & (state == MEMBER) & (inside > ZONE * reach))
    other = _carry(light, known & find_beyond(state) & (inside < -ZONE * reach))
    return own, other


def _nearest_is_farther(state: AnyArray, there: Bools) -> Bools:
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~there, return_distances=False, return_indices=True)
    return np.asarray(state[nearest[0], nearest[1]] == FARTHER)


def _carry(light: Floats, chosen: Bools) -> Floats | None:
    """Mean light of chosen cells around, carried on to all cells from the nearest; None: none."""
    from scipy.ndimage import distance_transform_edt, uniform_filter

    if not chosen.any():
        return None
    count = uniform_filter(chosen.astype(np.float64), AROUND)
    total = uniform_filter(np.where(chosen, light, 0.0), AROUND)
    nearest = distance_transform_edt(~chosen, return_distances=False, return_indices=True)
    mean = total / np.maximum(count, 1e-12)
    return np.asarray(mean[nearest[0], nearest[1]])


def _gather(
    excess: Floats, tells: Bools, zone: Bools, rim: Bools, cell: float, length: float
) -> Floats:
    from scipy.ndimage import distance_transform_edt, uniform_filter

    toward = distance_transform_edt(~rim, return_distances=False, return_indices=True)
    flat = np.ravel_multi_index((toward[0], toward[1]), rim.shape)

    def sum_up(values: AnyArray) -> Floats:
        total = np.bincount(flat[zone], values[zone], rim.size).reshape(rim.shape)
        return np.asarray(uniform_filter(total, ALONG))

    told, asked = sum_up(tells.astype(np.float64)), sum_up(zone.astype(np.float64))
    border = uniform_filter(rim.astype(np.float64), ALONG)
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = -sum_up(excess) * cell / (border * length) * (asked / told)
        shift = np.where(told >= TOLD * asked, shift, np.nan)
    return np.asarray(shift[rim])
