"""Every model of the registry, against what all models must do."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.fitting import fit
from app.core.phase import MODELS, PhaseModel, get_model
from app.core.units import to_radians

ANGLES = to_radians(np.concatenate((np.arange(0.0, 90.0, 0.1), [89.9, 89.999, 90.0])))
SEEDS = range(5)


def draw(model: PhaseModel, seed: int) -> dict[str, float]:
    return model.random(np.random.default_rng(seed))


@pytest.fixture(params=MODELS.values(), ids=MODELS.keys())
def model(request: pytest.FixtureRequest) -> PhaseModel:
    return request.param


def test_names_are_the_contract() -> None:
    assert {name: [p.name for p in m.parameters] for name, m in MODELS.items()} == {
        "lambert": ["f"],
        "lambert-beckmann": ["f", "k_d", "m"],
        "lommel-seeliger": ["c", "d"],
        "incidence-b": ["a", "b"],
        "cosine": ["A", "mu", "nu"],
        "fourier-2": ["a0", "a1", "b1", "a2", "b2", "w"],
        "polynomial-4": ["p0", "p1", "p2", "p3", "p4"],
    }


def test_unknown_model_names_the_known_ones() -> None:
    with pytest.raises(WrongUse, match="lambert-beckmann"):
        get_model("phong")


def test_every_parameter_is_described(model: PhaseModel) -> None:
    assert all(p.unit and p.meaning for p in model.parameters)
    assert all(p.lower <= min(p.typical) < max(p.typical) <= p.upper for p in model.parameters)
    assert model.formula
    assert model.source
    assert not model.shape or model.parameters[-1].name == model.shape


def test_random_parameters_are_usual_and_scale(model: PhaseModel) -> None:
    one, large = draw(model, 1), model.random(np.random.default_rng(1), 1e6)
    for p in model.parameters:
        assert p.typical[0] <= one[p.name] <= p.typical[1]
        assert large[p.name] == pytest.approx(one[p.name] * (1e6 if p.scales else 1.0))
        assert p.typical[0] < model.start_values()[p.name] < p.typical[1]


def test_groups_side_by_side_are_the_same_curves(model: PhaseModel) -> None:
    """Coefficients, slopes and names of arrays are those of their elements."""
    rows = [draw(model, seed) for seed in SEEDS]
    values = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    coefficients, slopes = model.coefficients(values), model.coefficient_slopes(values)
    named = model.name_values(coefficients, values.get(model.shape, np.nan), {})
    for i, row in enumerate(rows):
        np.testing.assert_allclose(coefficients[i], model.coefficients(row))
        expected = np.broadcast_to(slopes, (len(rows), *slopes.shape[-2:]))[i]
        np.testing.assert_allclose(expected, model.coefficient_slopes(row))
        assert {name: column[i] for name, column in named.items()} == pytest.approx(row)


@pytest.mark.parametrize("seed", SEEDS)
def test_fit_recovers_random_parameters_and_their_scale(model: PhaseModel, seed: int) -> None:
    angles = ANGLES[:-1:20]
    values = draw(model, seed)
    for size in (1.0, 1e-6):
        found = fit(model, angles, size * model.evaluate(angles, values)).values
        for p in model.parameters:
            expected = values[p.name] * (size if p.scales else 1.0)
            assert found[p.name] == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_finite_up_to_edge_on(model: PhaseModel, seed: int) -> None:
    values = draw(model, seed)
    with np.errstate(all="raise", under="ignore"):
        assert np.isfinite(model.evaluate(ANGLES, values)).all()
        assert np.isfinite(model.slope(ANGLES, values)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_only_scaling_parameters_scale(model: PhaseModel, seed: int) -> None:
    values = draw(model, seed)
    scaled = {p.name: values[p.name] * (7.5 if p.scales else 1.0) for p in model.parameters}
    expected = 7.5 * model.evaluate(ANGLES, values)
    np.testing.assert_allclose(model.evaluate(ANGLES, scaled), expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_slope_is_the_derivative(model: PhaseModel, seed: int) -> None:
    values, step, angles = draw(model, seed), 1e-6, to_radians(np.arange(0.5, 85.0, 0.7))
    rise = model.evaluate(angles + step, values) - model.evaluate(angles - step, values)
    np.testing.assert_allclose(model.slope(angles, values), rise / (2 * step), rtol=1e-5, atol=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_jacobian_is_the_derivative(model: PhaseModel, seed: int) -> None:
    values, angles = draw(model, seed), to_radians(np.arange(0.5, 85.0, 0.7))
    names = [p.name for p in model.parameters]
    jacobian = model.jacobian(angles, values, names)
    for column, name in zip(jacobian.T, names, strict=True):
        step = 1e-6 * max(1.0, abs(values[name]))
        above = model.evaluate(angles, values | {name: values[name] + step})
        below = model.evaluate(angles, values | {name: values[name] - step})
        np.testing.assert_allclose(column, (above - below) / (2 * step), rtol=1e-5, atol=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_coefficients_and_names_agree(model: PhaseModel, seed: int) -> None:
    values = draw(model, seed)
    shape = values.get(model.shape, np.nan)
    named = model.name_values(model.coefficients(values), shape, {})
    assert named == pytest.approx(values, rel=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_inverse_undoes_the_curve(model: PhaseModel, seed: int) -> None:
    values = draw(model, seed)
    interval = model.monotone_interval(values)
    assert interval is not None
    angles = np.linspace(*interval, 5001)
    curve = model.evaluate(angles, values)
    found = model.inverse(curve, values)
    np.testing.assert_allclose(
        model.evaluate(found, values), curve, rtol=1e-13, atol=1e-13 * np.abs(curve).max()
    )
    # Rounding of the curve itself, seen through its slope, is all the error there may be.
    with np.errstate(divide="ignore"):
        blur = 4 * np.finfo(float).eps * np.abs(curve).max() / np.abs(model.slope(angles, values))
    clear = blur < 1e-9
    assert clear.sum() > 2500
    assert (np.abs(found - angles)[clear] <= 1e-12 + 4 * blur[clear]).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_inverse_is_nan_where_the_curve_does_not_go(model: PhaseModel, seed: int) -> None:
    values = draw(model, seed)
    interval = model.monotone_interval(values)
    assert interval is not None
    ends = np.sort(model.evaluate(np.array(interval), values))
    width = ends[1] - ends[0]
    outside = np.array([[ends[0] - 0.01 * width, np.nan], [ends[1] + 0.01 * width, np.inf]])
    assert np.isnan(model.inverse(outside, values)).all()


def test_slope_keeps_its_sign_on_the_monotone_interval(model: PhaseModel) -> None:
    for seed in range(20):
        interval = model.monotone_interval(values := draw(model, seed))
        assert interval is not None
        low, high = interval
        inside = np.linspace(low, high, 999)[1:-1]
        assert len(np.unique(np.sign(model.slope(inside, values)))) == 1


def test_no_scipy_at_import() -> None:
    code = "import sys, app.core.phase, app.core.fitting; sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
