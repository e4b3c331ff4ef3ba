"""Fits: right for every model, never worse than a general optimiser, honest about doubt."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit, least_squares

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.fitting import FitResult, fit
from app.core.phase import MODELS, PhaseModel
from app.core.units import to_radians

ANGLES = to_radians(np.arange(0.0, 85.0, 2.5))


@pytest.fixture(params=MODELS.values(), ids=MODELS.keys())
def model(request: pytest.FixtureRequest) -> PhaseModel:
    return request.param


def draw(model: PhaseModel, seed: int, scale: float = 1.0) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    return {
        p.name: float(rng.uniform(*p.typical)) * (scale if p.scales else 1.0)
        for p in model.parameters
    }


def print_curve(angle: Floats, f: float, k_d: float, m: float) -> Floats:
    t = np.tan(angle) ** 2
    return f * (k_d * np.cos(angle) + (1 - k_d) * np.exp(-t / m**2) * (1 + t) ** 2.5)


def search_widely(angle: Floats, value: Floats, rng: np.random.Generator) -> float:
    """Least sum of squares that a trust-region search finds from many starts."""
    bounds = ([0, 0, 1e-3], [np.inf, 1, 1])
    starts = zip(rng.uniform(0.2, 2, 12), rng.uniform(0, 1, 12), np.geomspace(0.02, 1, 12),
                 strict=True)  # fmt: skip
    return min(
        2
        * least_squares(
            lambda p: print_curve(angle, *p) - value,
            start,
            bounds=bounds,
            xtol=1e-14,
            ftol=1e-14,
            gtol=1e-14,
        ).cost
        for start in starts
    )


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("seed", range(8))
def test_parameters_are_recovered(model: PhaseModel, seed: int, scale: float) -> None:
    values = draw(model, seed, scale)
    result = fit(model, ANGLES, model.evaluate(ANGLES, values))
    assert result.values == pytest.approx(values, rel=1e-9, abs=0.0)
    assert result.r2 == pytest.approx(1.0)
    assert result.n == len(ANGLES)


@pytest.mark.parametrize("seed", range(4))
def test_scale_moves_only_scaling_parameters(model: PhaseModel, seed: int) -> None:
    noise = 1 + 0.1 * np.random.default_rng(seed).standard_normal(len(ANGLES))
    value = model.evaluate(ANGLES, draw(model, seed)) * noise
    one, many = fit(model, ANGLES, value), fit(model, ANGLES, 321.0 * value)
    for p in model.parameters:
        factor = 321.0 if p.scales else 1.0
        assert many.values[p.name] == pytest.approx(factor * one.values[p.name], rel=1e-8)
    assert many.rss == pytest.approx(321.0**2 * one.rss, rel=1e-10)


@given(st.integers(0, 2**32 - 1), st.sampled_from(list(MODELS)))
@settings(max_examples=60, deadline=None)
def test_bounds_are_respected(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 1.5, int(rng.integers(8, 40)))
    result = fit(name, angle, rng.normal(rng.uniform(-1, 1), 1, len(angle)))
    for p in MODELS[name].parameters:
        estimate = result.parameters[p.name]
        assert estimate.value is None or p.lower <= estimate.value <= p.upper
        assert estimate.sd is None or not estimate.at_bound
        assert estimate.sd is not None or any(p.name in w for w in result.warnings)


@pytest.mark.parametrize("seed", range(12))
def test_never_worse_than_a_wide_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angle = ANGLES if seed % 2 else rng.uniform(0.0, 1.4, int(rng.integers(6, 60)))
    true = (1.0, [rng.uniform(0.2, 1.0), 1.0][seed % 3 == 2], rng.uniform(0.15, 0.6))
    value = print_curve(angle, *true) * (1 + rng.choice([0.06, 0.3]) * rng.normal(size=len(angle)))
    ours = fit("lambert-beckmann", angle, value).rss
    assert ours <= search_widely(angle, value, rng) * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_never_worse_on_many_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 1.4, 3000)
    value = print_curve(angle, 1.0, 0.5, rng.uniform(0.05, 0.6)) + 0.2 * rng.normal(size=3000)
    ours = fit("lambert-beckmann", angle, value).rss
    assert ours <= search_widely(angle, value, rng) * (1 + 1e-9)


@pytest.mark.parametrize("name", ["fourier-2", "cosine"])
def test_never_worse_than_a_search_of_the_others(name: str) -> None:
    model, rng = MODELS[name], np.random.default_rng(4)
    names = [p.name for p in model.parameters]
    bounds = list(zip(*((p.lower, p.upper) for p in model.parameters), strict=True))

    def miss(p: Floats) -> Floats:
        return model.evaluate(ANGLES, dict(zip(names, p, strict=True))) - value

    for seed in range(3):
        value = model.evaluate(ANGLES, draw(model, seed)) + 0.05 * rng.normal(size=len(ANGLES))
        starts = [list(draw(model, 100 + i).values()) for i in range(8)]
        best = min(2 * least_squares(miss, start, bounds=bounds).cost for start in starts)
        assert fit(model, ANGLES, value).rss <= best * (1 + 1e-9)


@pytest.mark.parametrize("weighted", [False, True])
def test_deviations_are_those_of_curve_fit(weighted: bool) -> None:
    rng = np.random.default_rng(8)
    sigma = rng.uniform(0.02, 0.1, len(ANGLES)) if weighted else np.full(len(ANGLES), 0.05)
    value = print_curve(ANGLES, 1.0, 0.5, 0.3) + sigma * rng.normal(size=len(ANGLES))
    best, covariance = curve_fit(
        print_curve, ANGLES, value, p0=[1, 0.5, 0.3], sigma=sigma, xtol=1e-14, ftol=1e-14
    )
    result = fit("lambert-beckmann", ANGLES, value, weights=sigma**-2)
    estimates = [result.parameters[name] for name in ("f", "k_d", "m")]
    assert [e.value for e in estimates] == pytest.approx(best, rel=1e-6)
    assert [e.sd for e in estimates] == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-4)
    misses = (value - result.evaluate(ANGLES)) / sigma
    assert result.rss == pytest.approx(float(misses @ misses), rel=1e-12)


def test_weights_count_like_repeated_pairs() -> None:
    rng = np.random.default_rng(2)
    value = print_curve(ANGLES, 1.0, 0.5, 0.3) + 0.05 * rng.normal(size=len(ANGLES))
    times = rng.integers(1, 5, len(ANGLES))
    heavy = fit("lambert-beckmann", ANGLES, value, weights=times.astype(float))
    long = fit("lambert-beckmann", np.repeat(ANGLES, times), np.repeat(value, times))
    assert heavy.values == pytest.approx(long.values, rel=1e-9)
    assert heavy.rss == pytest.approx(long.rss, rel=1e-12)
    assert heavy.rmse == pytest.approx(long.rmse, rel=1e-12)


def test_diffuse_leaf_has_no_roughness() -> None:
    result = fit("lambert-beckmann", ANGLES, 640.0 * np.cos(ANGLES))
    assert result.parameters["k_d"].value == 1.0
    assert result.parameters["k_d"].at_bound
    assert result.parameters["k_d"].sd is None
    assert result.parameters["m"].value is None
    assert any("m is undetermined" in w for w in result.warnings)
    np.testing.assert_allclose(result.evaluate(ANGLES), 640.0 * np.cos(ANGLES))
    np.testing.assert_allclose(result.inverse(result.evaluate(ANGLES)), ANGLES, atol=1e-7)


def test_dark_leaf_has_nothing_but_f() -> None:
    result = fit("lambert-beckmann", ANGLES, np.zeros(len(ANGLES)))
    assert result.parameters["f"].value == 0.0
    assert result.parameters["k_d"].value is None
    assert result.r2 is None


def test_constant_index_has_no_peak() -> None:
    result = fit("cosine", ANGLES, np.full(len(ANGLES), 0.3))
    assert result.parameters["A"].value == 0.0
    assert result.parameters["mu"].value is None
    assert result.values["nu"] == pytest.approx(0.3)


@pytest.mark.parametrize("name", [p.name for p in MODELS["lambert-beckmann"].parameters])
def test_a_fixed_parameter_stays(name: str) -> None:
    values = {"f": 500.0, "k_d": 0.4, "m": 0.3}
    value = print_curve(ANGLES, **values)
    result = fit("lambert-beckmann", ANGLES, value, fixed={name: values[name]})
    assert result.values == pytest.approx(values, rel=1e-9)
    assert result.parameters[name].sd is None
    assert any(f"{name} was held" in w for w in result.warnings)


def test_each_pair_of_parameters_can_be_fixed(model: PhaseModel) -> None:
    values = draw(model, 3)
    value = model.evaluate(ANGLES, values)
    for p in model.parameters[1:]:
        held = {p.name: values[p.name], model.parameters[0].name: values[model.parameters[0].name]}
        if model.name == "cosine" and "mu" not in held:
            with pytest.raises(WrongUse, match="mu"):
                fit(model, ANGLES, value, fixed=held)
            continue
        result = fit(model, ANGLES, value, fixed=held)
        assert result.values == pytest.approx(values, rel=1e-8)


def test_fixed_f_is_never_exceeded() -> None:
    result = fit("lambert-beckmann", ANGLES, 2.0 * np.cos(ANGLES), fixed={"f": 1.0})
    assert result.values["f"] == 1.0
    assert 0.0 <= result.values["k_d"] <= 1.0


def test_index_takes_the_peak_of_another_channel() -> None:
    rng = np.random.default_rng(5)
    angles = to_radians(np.arange(-50.0, 51.0, 5.0))
    index = 0.1 + 0.02 * np.cos(2 * (angles - 0.2)) + 0.05 * rng.normal(size=len(angles))
    result = fit("cosine", angles, index, fixed={"mu": 11.0})
    column = np.cos(2 * (angles - to_radians(11.0)))
    slope, level = np.polyfit(column, index, 1)
    assert result.values == pytest.approx({"A": slope, "mu": 11.0, "nu": level}, rel=1e-10)


@pytest.mark.parametrize(
    ("fixed", "says"), [({"x": 1.0}, "f, k_d, m"), ({"m": 2.0}, "0.001 to 1"), ({"m": np.nan}, "m")]
)
def test_wrong_fixed_parameters_are_refused(fixed: dict[str, float], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        fit("lambert-beckmann", ANGLES, np.cos(ANGLES), fixed=fixed)


def test_useless_pairs_are_counted_and_change_nothing() -> None:
    clean = fit("lambert", ANGLES, np.cos(ANGLES) + 0.01 * ANGLES)
    angle = np.concatenate((ANGLES, [np.nan, 0.1, -0.1, np.pi / 2, 3.0]))
    value = np.concatenate((np.cos(ANGLES) + 0.01 * ANGLES, [1.0, np.inf, 1.0, 1.0, 1.0]))
    dirty = fit("lambert", angle, value)
    assert dirty.values == clean.values
    assert dirty.n == clean.n
    assert any(w.startswith("2 of 39 pairs left out: no finite") for w in dirty.warnings)
    assert any(w.startswith("3 of 39 pairs left out: angle") for w in dirty.warnings)


def test_holder_is_turned_both_ways() -> None:
    angles = to_radians(np.array([-90.0, -50.0, -10.0, 20.0, 90.0, 100.0]))
    assert fit("cosine", angles, np.cos(2 * angles)).n == 5


@pytest.mark.parametrize(
    ("angle", "value", "says"),
    [
        (ANGLES[:3], np.cos(ANGLES[:3]), "needs more pairs"),
        (np.full(9, 0.5), np.ones(9), "equal"),
        (np.tile([0.1, 0.5], 5), np.ones(10), "different angles"),
        (ANGLES, np.ones(3), "as many"),
        (ANGLES, np.full(len(ANGLES), np.nan), "left out"),
    ],
)
def test_hopeless_data_are_refused_in_words(angle: Floats, value: Floats, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        fit("lambert-beckmann", angle, value)


def test_text_and_negative_weights_are_refused() -> None:
    with pytest.raises(BadInput, match="number"):
        fit("lambert", ANGLES, np.full(len(ANGLES), "a"))  # type: ignore[arg-type]
    with pytest.raises(BadInput, match="negative"):
        fit("lambert", ANGLES, np.cos(ANGLES), weights=-np.ones(len(ANGLES)))


def test_interpolants_are_inverted_only_where_they_were_fitted() -> None:
    angles = to_radians(np.arange(0.0, 51.0, 2.0))
    for name, free in (("polynomial-4", False), ("lambert", True)):
        result = fit(name, angles, np.cos(angles))
        beyond = result.inverse(np.cos(to_radians(np.array([30.0, 60.0]))))
        assert beyond[0] == pytest.approx(to_radians(30.0), abs=1e-3)
        assert np.isfinite(beyond[1]) == free


@pytest.mark.parametrize("k_d", [0.4, 1.0])
def test_result_survives_json(k_d: float) -> None:
    result = fit("lambert-beckmann", ANGLES, print_curve(ANGLES, 1.0, k_d, 0.3))
    text = json.dumps(result.as_dict(), allow_nan=False)
    assert FitResult.from_dict(json.loads(text)) == result


@pytest.mark.parametrize(
    "change",
    [{"model": "phong"}, {"n": "many"}, {"parameters": {}}, {"rss": None}, {"angle_range": [1.0]}],
)
def test_broken_stored_fit_is_refused(change: dict[str, object]) -> None:
    plain = fit("lambert", ANGLES, np.cos(ANGLES)).as_dict()
    with pytest.raises(BadInput, match="stored fit"):
        FitResult.from_dict(plain | change)
