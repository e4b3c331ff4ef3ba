"""Intervals hold what they promise; criteria and the bootstrap are what they are called."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import t as student

from app.core.errors import BadInput, WrongUse
from app.core.fitting import fit, fit_many
from app.core.fitting.bootstrap import bootstrap_leaves
from app.core.fitting.profile import profile_intervals
from app.core.fitting.robust import fit_robust
from app.core.fitting.selection import compare_models
from app.core.phase import MODELS
from app.core.units import to_radians

STEPS = to_radians(np.arange(0.0, 81.0, 5.0))
BECKMANN = MODELS["lambert-beckmann"]
PRINTED = [
    r.values for r in BECKMANN.references if "Kaasalainen" in r.source and r.values["k_d"] < 1
]


@pytest.mark.parametrize("kind", ["plain", "within bounds"])
def test_intervals_of_the_printed_leaves_cover(kind: str) -> None:
    hits = []
    for place, printed in enumerate(PRINTED):
        values = {"f": 1.0, **printed}
        noise = 0.0035 * np.random.default_rng([place, 1]).standard_normal((120, len(STEPS)))
        batch = fit_many(BECKMANN, STEPS, BECKMANN.evaluate(STEPS, values) + noise)
        ends, true = batch.intervals(kind=kind), np.array(list(values.values()))  # type: ignore[arg-type]
        hits.append((ends[..., 0] <= true) & (true <= ends[..., 1]))
    assert 0.94 <= np.mean(hits) <= 0.96
    assert len(PRINTED) == 42


def test_interval_is_value_and_student() -> None:
    value = np.cos(STEPS) + 0.05 * np.random.default_rng(0).standard_normal(17)
    result = fit("lambert", STEPS, value)
    f = result.parameters["f"]
    reach = student.ppf(0.975, 16) * f.sd
    assert result.interval("f") == pytest.approx((f.value - reach, f.value + reach))
    low, high = result.interval("f", kind="within bounds")
    assert low * high == pytest.approx(f.value**2)
    batch = fit_many("lambert", STEPS, value[None])
    assert batch.intervals()[0, 0] == pytest.approx(result.interval("f"))


def test_within_bounds_never_leaves_them() -> None:
    value = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.97, "m": 0.3})
    rng = np.random.default_rng(1)
    batch = fit_many(BECKMANN, STEPS, value + 0.03 * rng.standard_normal((200, 17)))
    ends = batch.intervals(kind="within bounds")[:, 1]
    known = np.isfinite(ends).all(axis=1)
    assert known.sum() > 50
    assert (ends[known] > 0).all()
    assert (ends[known] < 1).all()


def test_covariance_is_stored_and_agrees_with_the_batch() -> None:
    value = BECKMANN.evaluate(STEPS, {"f": 5.0, "k_d": 0.5, "m": 0.3})
    value = value + 0.05 * np.random.default_rng(2).standard_normal(17)
    result = fit(BECKMANN, STEPS, value)
    names = list(result.parameters)
    matrix = np.array([[result.covariance[a][b] for b in names] for a in names])
    sd = [e.sd for e in result.parameters.values()]
    assert np.sqrt(np.diag(matrix)) == pytest.approx(sd)
    batch = fit_many(BECKMANN, STEPS, value[None])
    np.testing.assert_allclose(batch.covariance[0], matrix, rtol=1e-6)


def test_old_stored_fits_still_load() -> None:
    plain = fit("lambert", STEPS, np.cos(STEPS)).as_dict()
    new = ("covariance", "kind", "tau", "scale", "formula")
    old = {key: value for key, value in plain.items() if key not in new}
    for estimate in old["parameters"].values():
        del estimate["fixed"]
    result = type(fit("lambert", STEPS, np.cos(STEPS))).from_dict(old)
    assert result.kind == "points"
    assert result.covariance == {}


def test_profile_of_a_line_is_the_plain_interval() -> None:
    value = np.cos(STEPS) * 40 + np.random.default_rng(3).standard_normal(17)
    result = fit("lommel-seeliger", STEPS, value)
    profile = profile_intervals("lommel-seeliger", STEPS, value)
    for name in ("c", "d"):
        low, high = result.interval(name)
        assert (profile[name].low, profile[name].high) == pytest.approx((low, high), rel=1e-6)
        assert not profile[name].low_open


def test_profile_is_where_the_sum_of_squares_says() -> None:
    value = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.8, "m": 0.3})
    value = value + 0.03 * np.random.default_rng(4).standard_normal(17)
    best = fit(BECKMANN, STEPS, value)
    limit = best.rss * (1 + student.ppf(0.975, 14) ** 2 / 14)
    m = best.values["m"]

    def excess(trial: float) -> float:
        return fit(BECKMANN, STEPS, value, fixed={"m": trial}).rss - limit

    profile = profile_intervals(BECKMANN, STEPS, value)["m"]
    assert profile.low == pytest.approx(brentq(excess, 0.05, m), rel=1e-6)
    assert profile.high == pytest.approx(brentq(excess, m, 0.99), rel=1e-6)


def test_profile_is_open_at_a_bound_that_the_pairs_allow() -> None:
    noise = 0.01 * np.random.default_rng(0).standard_normal((20, 17))
    at_bound = fit_many(BECKMANN, STEPS, np.cos(STEPS) + noise).at_bound[:, 1]
    value = np.cos(STEPS) + noise[np.argmax(at_bound)]
    best = fit(BECKMANN, STEPS, value)
    profile = profile_intervals(BECKMANN, STEPS, value)
    assert best.parameters["k_d"].at_bound
    assert profile["k_d"].high == 1.0
    assert profile["k_d"].high_open
    assert 0.8 < profile["k_d"].low < 1.0
    assert profile["m"].low_open


def test_profile_of_an_amplitude_follows_its_angle() -> None:
    angle = to_radians(np.arange(-50.0, 51.0, 5.0))
    cosine = MODELS["cosine"]
    value = cosine.evaluate(angle, {"A": 0.2, "mu": 10.0, "nu": 0.3})
    value = value + 0.01 * np.random.default_rng(5).standard_normal(len(angle))
    profile = profile_intervals(cosine, angle, value)["A"]
    low, high = fit(cosine, angle, value).interval("A")
    assert (profile.low, profile.high) == pytest.approx((low, high), rel=0.02)


def test_profile_of_many_pairs_is_that_of_all_of_them() -> None:
    rng = np.random.default_rng(6)
    angle = rng.uniform(0, 1.4, 5000)
    value = BECKMANN.evaluate(angle, {"f": 1.0, "k_d": 0.5, "m": 0.3}) + 0.1 * rng.normal(size=5000)
    low, high = fit(BECKMANN, angle, value).interval("m")
    profile = profile_intervals(BECKMANN, angle, value)["m"]
    assert (profile.low, profile.high) == pytest.approx((low, high), rel=2e-3)


def make_leaves(leaves: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Leaves that differ by 10 % in brightness, each with 17 exact steps."""
    rng = np.random.default_rng(seed)
    bright = 1 + 0.1 * rng.standard_normal(leaves)
    angle, leaf = np.tile(STEPS, leaves), np.repeat(np.arange(leaves), len(STEPS))
    return angle, np.cos(angle) * bright[leaf], leaf


