"""Equations 6 and 7 of Balduzzi against numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.arrays import Floats
from app.core.radiometry.range_shift import scale_to_reference, shift_to_reference


def curve(distance: Floats) -> Floats:
    """99 % panel: 1800 DN at 2 m, 100 DN less per metre; known from 1 to 10 m."""
    return np.where((distance >= 1) & (distance <= 10), 2000.0 - 100.0 * distance, np.nan)


def test_equation_7_by_hand() -> None:
    # 1500 DN at 4 m is 100 below the panel's 1600; at 2 m the panel has 1800.
    found = shift_to_reference(np.array([1500.0]), np.array([4.0]), curve, 2.0)
    assert found == pytest.approx([1700.0], rel=1e-12)


def test_equation_6_by_hand() -> None:
    # A target of 1700 DN at 2 m is expected at 1500 there; 1515 is 1 % more.
    found = scale_to_reference(np.array([1515.0]), np.array([4.0]), curve, 2.0, 1700.0)
    assert found == pytest.approx([1717.0], rel=1e-12)


def test_without_scatter_both_give_the_number_at_the_reference_range() -> None:
    away = np.linspace(1.0, 10.0, 50)
    dn = curve(away) - 333.25
    seventh = shift_to_reference(dn, away, curve, 3.56)
    sixth = scale_to_reference(dn, away, curve, 3.56, float(2000 - 356 - 333.25))
    assert np.abs(seventh - sixth).max() < 1e-9


def test_nothing_is_told_outside_the_curve() -> None:
    away = np.array([0.5, 11.0])
    assert np.isnan(shift_to_reference(np.full(2, 1000.0), away, curve, 2.0)).all()
    assert np.isnan(scale_to_reference(np.full(2, 1000.0), away, curve, 2.0, 900.0)).all()
