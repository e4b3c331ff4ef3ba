"""Fits to bins, to edges, and robust ones, each against an independent computation."""

from __future__ import annotations

import itertools
from functools import partial

import numpy as np
import pytest

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.fitting import FitResult, fit
from app.core.fitting.bins import average_bins, fit_bins
from app.core.fitting.edge import fit_edge
from app.core.fitting.linear_quantile import measure_pinball, solve_quantile
from app.core.fitting.robust import TUNING, fit_robust
from app.core.fitting.trust_region import fit_trust_region
from app.core.phase import MODELS
from app.core.phase.model import Freedom
from app.core.units import to_degrees, to_radians

BECKMANN = MODELS["lambert-beckmann"]
TRUE = {"f": 640.0, "k_d": 0.5, "m": 0.3}


def make_cloud(count: int, seed: int, noise: float = 0.1) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 1.4, count)
    return angle, BECKMANN.evaluate(angle, TRUE) * (1 + noise * rng.standard_normal(count))


def test_bins_are_means_with_the_stated_errors() -> None:
    angle = to_radians(np.array([0.0, 1.0, 4.9, 5.0, 9.0, 30.0]))
    value = np.array([10.0, 11.0, 12.0, 7.0, 7.0, 3.0])
    means = average_bins("lambert", angle, value)
    assert to_degrees(means.angle) == pytest.approx([5.9 / 3, 7.0, 30.0])
    assert means.value == pytest.approx([11.0, 7.0, 3.0])
    pooled = 2.0 / 3.0
    expected = [(4 * pooled + 2) / 6 / 3, 4 * pooled / 5 / 2, pooled]
    assert means.error**2 == pytest.approx(expected)
    assert means.count.tolist() == [3, 2, 1]
    assert any("1 of 3 bins hold one pair" in word for word in means.warnings)


def test_a_fit_to_bins_is_the_weighted_fit_to_their_means() -> None:
    angle, value = make_cloud(3000, 1)
    means = average_bins(BECKMANN, angle, value)
    expected = fit(BECKMANN, means.angle, means.value, weights=means.error**-2.0)
    found = fit_bins(BECKMANN, angle, value)
    assert found.values == expected.values
    assert found.kind == "bins"
    assert any("5° bins" in word for word in found.warnings)
    assert found.values == pytest.approx(TRUE, rel=0.05)


def test_bins_of_set_angles_keep_them() -> None:
    angle = to_radians(np.repeat(np.arange(0.0, 81.0, 5.0), 3))
    means = average_bins("lambert", angle, np.tile([0.9, 1.0, 1.1], 17))
    assert to_degrees(means.angle) == pytest.approx(np.arange(0.0, 81.0, 5.0), abs=1e-12)
    assert means.value == pytest.approx(np.ones(17))


def test_bins_without_scatter_weigh_alike_and_one_bin_is_refused() -> None:
    steps = to_radians(np.arange(0.0, 81.0, 5.0))
    result = fit_bins("lambert", steps, np.cos(steps))
    assert result.values["f"] == pytest.approx(1.0)
    assert any("weigh alike" in word for word in result.warnings)
    with pytest.raises(BadInput, match="more pairs"):
        fit_bins("lambert", np.linspace(0.01, 0.05, 30), np.ones(30))
    with pytest.raises(WrongUse, match="width"):
        fit_bins("lambert", steps, steps, width=0.0)


def search_brute(angle: Floats, value: Floats, tau: float) -> float:
    """Least pinball loss of Lambert–Beckmann over many shapes and all curves through two pairs."""
    best = np.inf
    for m in np.geomspace(0.02, 1.0, 400):
        columns = np.array(BECKMANN.basis(angle, m))
        candidates = [np.zeros(2)]
        for i, j in itertools.combinations(range(len(angle)), 2):
            pair = columns[:, [i, j]].T
            if abs(np.linalg.det(pair)) > 1e-12:
                candidates.append(np.linalg.solve(pair, value[[i, j]]))
        for i, k in itertools.product(range(len(angle)), range(2)):
            one = np.zeros(2)
            one[k] = value[i] / columns[k, i] if columns[k, i] > 1e-12 else 0.0
            candidates.append(one)
        trial = np.array([c for c in candidates if (c >= -1e-15).all()])
        miss = value - trial @ columns
        best = min(best, np.where(miss >= 0, tau * miss, (tau - 1) * miss).sum(axis=1).min())
    return float(best)


