"""Every step: forward and back, derivatives against differences, domains; one list of steps."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from app.core.errors import LeafscopeError
from app.core.radiometry import chain as chains
from app.core.radiometry.chain import AnyStep
from app.core.radiometry.drift import Power
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.range_curve import PolynomialCurve, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.salca import BRIGHTEST, SalcaResponse

RANGES = (0.6, 1.15, 3.56, 7.5, 10.0)
SAGGING = (-40.0, 25.0, 0.0, -160.0, -240.0)
SHARES = (0.7, 1.1, 1.0, 0.45, 0.3)
STEPS = {
    "inverse square": InverseSquare(3.56),
    "outer": AnalyticRange(1.5, 0.18, 0.84, "outer", 8.0, 0.5, 60.0),
    "inner": AnalyticRange(1.98, 0.54, 0.64, "inner", 8.0, 0.5, 60.0),
    "lines, additive": PolynomialCurve("additive", RANGES, SAGGING, 3.56, order=1),
    "parabolas, additive": PolynomialCurve("additive", RANGES, SAGGING, 3.56, order=2),
    "parabolas, multiplicative": PolynomialCurve("multiplicative", RANGES, SHARES, 3.56, order=2),
    "spline, additive": SplineCurve("additive", RANGES, SAGGING, 3.56),
    "spline, multiplicative": SplineCurve("multiplicative", RANGES, SHARES, 3.56),
    "power": Power(0.83),
    "log": LogResponse(600.0, 1784.0),
    "decibel": Decibel(),
    "linear": LinearResponse(3e-4, 0.367),
    "proportional": Proportional(900.0),
    "SALCA 1545": SalcaResponse(137.21, 407.04, 16.83),
    "SALCA 1063": SalcaResponse(35.19, 342.45, 7.33),
}
CHAINS = {
    "Hancock": ("outer", "power", "SALCA 1545"),
    "Balduzzi": ("log", "parabolas, additive"),
    "Junttila": ("power", "log"),
    "HSL": ("spline, multiplicative", "proportional"),
    "Leica": ("inverse square", "power", "linear"),
}


@pytest.fixture(params=STEPS.values(), ids=STEPS)
def step(request: pytest.FixtureRequest) -> AnyStep:
    return request.param


def some_points(n: int = 400) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    return 10 ** random.uniform(-2.0, 0.3, n), random.uniform(0.61, 9.99, n)


def test_the_inverse_gives_the_input_back(step: AnyStep) -> None:
    x, distance = some_points()
    np.testing.assert_allclose(step.invert(step.respond(x, distance), distance), x, rtol=1e-9)


def test_slopes_are_those_of_differences(step: AnyStep) -> None:
    x, distance = some_points()
    h = 1e-6
    by_x = (step.respond(x * (1 + h), distance) - step.respond(x * (1 - h), distance)) / (2 * h * x)
    np.testing.assert_allclose(step.slope(x, distance), by_x, rtol=1e-5)
    away = distance[np.abs(distance[:, None] - RANGES).min(axis=1) > 1e-3]  # not at a kink
    x = x[: len(away)]
    by_range = (step.respond(x, away + h) - step.respond(x, away - h)) / (2 * h)
    np.testing.assert_allclose(step.range_slope(x, away), by_range, rtol=1e-5, atol=1e-6)


def test_gradients_are_those_of_differences(step: AnyStep) -> None:
    x, distance = some_points()
    values, found = step.values(), step.gradient(x, distance)
    assert found.shape == (len(step.names), len(x)) == (len(values), len(x))
    for k, value in enumerate(values):
        nudge = np.zeros(len(values))
        nudge[k] = 1e-6 * max(1.0, abs(value))
        high = step.with_values(values + nudge).respond(x, distance)
        low = step.with_values(values - nudge).respond(x, distance)
        wanted = (high - low) / (2 * nudge[k])
        np.testing.assert_allclose(found[k], wanted, rtol=1e-4, atol=1e-6 * np.abs(wanted).max())


def test_values_go_out_and_come_back(step: AnyStep) -> None:
    assert step.with_values(step.values()) == step
    other = step.with_values(step.values() * 1.01)
    np.testing.assert_allclose(other.values(), step.values() * 1.01)


def test_a_step_survives_toml(step: AnyStep) -> None:
    text = msgspec.toml.encode({"steps": [step]})
    again = msgspec.convert(msgspec.toml.decode(text)["steps"], tuple[AnyStep, ...])
    assert again == (step,)


@pytest.mark.parametrize("name", ["outer", "lines, additive", "parabolas, additive",
                                  "spline, multiplicative"])  # fmt: skip
def test_nothing_is_extrapolated_over_range(name: str) -> None:
    step, outside = STEPS[name], np.array([0.1, 0.49, 60.1, 1e9, np.nan, -3.0])
    assert np.isnan(step.respond(np.full(6, 0.5), outside)).all()
    assert np.isnan(step.invert(np.full(6, 0.5), outside)).all()


def test_an_inverse_square_has_no_value_at_the_scanner_or_behind_it() -> None:
    found = STEPS["inverse square"].invert(np.ones(2), np.array([0.0, -1.0]))
    assert np.isnan(found).all()


@pytest.mark.parametrize("name", ["outer", "inner"])
def test_the_analytic_forms_are_those_of_the_paper(name: str) -> None:
    step = STEPS[name]

    def g(r: float) -> float:
        if step.form == "outer":
            return r**-step.a * (1 - np.exp(-step.k2 * r)) ** step.k3
        return r**-step.a * (1 - np.exp(-step.k2 * r**step.k3))

    for r in (0.7, 2.0, 8.0, 33.0, 60.0):
        found = step.respond(np.ones(1), np.array([r]))[0]
        assert found == pytest.approx(g(r) / g(8.0), rel=1e-12)


def test_the_two_prints_differ_as_much_as_the_science_page_says() -> None:
    """science.md 1.4: 0.93–1.23 at 1545 nm and 0.85–1.14 at 1063 nm over 2 to 60 m."""
    r, ones = np.linspace(2.0, 60.0, 20_001), np.ones(20_001)
    for numbers, low, high in (((1.50, 0.18, 0.84), 0.93, 1.23), ((1.98, 0.54, 0.64), 0.85, 1.14)):
        outer = AnalyticRange(*numbers, "outer").respond(ones, r)
        inner = AnalyticRange(*numbers, "inner").respond(ones, r)
        ratio = sorted((outer / inner, inner / outer), key=lambda q: abs(q.min() - low))[0]
        assert ratio.min() == pytest.approx(low, abs=0.01)
        assert ratio.max() == pytest.approx(high, abs=0.01)


def test_salca_finds_the_root_that_bisection_finds() -> None:
    step = STEPS["SALCA 1545"]
    numbers = np.array([1e-6, 0.3, 40.0, 349.0, 407.04, 430.0, 900.0])

    def plain(x: float) -> float:
        return (step.m * x + step.c) * (1 - np.exp(-step.k * x))

    wanted = [brentq(lambda x, y=y: plain(x) - y, 0.0, 50.0, xtol=1e-15) for y in numbers]
    np.testing.assert_allclose(step.invert(numbers, np.array(8.0)), wanted, rtol=1e-9, atol=1e-13)


@settings(max_examples=200, deadline=None)
@given(
    m=st.floats(1e-2, 1e3), c=st.floats(1.0, 1e3), k=st.floats(0.1, 50.0),
    x=st.floats(1e-9, 10.0),
)  # fmt: skip
def test_salca_comes_back_for_any_parameters(m: float, c: float, k: float, x: float) -> None:
    step, at = SalcaResponse(m, c, k), np.array(8.0)
    y = step.respond(np.array([x]), at)
    # A number in a double has 1e-16 of itself; the steeper side of the knee loses none of it.
    lost = float(y[0] / (x * step.slope(np.array([x]), at)[0]))
    assert step.invert(y, at)[0] == pytest.approx(x, rel=1e-14 * max(1.0, lost) + 1e-13)


def test_salca_refuses_what_it_cannot_give() -> None:
    step = STEPS["SALCA 1063"]
    top = step.respond(np.array([BRIGHTEST]), np.array(8.0))[0]
    numbers = np.array([0.0, -1.0, np.nan, np.inf, -np.inf, top * 1.001])
    assert np.isnan(step.invert(numbers, np.array(8.0))).all()
    assert np.isnan(step.respond(np.array([-0.1, 2 * BRIGHTEST]), np.array(8.0))).all()


def test_a_logarithm_has_no_overflow_and_no_zero() -> None:
    numbers = np.array([1e9, -1e9, np.nan])
    assert np.isnan(STEPS["log"].invert(numbers, np.array(1.0))).all()
    assert np.isnan(STEPS["log"].respond(np.array([0.0, -0.1]), np.array(1.0))).all()


def test_decibels_are_decibels() -> None:
    found = Decibel().invert(np.array([0.0, -10.0, -3.0103]), np.array(1.0))
    np.testing.assert_allclose(found, [1.0, 0.1, 0.5], rtol=1e-6)


@pytest.mark.parametrize("names", CHAINS.values(), ids=CHAINS)
def test_a_chain_comes_back_and_knows_its_derivatives(names: tuple[str, ...]) -> None:
    chain = [STEPS[name] for name in names]
    x, distance = some_points()
    near = chains.linearise(chain, x, distance)
    np.testing.assert_allclose(near.value, chains.respond(chain, x, distance), rtol=1e-14)
    np.testing.assert_allclose(chains.invert(chain, near.value, distance), x, rtol=1e-9)
    h = 1e-6
    high, low = (chains.respond(chain, x * (1 + sign * h), distance) for sign in (1, -1))
    np.testing.assert_allclose(near.slope, (high - low) / (2 * h * x), rtol=1e-5)
    values = chains.values(chain)
    assert len(chains.names(chain)) == len(values) == len(near.gradient)
    for k, value in enumerate(values):
        nudge = np.zeros(len(values))
        nudge[k] = 1e-6 * max(1.0, abs(value))
        high, low = (
            chains.respond(chains.with_values(chain, values + s * nudge), x, distance)
            for s in (1, -1)
        )
        wanted = (high - low) / (2 * nudge[k])
        np.testing.assert_allclose(
            near.gradient[k], wanted, rtol=1e-4, atol=1e-6 * np.abs(wanted).max()
        )


def test_the_power_of_a_scan_scales_the_light() -> None:
    chain = [STEPS[name] for name in CHAINS["Hancock"]]
    x, distance = some_points()
    dimmed = chains.with_power(chain, 0.5)
    np.testing.assert_allclose(
        chains.respond(dimmed, x, distance),
        chains.respond(chains.with_power(chain, 1.0), 0.5 * x, distance),
        rtol=1e-12,
    )


@pytest.mark.parametrize(
    "make",
    [
        lambda: LogResponse(0.0, 1.0),
        lambda: LogResponse(np.nan, 1.0),
        lambda: LinearResponse(-1.0, 0.0),
        lambda: Proportional(0.0),
        lambda: SalcaResponse(1.0, -1.0, 1.0),
        lambda: Power(0.0),
        lambda: InverseSquare(0.0),
        lambda: AnalyticRange(1.0, 0.0, 1.0),
        lambda: AnalyticRange(1.0, 1.0, 1.0, reference=1.0),
        lambda: PolynomialCurve("additive", (1.0, 2.0), (0.0,), 1.0),
        lambda: PolynomialCurve("additive", (2.0, 1.0), (0.0, 1.0), 1.0),
        lambda: PolynomialCurve("additive", (1.0, 1.0), (0.0, 1.0), 1.0),
        lambda: PolynomialCurve("additive", (1.0, 2.0), (0.0, 1.0), 1.5),
        lambda: PolynomialCurve("additive", (1.0, 2.0), (0.0, 1.0), 1.0, order=2),
        lambda: PolynomialCurve("multiplicative", (1.0, 2.0), (1.0, -1.0), 1.0),
        lambda: SplineCurve("additive", (1.0, 2.0), (0.0, np.nan), 1.0),
    ],
)
def test_impossible_steps_are_refused_in_a_sentence(make) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(LeafscopeError, match=r"\w+ .+\."):
        make()
