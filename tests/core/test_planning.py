"""Plans against the paper, against plain sums, and against our simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.footprint import footprint_axis
from app.core.mixing import PhaseMixing, PulseMixing
from app.core.planning import (
    BOUNDS,
    Limits,
    Sight,
    find_steepest,
    foresee,
    full_leaf_angle,
)
from app.services.bench.simulate.rig import greys, send, silent, wall_at
from app.simulate.beam import BeamGrid, Bundle
from app.simulate.ranging import PhaseShift, Pulsed
from app.simulate.surfaces import Leaf

LS880 = Sight(
    0.0015, np.deg2rad(0.014), np.deg2rad(0.018), 0.08, 0.045, 1.0, PhaseMixing((76.8, 9.6, 1.2))
)
PEAR = replace(LS880, width=0.0219)


def test_balduzzis_leaf_is_as_wide_as_the_footprint_at_79_33_degrees() -> None:
    assert np.rad2deg(full_leaf_angle(2.16, 1.0, PEAR)) == pytest.approx(79.33, abs=0.005)
    share = foresee(2.16, np.deg2rad([20.0, 65.0]), PEAR).footprint / PEAR.width
    assert share == pytest.approx([0.197, 0.438], abs=0.001)


def test_the_angle_of_a_share_is_where_the_footprint_has_it() -> None:
    distance, share = np.array([[0.7], [2.0], [8.0]]), np.array([0.25, 0.5, 1.0, 3.0])
    angle = full_leaf_angle(distance, share, LS880)
    axis = footprint_axis(distance, angle, LS880.beam_radius, LS880.half_divergence)
    assert axis == pytest.approx(np.broadcast_to(share * LS880.width, axis.shape), rel=1e-9)


def test_points_are_solid_angle_over_step() -> None:
    seen = foresee(4.0, np.deg2rad(60.0), LS880)
    cell = (4.0 * np.deg2rad(0.018)) ** 2
    assert seen.points == pytest.approx(np.pi / 4 * 0.08 * 0.045 * 0.5 / cell)
    assert 0.0 < seen.full_hits < seen.points
    assert foresee(4.0, np.deg2rad(89.0), LS880).full_hits == 0.0


def simulate_leaf(
    distance: float, degrees: float, gap: float, ranging: PhaseShift | Pulsed
) -> tuple[float, float]:
    """Full hits and ghost share of a leaf turned about its length, before a wall."""
    angle, step = np.deg2rad(degrees), LS880.step
    tool = silent(ranging, Bundle(rays=61))
    normal = (-float(np.cos(angle)), float(np.sin(angle)), 0.0)
    leaf = Leaf((distance, 0, 0), (0, 0, 1), normal, LS880.length, LS880.width, greys(0.5, 0.5))
    count = int((LS880.length / distance + 0.01) / step)
    random = np.random.default_rng(100)
    top, left = (count * step / 2 + random.uniform() * step for _ in range(2))
    echoes = send(
        [leaf, wall_at(distance + gap, greys(0.5, 0.5))], tool,
        BeamGrid(top, left, step, count, count),
    )  # fmt: skip
    touches = (echoes.surface == 0).any(axis=1)
    ghosts = touches & (echoes.off_surface > 0.006)
    leaf_points = touches & ~ghosts & (np.abs(echoes.distance - distance - gap) > 0.0061)
    whole = (echoes.surface[:, 0] == 0) & (echoes.touched == 1) & (echoes.share[:, 0] > 0.9999)
    return whole.sum(), ghosts.sum() / (ghosts.sum() + leaf_points.sum())


@pytest.mark.parametrize("distance", [2.0, 6.0])
@pytest.mark.parametrize("degrees", [0.0, 60.0, 75.0])
@pytest.mark.parametrize(
    ("ranging", "mixing", "gap"),
    [
        (PhaseShift((76.8, 9.6, 1.2)), LS880.mixing, 0.05),
        (PhaseShift((76.8, 9.6, 1.2)), LS880.mixing, 1.0),
        (Pulsed(0.15, 0.25), PulseMixing(0.25, 0.05), 0.2),
        (Pulsed(0.15, 0.25), PulseMixing(0.25, 0.05), 1.0),
    ],
)
def test_hits_and_ghosts_are_those_of_the_simulator(
    distance: float, degrees: float, ranging: object, mixing: object, gap: float
) -> None:
    sight = replace(LS880, gap=gap, mixing=mixing)
    seen = foresee(distance, np.deg2rad(degrees), sight)
    full, ghosts = simulate_leaf(distance, degrees, gap, ranging)
    assert seen.full_hits == pytest.approx(full, rel=0.08, abs=6)
    assert seen.ghosts == pytest.approx(ghosts, abs=0.03)


def test_before_the_sky_there_are_no_ghosts() -> None:
    assert (foresee([2.0, 9.0], 0.5, replace(LS880, gap=np.inf)).ghosts == 0.0).all()


def test_the_steepest_angle_is_where_the_first_limit_is_met() -> None:
    ranges = np.array([2.0, 5.0, 9.0])
    for number, limits in enumerate(
        (Limits(0.3, 0.0, 2.0), Limits(9.0, 200.0, 2.0), Limits(9.0, 0.0, 0.35))
    ):
        found = find_steepest(ranges, LS880, limits)
        assert (found.bound == number).all(), BOUNDS
        seen = foresee(ranges, found.incidence, LS880)
        met = (seen.footprint / LS880.width / 0.3, seen.full_hits / 200.0, seen.ghosts / 0.35)
        assert met[number] == pytest.approx(1.0, abs=0.01)


def test_where_nothing_is_usable_the_reason_is_told() -> None:
    found = find_steepest([60.0], LS880, Limits(9.0, 50.0, 2.0))
    assert np.isnan(found.incidence[0])
    assert BOUNDS[found.bound[0]] == "full hits"
    free = find_steepest([1.0], replace(LS880, gap=np.inf), Limits(1e9, 0.0, 1.0))
    assert np.rad2deg(free.incidence[0]) == pytest.approx(89.0)


@pytest.mark.parametrize(
    "change",
    [{"step": 0.0}, {"step": np.nan}, {"length": -1.0}, {"width": np.inf}, {"gap": 0.0},
     {"contrast": 0.0}, {"contrast": np.nan}, {"beam_radius": -1.0}, {"half_divergence": 1.0}],
)  # fmt: skip
def test_sights_that_are_none_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(WrongUse):
        replace(LS880, **change)


def test_places_and_limits_that_are_none_are_refused() -> None:
    for distance, angle in ((0.0, 0.1), (np.nan, 0.1), (np.inf, 0.1), (2.0, np.pi / 2),
                            (2.0, -0.1), (2.0, np.nan)):  # fmt: skip
        with pytest.raises(WrongUse):
            foresee(distance, angle, LS880)
    for numbers in ((0.0, 1.0, 0.1), (0.1, -1.0, 0.1), (0.1, 1.0, np.nan)):
        with pytest.raises(WrongUse, match="Limits"):
            Limits(*numbers)
    assert foresee(np.empty(0), 0.1, LS880).points.shape == (0,)
