"""Energies of returns against a plain implementation, analytic pulses and Monte Carlo."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit
from scipy.special import erf

from app.core.errors import WrongUse
from app.core.radiometry.waveform import (
    CUT_OFF,
    MERGED,
    NO_FIT,
    NO_SIGNAL,
    SATURATED,
    Returns,
    measure_returns,
)

LENGTH = 160
ROOT = math.sqrt(2 * math.pi)


def gaussian(x: np.ndarray, height: Any, middle: Any, width: Any) -> np.ndarray:
    return height * np.exp(-0.5 * ((x - middle) / width) ** 2)


def measure(records: np.ndarray, place: Any, **options: Any) -> Returns:
    """Records of one length, one per row."""
    count, length = records.shape
    offsets = np.arange(count + 1) * length
    return measure_returns(
        records.ravel(), offsets, np.broadcast_to(place, count).astype(float), **options
    )


def draw_pulses(
    count: int, height: Any, width: float, seed: int, noise: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Pulses at random phases on a background of 20 with white noise; records and middles."""
    rng = np.random.default_rng(seed)
    middle = LENGTH / 2 + rng.uniform(-0.5, 0.5, count)
    x = np.arange(LENGTH)
    clean = gaussian(x, np.broadcast_to(height, count)[:, None], middle[:, None], width)
    return clean + 20.0 + noise * rng.standard_normal((count, LENGTH)), middle


# A second implementation, one record at a time, as the docstring of `measure_returns` says it.


