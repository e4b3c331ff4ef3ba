"""Amplitudes against noise: closed forms against seeded Monte Carlo."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.amplitude import measure_amplitude

HOLDER = np.deg2rad(np.arange(-60.0, 61.0, 10.0))


@pytest.mark.parametrize("mu", [None, 0.0, 17.0])
def test_noise_alone_exceeds_in_five_per_cent_and_has_the_expected_mean(mu: float | None) -> None:
    random = np.random.default_rng(12)
    found = [
        measure_amplitude(HOLDER, random.normal(0.2, 0.055, len(HOLDER)), mu) for _ in range(600)
    ]
    share = np.mean([one.exceeds_noise for one in found])
    assert 0.03 <= share <= 0.075
    mean = np.mean([abs(one.value) for one in found])
    np.testing.assert_allclose(np.mean([one.from_noise for one in found]), mean, rtol=0.08)


def test_a_swing_is_found_with_its_sign() -> None:
    random = np.random.default_rng(13)
    value = 0.3 - 0.1 * np.cos(2 * (HOLDER - np.deg2rad(10))) + random.normal(0, 0.01, len(HOLDER))
    found = measure_amplitude(HOLDER, value, 10.0)
    assert abs(found.value + 0.1) < 0.02
    assert found.exceeds_noise
    assert found.p < 1e-4
    assert found.mean == value.mean()


def test_exact_curves_have_no_noise() -> None:
    found = measure_amplitude(HOLDER, 0.3 + 0.04 * np.cos(2 * HOLDER))
    np.testing.assert_allclose((found.value, found.mu_deg), (0.04, 0.0), atol=1e-9)
    assert found.exceeds_noise
    flat = measure_amplitude(HOLDER, np.full(len(HOLDER), 0.3), 0.0)
    assert abs(flat.value) < 1e-12
