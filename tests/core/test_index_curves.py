"""Index against angle: known curves, Monte Carlo, and a plain loop over the steps."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.channel_index import choose_index
from app.core.errors import BadInput
from app.core.index_curves import IndexCurve, bins_of_index, curve_of_index, fit_channel
from app.core.phase import get_model

ANGLE = np.deg2rad(np.arange(0.0, 85.0, 5.0))
INDEX = choose_index("ndvi", {"nir": 818.0, "red": 666.0})
TRUE = {
    "nir": {"f": 0.9, "k_d": 0.88, "m": 0.19},
    "red": {"f": 0.3, "k_d": 0.42, "m": 0.3},
}
MODEL = get_model("lambert-beckmann")


def test_the_index_of_exact_curves_is_exact() -> None:
    values = {name: MODEL.evaluate(ANGLE, known) for name, known in TRUE.items()}
    fits = {name: fit_channel("lambert-beckmann", ANGLE, value) for name, value in values.items()}
    fine = np.deg2rad(np.linspace(0, 80, 333))
    a, b = (MODEL.evaluate(fine, TRUE[name]) for name in ("nir", "red"))
    found = curve_of_index(INDEX, fits, fine)
    np.testing.assert_allclose(found.value, (a - b) / (a + b), atol=1e-8)
    whole = curve_of_index(INDEX, fits)
    low, low_at, high, _ = whole.extremes
    np.testing.assert_allclose(low, ((a - b) / (a + b)).min(), atol=1e-3)
    np.testing.assert_allclose(high, ((a - b) / (a + b)).max(), atol=1e-3)
    assert whole.angle[np.argmin(whole.value)] == low_at


@pytest.mark.parametrize("model", ["fourier-2", "lambert-beckmann"])
def test_sigma_of_the_curve_is_what_many_noisy_scans_show(model: str) -> None:
    random = np.random.default_rng(8)
    angle = np.repeat(ANGLE, 6)
    clean = {name: MODEL.evaluate(angle, known) for name, known in TRUE.items()}
    at = np.deg2rad(np.array([10.0, 30.0, 55.0]))
    curves = []
    for _ in range(150):
        noisy = {name: value + random.normal(0, 0.004, len(angle)) for name, value in clean.items()}
        fits = {name: fit_channel(model, angle, value) for name, value in noisy.items()}
        curves.append(curve_of_index(INDEX, fits, at))
    spread = np.std([curve.value for curve in curves], axis=0)
    said = np.median([curve.sigma for curve in curves], axis=0)
    # Fourier is no model of these curves: its misfit counts as noise, so it says more.
    assert (said > 0.8 * spread).all()
    if model == "lambert-beckmann":
        np.testing.assert_allclose(said, spread, rtol=0.2)


def test_steps_hold_the_index_of_their_means() -> None:
    random = np.random.default_rng(9)
    angle = np.deg2rad(random.uniform(0, 60, 4000))
    values = {"nir": random.uniform(0.4, 0.6, 4000), "red": random.uniform(0.1, 0.2, 4000)}
    values["nir"][::50] = np.nan
    found = bins_of_index(INDEX, angle, values)
    place = np.floor(np.rad2deg(angle) / 5 + 0.5)
    kept = np.isfinite(values["nir"])
    for number, step in enumerate(np.unique(place)):
        own = kept & (place == step)
        a, b = values["nir"][own], values["red"][own]
        index = (a.mean() - b.mean()) / (a.mean() + b.mean())
        np.testing.assert_allclose(found.value[number], index, rtol=1e-12)
        assert found.count[number] == own.sum()
        # Each mean's error by the delta method, with the points' own linearised index.
        total = a.mean() + b.mean()
        single = 2 * (b.mean() * a - a.mean() * b) / total**2
        sigma = single.std(ddof=1) / np.sqrt(own.sum())
        np.testing.assert_allclose(found.sigma[number], sigma, rtol=1e-6)


def test_a_step_with_one_point_has_no_sigma() -> None:
    found = bins_of_index(INDEX, np.array([0.1]), {"nir": np.array([0.5]), "red": np.array([0.1])})
    assert found.count.tolist() == [1]
    assert np.isnan(found.sigma).all()
    empty = IndexCurve(*(np.full(2, np.nan),) * 3, np.zeros(2, np.int64))
    assert np.isnan(empty.extremes).all()


@pytest.mark.parametrize("spread", [1e-6, 1e-3])
def test_a_flat_leaf_that_determines_no_curve_is_refused_in_words(spread: float) -> None:
    refused = 0
    for seed in range(4):
        random = np.random.default_rng(seed)
        angle = np.deg2rad(30.0) + random.normal(0, spread, 50)
        value = 0.4 + random.normal(0, 0.01, 50)
        try:
            assert fit_channel("fourier-2", angle, value).names
        except BadInput as error:
            refused += "do not determine" in str(error)
    assert refused