def plain_noise(y: np.ndarray, quantum: float) -> tuple[float, float]:
    def floor(sigma: float) -> float:
        return sigma if sigma > quantum / 2 else math.hypot(sigma, quantum / math.sqrt(12))

    level = float(np.sort(y)[len(y) // 2])
    sigma = floor(1.482602218505602 * float(np.sort(np.abs(y - level))[len(y) // 2]))
    for _ in range(3):
        loud = np.abs(y - level) > max(3.5 * sigma, quantum)
        near = np.convolve(loud, np.ones(5), "same") > 0
        if (~near).sum() < 8:
            break
        level, sigma = y[~near].mean(), floor(y[~near].std(ddof=1))
    return level, sigma


def plain_bounds(y: np.ndarray, place: float, gate: float, rise: float) -> tuple[int, int] | None:
    """First and last sample, both of the return."""
    above = [i for i in np.flatnonzero(y > gate) if abs(i - math.floor(place + 0.5)) <= 3]
    if not above:
        return None
    at = min(above, key=lambda i: (abs(i - math.floor(place + 0.5)), -i))
    low = high = at
    while low > 0 and y[low - 1] > gate:
        low -= 1
    while high + 1 < len(y) and y[high + 1] > gate:
        high += 1
    # Valleys: lowest samples between two tops that both stand more than `rise` over them.
    cuts, i = [], low
    while i <= high:
        peak = i
        while i <= high and y[peak] - y[i] <= rise:
            peak = i if y[i] > y[peak] else peak
            i += 1
        valley = i
        while i <= high and y[i] - y[valley] <= rise:
            valley = i if y[i] < y[valley] else valley
            i += 1
        if i <= high:
            cuts.append(valley)
    return max([low, *(c for c in cuts if c <= at)]), min([high, *(c for c in cuts if c > at)])


def plain_sum(y: np.ndarray, place: float, sigmas: float, quantum: float) -> float:
    level, sigma = plain_noise(y, quantum)
    gate = level + sigmas * sigma
    bounds = plain_bounds(y, place, gate, math.sqrt(2) * sigmas * sigma)
    if bounds is None:
        return math.nan
    low, high = bounds
    total = (y[low : high + 1] - level).sum()
    for end, outside in ((low, low - 1), (high, high + 1)):
        if 0 <= outside < len(y) and y[outside] > gate:  # a valley: half of it
            total -= 0.5 * (y[end] - level)
    return float(total)


@settings(max_examples=60)
@given(
    seed=st.integers(0, 10**6),
    apart=st.floats(0.0, 25.0),
    height=st.floats(0.0, 200.0),
    sigmas=st.floats(2.0, 8.0),
    quantum=st.sampled_from([0.0, 0.5, 1.0, 4.0]),
)
def test_sum_is_that_of_the_plain_implementation(
    seed: int, apart: float, height: float, sigmas: float, quantum: float
) -> None:
    rng = np.random.default_rng(seed)
    x = np.arange(LENGTH)
    y = gaussian(x, 60.0, 70.3, 2.4) + gaussian(x, height, 70.3 + apart, 2.4)
    y = y + 20 + rng.standard_normal(LENGTH)
    y = np.round(y / quantum) * quantum if quantum else y
    for place in (70.3, 70.3 + apart, 20.0):
        found = measure(y[None], place, sigmas=sigmas, quantum=quantum)
        wanted = plain_sum(y, place, sigmas, quantum)
        assert found.sum[0] == pytest.approx(wanted, rel=1e-9, nan_ok=True)
        assert (found.level[0], found.noise[0]) == pytest.approx(plain_noise(y, quantum))


def test_gaussian_is_that_of_scipy() -> None:
    records, middle = draw_pulses(40, 50.0, 2.1, seed=3)
    found = measure(records, middle)
    for i, y in enumerate(records):
        gate = found.level[i] + 5 * found.noise[i]
        bounds = plain_bounds(y, middle[i], gate, math.inf)
        assert bounds is not None
        x = np.arange(bounds[0] - 2, bounds[1] + 3)
        best, covariance = curve_fit(
            gaussian, x, y[x] - found.level[i], (50.0, middle[i], 2.1),
            np.full(len(x), found.noise[i]), absolute_sigma=True, ftol=1e-14, xtol=1e-14,
        )  # fmt: skip
        slope = np.array([best[2], 0.0, best[0]]) * ROOT
        assert found.gaussian[i] == pytest.approx(best[0] * best[2] * ROOT, rel=1e-6)
        own = math.sqrt(slope @ covariance @ slope)
        assert own < found.gaussian_sigma[i] < 1.4 * own  # the background is unsure too


@pytest.mark.parametrize("width", [0.85, 2.1, 6.0])
def test_pulses_without_noise(width: float) -> None:
    middle = 80 + np.linspace(-0.5, 0.5, 21)
    records = gaussian(np.arange(LENGTH), 3.0, middle[:, None], width) + 0.25
    found = measure(records, middle, step=0.5, level=0.25, noise=0.003)
    area = 0.5 * 3.0 * width * ROOT
    assert found.peak == pytest.approx(3.0, rel=1e-6)
    assert found.gaussian == pytest.approx(area, rel=1e-6)
    # The mean over all places of the samples is the integral between the crossings.
    share = erf(math.sqrt(math.log(3.0 / 0.015)))
    assert found.sum[:-1].mean() == pytest.approx(area * share, rel=1e-3)
    assert np.all(found.marks == 0)


@pytest.mark.parametrize("width", [0.85, 1.5, 3.0])
def test_predicted_sigma_is_what_noise_does(width: float) -> None:
    """Root mean square of the error over its σ, within 10 %, whatever the phase."""
    count = 6000
    height = np.exp(np.random.default_rng(1).uniform(math.log(30), math.log(1000), count))
    records, middle = draw_pulses(count, height, width, seed=2)
    found = measure(records, middle)
    area = height * width * ROOT
    truths = {"sum": area * erf(np.sqrt(np.log(height / 5))), "peak": height, "gaussian": area}
    for name, truth in truths.items():
        error = getattr(found, name) - truth
        z = error / getattr(found, f"{name}_sigma")
        assert math.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.1), name
        assert abs(np.mean(error / truth)) < 0.004, name


def test_a_gaussian_wastes_less_than_the_peak_and_the_sum_is_between() -> None:
    """Relative spread at 100 σ and 5 samples of half width: what the choice of a method costs."""
    records, middle = draw_pulses(4000, 100.0, 2.1, seed=5)
    found = measure(records, middle)
    spread = {n: np.std(getattr(found, n)) for n in ("sum", "peak", "gaussian")}
    area = 100 * 2.1 * ROOT
    assert spread["gaussian"] / area == pytest.approx(0.0066, rel=0.1)
    assert spread["sum"] / area == pytest.approx(0.0083, rel=0.1)
    assert spread["peak"] / 100 == pytest.approx(0.0096, rel=0.1)


def test_two_returns_part_at_the_valley() -> None:
    x = np.arange(LENGTH)
    y = (gaussian(x, 1.0, 70.0, 2.0) + gaussian(x, 1.0, 78.0, 2.0))[None]
    alone = gaussian(x, 1.0, 70.0, 2.0)[None]
    first, second = (measure(y, place, level=0.0, noise=1e-3) for place in (70.0, 78.0))
    assert first.sum[0] == pytest.approx(second.sum[0], rel=1e-12)
    run = y[0][y[0] > 5e-3]
    assert first.sum[0] + second.sum[0] == pytest.approx(run.sum(), rel=1e-12)
    assert first.sum[0] == pytest.approx(measure(alone, 70.0, level=0.0, noise=1e-3).sum[0], 0.01)
    assert first.marks[0] == second.marks[0] == MERGED
    # Noise of 5 % makes the valley too shallow to say so.
    assert measure(y, 70.0, level=0.0, noise=0.1).marks[0] & MERGED == 0


def test_saturated_samples_are_counted_and_the_gaussian_sees_past_them() -> None:
    records, middle = draw_pulses(400, 100.0, 4.0, seed=8)
    clipped = np.minimum(records, 90.0)
    found = measure(clipped, middle, ceiling=90.0)
    assert np.array_equal(found.saturated, (clipped >= 90.0).sum(axis=1))
    assert np.all(found.marks & SATURATED)
    area = 100 * 4.0 * ROOT
    assert found.sum.mean() < 0.92 * area
    z = (found.gaussian - area) / found.gaussian_sigma
    assert math.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.15)


def test_records_that_tell_nothing() -> None:
    y = 20 + np.random.default_rng(0).standard_normal(LENGTH)
    y[80] = 100.0
    places = [80.0, 83.4, 83.6, 40.0, -1e9, 1e300, math.nan]
    found = measure(np.tile(y, (len(places), 1)), places)
    assert found.marks.tolist() == [NO_FIT, NO_FIT] + 5 * [NO_SIGNAL]
    assert np.array_equal(np.isfinite(found.sum), [True, True] + 5 * [False])
    assert found.sum[0] == pytest.approx(80.0, abs=3.0)
    empty = measure_returns(np.empty(0), np.zeros(3, int), np.zeros(2))
    assert empty.marks.tolist() == [NO_SIGNAL, NO_SIGNAL]
    assert np.isnan(empty.level).all()
    assert len(measure_returns(np.empty(0), np.zeros(1, int), np.empty(0)).sum) == 0


def test_a_return_at_the_border_is_marked() -> None:
    x = np.arange(LENGTH)
    y = gaussian(x, 1.0, 1.0, 2.0)[None]
    assert measure(y, 1.0, level=0.0, noise=1e-3).marks[0] & CUT_OFF


def test_a_background_of_zeros_has_the_noise_of_rounding() -> None:
    """Recorders that write 0 below their own threshold: no deviation at all is left."""
    y = np.round(gaussian(np.arange(LENGTH), 40.0, 80.0, 2.0))[None]
    found = measure(y, 80.0, quantum=1.0)
    assert (found.level[0], found.noise[0]) == pytest.approx((0.0, 1 / math.sqrt(12)))
    assert found.sum[0] == pytest.approx(y[0][y[0] > 5 / math.sqrt(12)].sum())


def test_returns_do_not_pull_the_background_up() -> None:
    """A third of the record is signal: the median is off by half a σ, what is told is not."""
    records, _ = draw_pulses(500, 300.0, 2.0, seed=9)
    x = np.arange(LENGTH)
    for middle in (20, 40, 60, 100, 120):
        records = records + gaussian(x, 200.0, middle, 2.0)
    found = measure(records, 80.0)
    assert (np.median(records, axis=1) - 20).mean() > 0.5
    assert abs((found.level - 20).mean()) < 0.05
    assert found.noise.mean() == pytest.approx(1.0, abs=0.03)


@given(scale=st.floats(1e-6, 1e6), shift=st.floats(-1e3, 1e3))
def test_volts_or_millivolts(scale: float, shift: float) -> None:
    records, middle = draw_pulses(3, 60.0, 2.0, seed=11)
    one, two = measure(records, middle), measure((records + shift) * scale, middle)
    for name in ("sum", "peak", "gaussian", "sum_sigma", "peak_sigma", "gaussian_sigma"):
        assert getattr(two, name) == pytest.approx(getattr(one, name) * scale, rel=1e-6)
    assert np.array_equal(one.marks, two.marks)


def test_wrong_use() -> None:
    for sigmas in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(WrongUse, match="threshold"):
            measure(np.zeros((1, 9)), 0.0, sigmas=sigmas)
    for offsets in ([0, 10], [5, 0], [-1, 3], [0, 3, 9]):
        with pytest.raises(WrongUse, match="offsets"):
            measure_returns(np.zeros(9), np.array(offsets), np.zeros(1))
