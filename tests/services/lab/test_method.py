"""Fits by every method: against SciPy, against known curves, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import curve_fit

from app.core.errors import BadInput, WrongUse
from app.core.phase import MODELS, get_model
from app.core.phase.formula_model import FormulaDefinition, FormulaParameter
from app.model.fit_method import WHOLE_SCAN, Method, usual_method
from app.services.lab.batch import fit_sets
from app.services.lab.bins import average
from app.services.lab.method import describe_method, fit_by

TRUTH = {"f": 0.6, "k_d": 0.7, "m": 0.28}
BECKMANN = get_model("lambert-beckmann")
LINE = FormulaDefinition(
    "falling", "a*(1 - s*omega)",
    (FormulaParameter("a", (0.1, 2.0), 0.0, None, scales=True),
     FormulaParameter("s", (0.0, 0.6), 0.0, 2.0)),
)  # fmt: skip


def draw(count: int = 900, noise: float = 0.03, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    angle = generator.uniform(0.0, 78.0, count)
    value = BECKMANN.evaluate(np.deg2rad(angle), TRUTH)
    return angle, value * (1.0 + noise * generator.standard_normal(count))


def formula(angle: np.ndarray, f: float, k_d: float, m: float) -> np.ndarray:
    t = np.tan(angle) ** 2
    return f * (k_d * np.cos(angle) + (1 - k_d) * np.exp(-t / m**2) / np.cos(angle) ** 5)


def test_points_are_fitted_as_scipy_does() -> None:
    angle, value = draw()
    found = fit_by(Method(), "lambert-beckmann", angle, value)
    expected, covariance = curve_fit(
        formula, np.deg2rad(angle), value, [0.6, 0.7, 0.28], bounds=([0, 0, 1e-3], [9, 1, 1])
    )
    assert list(found.values.values()) == pytest.approx(expected, rel=1e-5)
    sd = [found.parameters[name].sd for name in TRUTH]
    assert sd == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-2)


def test_means_are_fitted_as_scipy_does() -> None:
    angle, value = draw()
    found = fit_by(Method("bins", width=4.0), "lambert-beckmann", angle, value)
    bins = average(angle, value, 4.0)
    expected, _ = curve_fit(
        formula, np.deg2rad(bins.angle), bins.value, [0.6, 0.7, 0.28], sigma=bins.error,
        bounds=([0, 0, 1e-3], [9, 1, 1]),
    )  # fmt: skip
    assert found.kind == "bins"
    assert found.n == len(bins.angle) == 20
    assert list(found.values.values()) == pytest.approx(expected, rel=1e-4)


def test_bins_are_means_with_their_scatter() -> None:
    angle = np.repeat([2.0, 7.0], 50)
    value = np.tile([1.0, 3.0], 50)
    bins = average(angle, value)
    assert bins.angle == pytest.approx([2.0, 7.0])
    assert bins.value == pytest.approx([2.0, 2.0])
    assert bins.sd == pytest.approx([1.0, 1.0], rel=0.02)
    assert bins.error == pytest.approx(bins.sd / np.sqrt(50))


def test_the_edge_has_the_share_below_it() -> None:
    angle, value = draw(2000)
    found = fit_by(Method("edge", tau=0.9), "lambert-beckmann", angle, value)
    below = value <= found.evaluate(np.deg2rad(angle))
    assert below.mean() == pytest.approx(0.9, abs=0.005)
    assert (found.kind, found.tau) == ("edge", 0.9)


@pytest.mark.parametrize("loss", ["huber", "tukey"])
def test_robust_losses_forget_outliers(loss: str) -> None:
    angle, value = draw(noise=0.01)
    value[::9] *= 3.0
    found = fit_by(Method(loss=loss), "lambert-beckmann", angle, value)  # type: ignore[arg-type]
    plain = fit_by(Method(), "lambert-beckmann", angle, value)
    assert found.values["f"] == pytest.approx(TRUTH["f"], rel=0.02)
    assert abs(plain.values["f"] - TRUTH["f"]) > 0.05
    assert found.kind == loss


def test_angles_are_a_choice_and_are_told() -> None:
    angle, value = draw()
    found = fit_by(Method(angles=(10.0, 50.0)), "lambert", angle, value)
    low, high = np.rad2deg(found.angle_range)
    assert 10.0 <= low < high < 50.0
    outside = int(((angle < 10) | (angle >= 50)).sum())
    assert f"{outside} of 900 pairs left out: angle outside 10° to 50°." in found.warnings


def test_a_whole_scan_is_fitted_by_means_below_80_degrees() -> None:
    assert usual_method(()) == WHOLE_SCAN == Method("bins", angles=(0.0, 80.0))
    assert usual_method(("leaf-00001",)) == Method()
    angle, value = draw()
    angle[:9] = 85.0
    assert fit_by(WHOLE_SCAN, "lambert", angle, value).angle_range[1] < np.deg2rad(80.0)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"tau": 0.0}, "between 0 and 1"),
        ({"tau": 1.5}, "between 0 and 1"),
        ({"tau": float("nan")}, "between 0 and 1"),
        ({"width": 0.0}, "wider than 0"),
        ({"width": float("nan")}, "wider than 0"),
        ({"angles": (50.0, 10.0)}, "rise within"),
        ({"angles": (0.0, 95.0)}, "rise within"),
        ({"to": "bins", "loss": "huber"}, "single points"),
    ],
)
def test_impossible_methods_are_refused_in_words(wrong: dict[str, object], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        Method(**wrong)  # type: ignore[arg-type]


def test_what_cannot_be_fitted_is_refused_in_words() -> None:
    angle, value = draw(40)
    with pytest.raises(BadInput, match="equal"):
        fit_by(Method(), "lambert", np.full(40, 20.0), value)
    with pytest.raises(BadInput, match="needs more pairs"):
        fit_by(Method("bins"), "lambert-beckmann", np.full(40, 21.0), value)
    with pytest.raises(BadInput, match="there are 0"):
        fit_by(Method(), "lambert", np.full(40, np.nan), value)
    with pytest.raises(BadInput, match="there are 0"):
        fit_by(Method("bins"), "lambert", np.empty(0), np.empty(0))
    for method in (Method("edge"), Method(loss="huber")):
        with pytest.raises(WrongUse, match="least squares only"):
            fit_by(method, LINE, angle, value)
    with pytest.raises(WrongUse, match="no model 'phong'"):
        fit_by(Method(), "phong", angle, value)


def test_a_formula_is_fitted_to_points_and_to_means() -> None:
    generator = np.random.default_rng(2)
    angle = generator.uniform(0.0, 70.0, 300)
    value = 40.0 * (1.0 - 0.4 * np.deg2rad(angle)) + 0.1 * generator.standard_normal(300)
    for method in (Method(), Method("bins")):
        found = fit_by(method, LINE, angle, value)
        assert found.values == pytest.approx({"a": 40.0, "s": 0.4}, rel=0.01)
        assert found.formula == LINE


@pytest.mark.parametrize("method", [Method(), Method("bins"), Method(angles=(5.0, 60.0))])
@pytest.mark.parametrize("model", list(MODELS))
def test_a_batch_gives_what_fits_one_by_one_give(method: Method, model: str) -> None:
    sets = [draw(120 + 30 * seed, seed=seed) for seed in range(4)]
    sets.append((np.full(9, 3.0), np.ones(9)))
    found = fit_sets(sets, model, method)
    assert isinstance(found[-1], BadInput)
    for pairs, one in zip(sets[:-1], found, strict=False):
        alone = fit_by(method, model, *pairs)
        assert not isinstance(one, BadInput)
        assert (one.kind, one.n, one.warnings) == (alone.kind, alone.n, alone.warnings)
        assert one.values == pytest.approx(alone.values, rel=1e-6, nan_ok=True)
        assert one.rss == pytest.approx(alone.rss, rel=1e-9)


@pytest.mark.parametrize("method", [Method("edge"), Method(loss="tukey")])
def test_other_methods_are_fitted_side_by_side(method: Method) -> None:
    sets = [draw(150, seed=seed) for seed in range(3)]
    found = fit_sets(sets, "lambert-beckmann", method)
    for pairs, one in zip(sets, found, strict=True):
        assert one == fit_by(method, "lambert-beckmann", *pairs)


def test_methods_in_words() -> None:
    assert describe_method(Method()) == "single points"
    assert describe_method(WHOLE_SCAN) == "means per 5° step, 0° to 80°"
    assert describe_method(Method("edge", tau=0.975)) == "upper edge (97.5 % below)"
    assert describe_method(Method(loss="huber")) == "single points, Huber's loss"