def test_bootstrap_is_reproducible_and_knows_that_leaves_differ() -> None:
    angle, value, leaf = make_leaves(25)
    one, again, other = (
        bootstrap_leaves("lambert", angle, value, leaf, count=400, seed=s) for s in (1, 1, 2)
    )
    np.testing.assert_array_equal(one.values, again.values)
    assert (one.values != other.values).any()
    # The mean of 25 leaves that differ by 10 %, whatever the number of points.
    assert one.values.std() == pytest.approx(0.1 / np.sqrt(25), rel=0.3)
    low, high = one.interval("f")
    assert low < fit("lambert", angle, value).values["f"] < high


def test_bootstrap_trial_is_the_fit_of_its_leaves() -> None:
    angle, value, leaf = make_leaves(4)
    trial = bootstrap_leaves(BECKMANN, angle, value + 0.01 * angle, leaf, count=3, seed=7)
    times = np.random.default_rng(7).multinomial(4, np.full(4, 0.25), size=3)
    for row, drawn in zip(trial.values, times, strict=True):
        weights = drawn[leaf].astype(float)
        single = fit(BECKMANN, angle, value + 0.01 * angle, weights=weights)
        assert row == pytest.approx(list(single.values.values()), rel=1e-6, nan_ok=True)
    assert any("Only 4 leaves" in word for word in trial.warnings)


def test_bootstrap_says_when_a_parameter_is_not_told() -> None:
    angle, value, leaf = make_leaves(6)
    trial = bootstrap_leaves(BECKMANN, angle, value, leaf, count=50)
    assert trial.known("m") < 0.5
    assert trial.interval("m") is None


def test_hopeless_bootstraps_are_refused() -> None:
    angle, value, leaf = make_leaves(2)
    with pytest.raises(BadInput, match="two leaves"):
        bootstrap_leaves("lambert", angle, value, np.zeros(len(angle)))
    with pytest.raises(BadInput, match="leaf of each"):
        bootstrap_leaves("lambert", angle, value, leaf[:5])
    with pytest.raises(WrongUse, match="trials"):
        bootstrap_leaves("lambert", angle, value, leaf, count=0)


def test_criteria_are_the_printed_formulas() -> None:
    value = np.cos(STEPS) + 0.05 * np.random.default_rng(8).standard_normal(17)
    result = fit("lommel-seeliger", STEPS, value)
    rss, n, k = result.rss, 17, 3
    assert result.aic == pytest.approx(n * np.log(rss / n) + 2 * k)
    assert result.aicc == pytest.approx(n * np.log(rss / n) + 2 * k + 2 * k * 4 / 13)
    assert result.bic == pytest.approx(n * np.log(rss / n) + k * np.log(n))
    held = fit("lommel-seeliger", STEPS, value, fixed={"d": 0.0})
    assert held.spare == 16