@pytest.mark.parametrize(("seed", "tau"), [(1, 0.5), (2, 0.9), (3, 0.8), (4, 0.3)])
def test_no_edge_is_better(seed: int, tau: float) -> None:
    angle, value = make_cloud(14, seed, 0.2)
    result = fit_edge(BECKMANN, angle, value, tau=tau)
    loss = measure_pinball(value - result.evaluate(angle), tau)
    assert loss <= search_brute(angle, value, tau) * (1 + 1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_linear_quantiles_are_exact(seed: int) -> None:
    """Against all lines through two of the pairs: the optimum is one of them."""
    rng = np.random.default_rng(seed)
    columns, target = rng.normal(size=(2, 18)), rng.normal(size=18)
    endless = np.full(2, np.inf)
    freedom = Freedom(np.zeros(2), np.eye(2), -endless, endless)
    found = solve_quantile(columns, target, freedom, 0.7)
    lines = [
        np.linalg.solve(columns[:, pair].T, target[pair])
        for pair in map(list, itertools.combinations(range(18), 2))
    ]
    best = min(measure_pinball(target - line @ columns, 0.7) for line in lines)
    assert measure_pinball(target - found @ columns, 0.7) == pytest.approx(best, rel=1e-9)


@pytest.mark.parametrize("upper", [np.inf, 0.4])
def test_a_good_guess_changes_no_quantile(upper: float) -> None:
    rng = np.random.default_rng(5)
    columns = rng.uniform(0, 1, (2, 6000))
    target = 0.5 * columns[0] + 0.3 * columns[1] + 0.1 * rng.standard_normal(6000)
    freedom = Freedom(np.zeros(2), np.eye(2), np.zeros(2), np.full(2, upper))
    losses = [
        measure_pinball(
            target - solve_quantile(columns, target, freedom, 0.9, guess) @ columns, 0.9
        )
        for guess in (None, np.array([0.5, 0.4]), np.array([5.0, 5.0]))
    ]
    assert losses[1:] == pytest.approx(losses[:1] * 2, rel=1e-12)


def test_the_edge_has_its_share_below_and_knows_its_error() -> None:
    found = []
    for seed in range(10):
        angle, value = make_cloud(1500, seed)
        result = fit_edge(BECKMANN, angle, value, tau=0.9)
        assert np.mean(value < result.evaluate(angle)) == pytest.approx(0.9, abs=0.01)
        found.append([(result.values[n], result.parameters[n].sd) for n in ("f", "k_d", "m")])
    values, sd = np.moveaxis(np.array(found), -1, 0)
    edge = 640 * (1 + 0.1 * 1.2816)
    assert values.mean(axis=0) == pytest.approx([edge, 0.5, 0.3], rel=0.02)
    assert values.std(axis=0, ddof=1) == pytest.approx(sd.mean(axis=0), rel=0.6)
    assert result.tau == 0.9
    assert result.kind == "edge"


def test_edges_of_the_other_models_and_impossible_ones() -> None:
    angle, value = make_cloud(400, 6)
    for name in MODELS:
        model, result = MODELS[name], fit_edge(name, angle, value, tau=0.8)
        least = measure_pinball(value - result.evaluate(angle), 0.8)
        for p in model.parameters:
            for factor in (0.999, 1.001):
                moved = result.values | {p.name: result.values[p.name] * factor}
                loss = measure_pinball(value - model.evaluate(angle, moved), 0.8)
                assert loss >= least * (1 - 1e-9)
    held = fit_edge(BECKMANN, angle, value, tau=0.8, fixed={"k_d": 0.5})
    assert held.values["k_d"] == 0.5
    with pytest.raises(WrongUse, match="between 0 and 1"):
        fit_edge("lambert", angle, value, tau=1.0)


@pytest.mark.parametrize("loss", ["huber", "tukey"])
def test_outliers_do_not_carry_the_curve_away(loss: str) -> None:
    angle, value = make_cloud(400, 7, 0.03)
    spoilt = value.copy()
    spoilt[np.random.default_rng(70).random(400) < 0.2] *= 4.0
    clean = fit(BECKMANN, angle, value).values
    robust = fit_robust(BECKMANN, angle, spoilt, loss=loss).values  # type: ignore[arg-type]
    plain = fit(BECKMANN, angle, spoilt).values
    assert robust["f"] == pytest.approx(clean["f"], rel=0.05)
    assert abs(plain["f"] / clean["f"] - 1) > 0.3


@pytest.mark.parametrize("loss", ["huber", "tukey"])
def test_robust_fits_do_not_know_the_order(loss: str) -> None:
    angle, value = make_cloud(150, 8, 0.2)
    order = np.random.default_rng(9).permutation(150)
    one = fit_robust(BECKMANN, angle, value, loss=loss)  # type: ignore[arg-type]
    other = fit_robust(BECKMANN, angle[order], value[order], loss=loss)  # type: ignore[arg-type]
    assert one.values == other.values


def test_huber_rests_where_its_loss_is_least() -> None:
    from scipy.optimize import least_squares

    angle, value = make_cloud(200, 10, 0.2)
    result = fit_robust(BECKMANN, angle, value)
    edge = TUNING["huber"] * result.scale

    def miss(p: Floats) -> Floats:
        return value - BECKMANN.evaluate(angle, dict(zip(TRUE, p, strict=True)))

    start = list(result.values.values())
    bounds = ([0, 0, 1e-3], [np.inf, 1, 1])
    other = least_squares(miss, start, loss="huber", f_scale=edge, bounds=bounds, x_scale="jac")

    def measure(r: Floats) -> float:
        far = np.abs(r)
        return float(np.where(far <= edge, far**2 / 2, edge * (far - edge / 2)).sum())

    assert measure(miss(np.array(start))) <= measure(other.fun) * (1 + 1e-7)


def test_robust_errors_are_those_of_many_samples() -> None:
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        angle = rng.uniform(0, 1.4, 200)
        result = fit_robust(
            "lommel-seeliger", angle, np.cos(angle) + 0.1 * rng.standard_normal(200)
        )
        found.append([(result.values[n], result.parameters[n].sd) for n in "cd"])
    values, sd = np.moveaxis(np.array(found), -1, 0)
    assert values.std(axis=0, ddof=1) == pytest.approx(sd.mean(axis=0), rel=0.3)


def test_most_pairs_on_a_curve_are_the_curve() -> None:
    angle = np.linspace(0.0, 1.3, 60)
    value = np.cos(angle)
    value[::7] = 3.0
    result = fit_robust("lambert", angle, value)
    assert result.values["f"] == pytest.approx(1.0, abs=1e-9)
    assert any("More than half" in word for word in result.warnings)
    with pytest.raises(WrongUse, match="huber, tukey"):
        fit_robust("lambert", angle, value, loss="cauchy")  # type: ignore[arg-type]


@pytest.mark.parametrize("name", list(MODELS))
def test_the_second_opinion_agrees(name: str) -> None:
    model = MODELS[name]
    angle = to_radians(np.arange(0.0, 81.0, 4.0))
    for seed in range(4):
        rng = np.random.default_rng(seed)
        value = model.evaluate(angle, model.random(rng, 250.0))
        value = value + 2.5 * rng.standard_normal(len(angle))
        ours = fit(model, angle, value)
        theirs = fit_trust_region(model, angle, value, start=ours.values)
        assert ours.rss <= theirs.rss * (1 + 1e-9)
        assert theirs.rss <= ours.rss * (1 + 1e-6)
        assert theirs.kind == "trust region"


@pytest.mark.parametrize("make", [fit_edge, fit_robust, fit_bins])
def test_kinds_survive_json(make) -> None:
    angle, value = make_cloud(300, 11)
    result = make(BECKMANN, angle, value)
    assert FitResult.from_dict(result.as_dict()) == result


def make_clusters(seed: int) -> tuple[Floats, Floats]:
    """Points of six leaves that differ in brightness, without a peak."""
    rng = np.random.default_rng(seed)
    angle = to_radians(rng.uniform(0, 75, 480))
    bright = rng.choice(rng.normal(1, 0.05, 6), 480)
    return angle, 5 * np.cos(angle) * bright + rng.normal(0, 0.15, 480)


def test_a_solver_in_doubt_is_not_the_last_word(monkeypatch: pytest.MonkeyPatch) -> None:
    """The simplex gives up at every third programme; the edge must stay the same."""
    import scipy.optimize

    angle, value = make_clusters(1)
    expected = fit_edge(BECKMANN, angle, value, tau=0.9)
    solver, calls = scipy.optimize.linprog, itertools.count()

    def doubt(*args, method, **more):
        found = solver(*args, method=method, **more)
        if method == "highs-ds" and next(calls) % 3 == 0:
            found.status = 4
        return found

    monkeypatch.setattr(scipy.optimize, "linprog", doubt)
    found = fit_edge(BECKMANN, angle, value, tau=0.9)
    losses = [measure_pinball(value - r.evaluate(angle), 0.9) for r in (found, expected)]
    assert losses[0] == pytest.approx(losses[1], rel=1e-6)
    assert next(calls) > 50


def test_a_trial_shape_without_an_answer_does_not_end_the_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from app.core.fitting import edge

    angle, value = make_cloud(300, 2)
    expected = fit_edge(BECKMANN, angle, value, tau=0.9).values
    calls = itertools.count()

    def fail(*args):
        if next(calls) < failures:
            raise BadInput("The linear programme has no answer.")
        return solve_quantile(*args)

    monkeypatch.setattr(edge, "solve_quantile", fail)
    failures = 5
    assert fit_edge(BECKMANN, angle, value, tau=0.9).values == pytest.approx(expected, rel=1e-4)
    calls, failures = itertools.count(), 10_000
    with pytest.raises(BadInput, match="any trial shape"):
        fit_edge(BECKMANN, angle, value, tau=0.9)


@pytest.mark.parametrize("seed", range(3))
def test_edges_of_clusters_are_best_among_all_shapes(seed: int) -> None:
    """Against the primal programme, solved by another method, at many shapes."""
    from scipy.optimize import linprog

    angle, value = make_clusters(seed)
    result = fit_edge(BECKMANN, angle, value, tau=0.95)
    count = len(angle)
    sides = np.hstack((np.eye(count), -np.eye(count)))
    cost = np.concatenate(([0.0, 0.0], np.full(count, 0.95), np.full(count, 0.05)))
    for m in np.geomspace(0.01, 1.0, 8):
        rows = np.hstack((np.array(BECKMANN.basis(angle, m)).T, sides))
        best = linprog(cost, A_eq=rows, b_eq=value, method="highs-ipm")
        assert best.status == 0
        assert measure_pinball(value - result.evaluate(angle), 0.95) <= best.fun * (1 + 1e-6)


SPIKES = {
    "zeros": np.zeros(68),
    "constant": np.full(68, 3.0),
    "below zero": np.full(68, -3.0),
    "one": np.eye(68)[17],
    "first": np.eye(68)[0],
    "last below zero": -5.0 * np.eye(68)[67],
}


@pytest.mark.parametrize("values", SPIKES.values(), ids=SPIKES.keys())
@pytest.mark.parametrize("name", list(MODELS))
@pytest.mark.parametrize(
    "make",
    [fit, fit_bins, fit_edge, fit_robust, partial(fit_robust, loss="tukey"), fit_trust_region],
    ids=["fit", "bins", "edge", "huber", "tukey", "trust region"],
)
def test_values_that_say_little_are_fitted_in_words(make, name: str, values: Floats) -> None:
    angle = to_radians(np.repeat(np.arange(0.0, 81.0, 5.0), 4))
    result = make(name, angle, values)
    assert np.isfinite(result.rss)
    for p, estimate in result.parameters.items():
        undetermined = any(word.startswith(f"{p} is undetermined: ") for word in result.warnings)
        assert undetermined == (estimate.value is None)
