"""Beams, sub-rays and footprints against closed forms."""

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.simulate.beam import BeamGrid, Bundle, angles_of, grid_of_field


@pytest.mark.parametrize("rays", [1, 7, 37, 127])
def test_shares_of_the_subrays_sum_to_one(rays):
    rays = Bundle(rays=rays).subrays()
    assert rays[:, 2].sum() == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(rays[0, :2], 0)
    assert (np.hypot(rays[:, 0], rays[:, 1]) < 1).all()
    np.testing.assert_allclose((rays[:, :2] * rays[:, 2:]).sum(axis=0), 0, atol=0.4 / len(rays))


def test_radius_agrees_with_balduzzi():
    assert 2 * Bundle().radius(2.16) == pytest.approx(4.056e-3, abs=5e-7)


def share_beyond(edge):
    """Energy of a Gaussian disc, cut at its 1/e² radius, beyond a straight edge."""
    x = np.linspace(-1, 1, 2001)
    x, y = np.meshgrid(x, x)
    energy = np.exp(-2 * (x**2 + y**2)) * (x**2 + y**2 <= 1)
    return energy[x > edge].sum() / energy.sum()


@pytest.mark.parametrize("edge", [-0.8, -0.5, -0.2, 0.1, 0.4, 0.7])
def test_subrays_beyond_an_edge_carry_the_share_of_the_disc(edge):
    rays = Bundle().subrays()
    assert rays[rays[:, 0] > edge, 2].sum() == pytest.approx(share_beyond(edge), abs=0.06)
    fine = Bundle(rays=2791).subrays()
    assert fine[fine[:, 0] > edge, 2].sum() == pytest.approx(share_beyond(edge), abs=0.005)


def test_grid_runs_from_top_left_and_its_directions_give_its_angles():
    grid = grid_of_field(0.5, (-3, 4), (-1, 2))
    assert (grid.rows, grid.columns) == (7, 15)
    beams = grid.directions
    np.testing.assert_allclose(np.linalg.norm(beams, axis=-1), 1)
    elevation, azimuth = angles_of(beams.reshape(-1, 3), np.zeros(3))
    np.testing.assert_allclose(elevation.reshape(7, 15)[:, 3], np.deg2rad(2 - 0.5 * np.arange(7)))
    np.testing.assert_allclose(azimuth.reshape(7, 15)[2], np.deg2rad(4 - 0.5 * np.arange(15)))


@pytest.mark.parametrize("step", [0.0, -1.0, 90.0, float("nan")])
def test_impossible_steps_are_refused(step):
    with pytest.raises(WrongUse, match="step"):
        grid_of_field(step, (-3, 3), (-3, 3))


def test_grid_is_a_value():
    assert BeamGrid(0, 0, 1, 2, 3) == BeamGrid(0, 0, 1, 2, 3)


@pytest.mark.parametrize(
    ("field", "step", "columns"),
    [
        ((0.0, 1.0), 0.1, 11),
        ((0.0, 1.2), 0.1, 13),
        ((-0.3, 0.3), 0.2, 4),
        ((0.2, 0.3), 0.1, 2),
        ((0.0, 1.19), 0.1, 12),
    ],
)
def test_a_field_that_the_step_divides_has_both_its_ends(field, step, columns):
    grid = grid_of_field(step, field, field)
    assert (grid.rows, grid.columns) == (columns, columns)


@pytest.mark.parametrize(("step", "columns"), [(10, 36), (0.1, 3600), (0.018, 20000), (7, 52)])
@pytest.mark.parametrize("middle", [0, 33.3])
def test_a_full_circle_has_no_direction_twice(step, columns, middle):
    grid = grid_of_field(step, (middle - 180, middle + 180), (-10, 10))
    assert grid.columns == columns
    gap = 2 * np.pi - np.deg2rad(step) * (columns - 1)
    assert 1e-6 < gap < np.deg2rad(step) * (1 + 1e-6)