def test_models_side_by_side() -> None:
    rng = np.random.default_rng(9)
    value = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.5, "m": 0.2}) + 0.01 * rng.normal(size=17)
    angle = np.append(STEPS, -0.2)
    found = {c.model: c for c in compare_models(list(MODELS), angle, np.append(value, 0.9))}
    assert found["lambert-beckmann"].aicc_above == 0.0
    assert found["lambert"].bic_above > 10
    assert sum(c.weight for c in found.values()) == pytest.approx(1.0)
    # The cosine takes negative angles, the others do not: all get the same pairs.
    assert {c.result.n for c in found.values()} == {17}
    few = {c.model: c for c in compare_models(list(MODELS), STEPS[:4], value[:4])}
    assert few["fourier-2"].result is None
    assert "more pairs" in few["fourier-2"].words[0]


@pytest.mark.parametrize("m", [1e-3, 1e-2, 0.3])
def test_a_peak_that_may_be_as_sharp_as_one_likes_is_said_to_be(m: float) -> None:
    value = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.4, "m": m})
    result = fit(BECKMANN, STEPS, value + 1e-3 * np.random.default_rng(2).standard_normal(17))
    said = any(sentence.startswith("m is not limited from below") for sentence in result.warnings)
    assert said == (m < 0.02)
    interval = profile_intervals(BECKMANN, STEPS, value)["m"] if m == 0.3 else None
    assert interval is None or not interval.low_open


def test_a_rough_leaf_may_be_rougher_than_the_model_goes() -> None:
    value = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.9, "m": 0.9})
    words = [
        fit(
            BECKMANN, STEPS, value + 0.02 * np.random.default_rng(seed).standard_normal(17)
        ).warnings
        for seed in range(20)
    ]
    assert any("m is not limited from above" in " ".join(sentences) for sentences in words)


def test_an_interval_ends_at_the_bound() -> None:
    value = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.95, "m": 0.3})
    noise = 0.05 * np.random.default_rng(3).standard_normal((50, 17))
    ends = fit_many(BECKMANN, STEPS, value + noise).intervals()[:, 1]
    assert np.nanmax(ends) == 1.0
    assert np.nanmin(ends) >= 0.0


def test_deviations_that_hold_a_parameter_at_its_bound_say_so() -> None:
    noise = 0.01 * np.random.default_rng(0).standard_normal((20, 17))
    at_bound = fit_many(BECKMANN, STEPS, np.cos(STEPS) + noise).at_bound[:, 1]
    value = np.cos(STEPS) + noise[np.argmax(at_bound)]
    said = "The standard deviation of f takes k_d and m as known: ask for profile intervals."
    assert fit(BECKMANN, STEPS, value).warnings.count(said) == 1
    rough = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.4, "m": 1.0}) + 0.05 * np.sin(STEPS)
    result = fit(BECKMANN, STEPS, rough)
    assert result.parameters["m"].at_bound
    assert any(
        word.startswith("The standard deviations of f and k_d take m as known")
        for word in result.warnings
    )
    inside = BECKMANN.evaluate(STEPS, {"f": 1.0, "k_d": 0.5, "m": 0.3}) + noise[0]
    others = (fit(BECKMANN, STEPS, inside), fit_robust(BECKMANN, STEPS, value))
    assert not any("as known" in word for result in others for word in result.warnings)


@pytest.mark.parametrize(
    ("value", "best"),
    [(np.cos(STEPS), "lambert"), (np.full(17, 3.0), "incidence-b"), (np.zeros(17), "lambert")],
)
def test_the_simplest_exact_model_is_best(value: np.ndarray, best: str) -> None:
    rows = {c.model: c for c in compare_models(list(MODELS), STEPS, value)}
    assert [name for name, row in rows.items() if row.best] == [best]
    assert rows[best].exact
    assert all(row.weight is None and row.aicc_above is None for row in rows.values())
    assert rows["fourier-2"].exact == (best != "lambert" or not value.any())


def test_equally_simple_exact_models_are_not_ranked() -> None:
    value = MODELS["cosine"].evaluate(STEPS, {"A": 0.2, "mu": 10.0, "nu": 0.3})
    rows = compare_models(["cosine", "lambert", "cosine"], STEPS, value)
    assert [row.exact for row in rows] == [True, False, True]
    assert not any(row.best for row in rows)


def test_few_pairs_do_not_make_the_rest_win() -> None:
    value = np.cos(STEPS) + 0.05 * np.random.default_rng(0).standard_normal(17)
    for count, crowded in ((8, {"fourier-2"}), (7, {"fourier-2", "polynomial-4"}), (9, set())):
        rows = compare_models(list(MODELS), STEPS[:count], value[:count])
        assert {row.model for row in rows if row.crowded} == crowded
        for row in rows:
            assert (row.weight is None) == bool(crowded)
            assert row.bic_above is not None
        assert sum(row.best for row in rows) == (not crowded)
