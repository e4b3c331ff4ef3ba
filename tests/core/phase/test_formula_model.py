"""Formula models: safe, differentiated by themselves, fitted within their bounds, stored."""

from __future__ import annotations

import json

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.core.fitting import FitResult, fit
from app.core.fitting.bins import fit_bins
from app.core.fitting.edge import fit_edge
from app.core.fitting.profile import profile_intervals
from app.core.fitting.robust import fit_robust
from app.core.fitting.selection import compare_models
from app.core.fitting.trust_region import fit_trust_region
from app.core.phase import MODELS
from app.core.phase.formula_model import FormulaDefinition, FormulaParameter, make_formula_model
from app.core.units import to_radians

STEPS = to_radians(np.arange(0.0, 81.0, 5.0))
F = FormulaParameter("f", (0.1, 1.5), lower=0.0, unit="value", scales=True)
PHONG = FormulaDefinition(
    "phong",
    "f*(k*cos(omega) + (1 - k)*cos(omega)**n)",
    (
        F,
        FormulaParameter("k", (0.1, 0.9), 0.0, 1.0),
        FormulaParameter("n", (2.0, 60.0), 1.0, 200.0),
    ),
)
BECKMANN = FormulaDefinition(
    "my beckmann",
    "f*(k_d*cos(omega) + (1 - k_d)*exp(-(tan(omega)/m)**2)/cos(omega)**5)",
    (
        F,
        FormulaParameter("k_d", (0.1, 0.9), 0.0, 1.0),
        FormulaParameter("m", (0.1, 0.6), 1e-3, 1.0),
    ),
)
STEPPED = (
    "a*abs(omega - b) + sqrt(b + omega) + exp(-a*omega) + log(b + omega) + log10(a + omega)"
    " + sin(a*omega) + tan(b*omega/4) + arctan2(a*omega + 0.1, b) + minimum(omega, b)",
    "maximum(omega, b) + where(omega > a, omega**2, a*omega) + (omega + 1) % a"
    " + omega // 10 + (1 + omega)**a - -b/(a + omega) + where(~(omega > 9) & isfinite(a), b, 0)",
)


def define(expression: str, *names: str) -> FormulaDefinition:
    return FormulaDefinition(
        "mine", expression, tuple(FormulaParameter(n, (0.2, 0.9)) for n in names)
    )


def test_beckmann_as_a_formula_is_the_model() -> None:
    mine, theirs = make_formula_model(BECKMANN), MODELS["lambert-beckmann"]
    for seed in range(5):
        values = theirs.random(np.random.default_rng(seed))
        expected = theirs.evaluate(STEPS, values)
        np.testing.assert_allclose(mine.evaluate(STEPS, values), expected, rtol=1e-12)
        np.testing.assert_allclose(
            mine.slope(STEPS, values), theirs.slope(STEPS, values), rtol=1e-9, atol=1e-12
        )
        names = list(values)
        np.testing.assert_allclose(
            mine.jacobian(STEPS, values, names),
            theirs.jacobian(STEPS, values, names),
            rtol=1e-9,
            atol=1e-12,
        )


@pytest.mark.parametrize("expression", STEPPED)
def test_every_allowed_step_is_differentiated(expression: str) -> None:
    model = make_formula_model(define(expression, "a", "b"))
    angle, step = to_radians(np.arange(3.0, 85.0, 1.7)), 1e-6
    values = {"a": 0.71, "b": 0.43}
    rise = model.evaluate(angle + step, values) - model.evaluate(angle - step, values)
    np.testing.assert_allclose(model.slope(angle, values), rise / (2 * step), rtol=1e-6)
    jacobian = model.jacobian(angle, values, ["a", "b"])
    for column, name in zip(jacobian.T, "ab", strict=True):
        above = model.evaluate(angle, values | {name: values[name] + step})
        below = model.evaluate(angle, values | {name: values[name] - step})
        np.testing.assert_allclose(column, (above - below) / (2 * step), rtol=1e-5, atol=1e-8)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_parameters_are_recovered(scale: float) -> None:
    model = make_formula_model(PHONG)
    for seed in range(3):
        values = model.random(np.random.default_rng(seed), scale)
        result = fit(model, STEPS, model.evaluate(STEPS, values))
        assert result.values == pytest.approx(values, rel=1e-6)


def test_a_formula_is_fitted_as_well_as_the_model() -> None:
    mine, theirs = make_formula_model(BECKMANN), MODELS["lambert-beckmann"]
    for seed in range(6):
        rng = np.random.default_rng(seed)
        value = theirs.evaluate(STEPS, theirs.random(rng)) * (1 + 0.06 * rng.standard_normal(17))
        ours = fit(theirs, STEPS, value)
        assert fit(mine, STEPS, value).rss == pytest.approx(ours.rss, rel=1e-6)


def test_many_pairs_weights_and_fixed_parameters() -> None:
    model, rng = make_formula_model(PHONG), np.random.default_rng(0)
    angle = rng.uniform(0.0, 1.4, 3000)
    true = {"f": 500.0, "k": 0.6, "n": 20.0}
    value = model.evaluate(angle, true) * (1 + 0.05 * rng.standard_normal(3000))
    result = fit(model, angle, value, weights=value**-2.0, fixed={"n": 20.0})
    assert result.values == pytest.approx(true, rel=0.02)
    assert result.parameters["n"].fixed
    assert result.interval("f") is not None


def test_a_parameter_without_bounds_is_found_outside_its_usual_range() -> None:
    model = make_formula_model(define("a + b*omega", "a", "b"))
    result = fit(model, STEPS, 7.0 - 30.0 * STEPS)
    assert result.values == pytest.approx({"a": 7.0, "b": -30.0}, rel=1e-9)


def test_definition_and_result_are_stored() -> None:
    text = msgspec.json.encode(PHONG)
    assert msgspec.json.decode(text, type=FormulaDefinition) == PHONG
    model = make_formula_model(PHONG)
    result = fit(model, STEPS, model.evaluate(STEPS, {"f": 2.0, "k": 0.5, "n": 9.0}) + 0.01 * STEPS)
    again = FitResult.from_dict(json.loads(json.dumps(result.as_dict(), allow_nan=False)))
    assert again == result
    np.testing.assert_array_equal(again.evaluate(STEPS), result.evaluate(STEPS))
    assert np.isfinite(again.inverse(np.array([1.5]))).all()


@pytest.mark.parametrize(
    "expression", ["__import__('os').system('ls')", "omega.x", "a if omega else 1"]
)
def test_a_stored_formula_is_checked_again(expression: str) -> None:
    model = make_formula_model(PHONG)
    plain = fit(model, STEPS, model.evaluate(STEPS, model.start_values()) + 0.01 * STEPS).as_dict()
    with pytest.raises(BadInput, match="stored fit"):
        FitResult.from_dict(plain | {"formula": plain["formula"] | {"expression": expression}})


@pytest.mark.parametrize(
    ("definition", "says"),
    [
        (define("a*omega + c", "a"), "c in the formula"),
        (define("a*omega", "a", "b"), "does not use b"),
        (define("a*2", "a"), "does not depend on omega"),
        (define("omega*2"), "1 to 8 parameters"),
        (define("a*omega", "a", "a"), "named 'a'"),
        (define("cos*omega", "cos"), "cannot be the name"),
        (define("omega*a", "omega"), "cannot be the name"),
        (define("omega > a", "a"), "condition"),
        (define("omega.real*a", "a"), "a dot"),
        (define("(lambda: a)()*omega", "a"), "not allowed"),
        (define("open(a)*omega", "a"), "not allowed"),
        (define("omega**(a.b)", "a"), "a dot"),
        (define("omega**(lambda: a)", "a"), "a lambda"),
        (define("a*omega" + " + a" * 200, "a"), "characters|parts"),
        (FormulaDefinition("lambert", "f*cos(omega)", (F,)), "cannot be named"),
        (FormulaDefinition("", "f*cos(omega)", (F,)), "cannot be named"),
        (FormulaDefinition("x", "f**2*cos(omega)", (F,)), "does not double"),
        (FormulaDefinition("x", "a*omega", (FormulaParameter("a", (2.0, 1.0)),)), "usual"),
        (FormulaDefinition("x", "a*omega", (FormulaParameter("a", (0.0, 1.0), 0.5),)), "usual"),
        (FormulaDefinition("x", "a*omega", (FormulaParameter("a", (0.0, np.nan)),)), "usual"),
    ],
)  # fmt: skip
def test_bad_definitions_are_refused_in_words(definition: FormulaDefinition, says: str) -> None:
    with pytest.raises(LeafscopeError, match=says) as caught:
        make_formula_model(definition)
    assert isinstance(caught.value, (WrongUse, BadInput))


def test_a_formula_without_finite_values_is_refused() -> None:
    model = make_formula_model(define("log(-a - omega)", "a"))
    with pytest.raises(BadInput, match="no finite value"):
        fit(model, STEPS, np.cos(STEPS))


def test_a_formula_takes_part_where_it_can_and_is_refused_in_words_elsewhere() -> None:
    model, rng = make_formula_model(PHONG), np.random.default_rng(1)
    angle = rng.uniform(0.0, 1.4, 400)
    value = model.evaluate(angle, {"f": 2.0, "k": 0.5, "n": 20.0}) + 0.05 * rng.normal(size=400)
    assert fit_bins(model, angle, value).values["k"] == pytest.approx(0.5, abs=0.1)
    first = compare_models([model, "lambert"], angle, value)[0]
    assert first.aicc_above == 0.0
    for refuse in (fit_edge, fit_robust, fit_trust_region, profile_intervals):
        with pytest.raises(WrongUse, match="points or to bins"):
            refuse(model, angle, value)  # type: ignore[arg-type]


def scaling(expression: str, *names: str) -> FormulaDefinition:
    """Parameters a, b and c, of which some are said to scale."""
    plain = expression.replace("cos", "").replace("omega", "")
    used = [name for name in "abc" if name in plain]
    return FormulaDefinition(
        "mine",
        expression,
        tuple(FormulaParameter(name, (0.1, 1.0), scales=name in names) for name in used),
    )


@pytest.mark.parametrize(
    ("expression", "said", "cure"),
    [
        ("a*cos(omega) + b", ("a",), "Let a and b scale with the data, and them alone."),
        ("a*cos(omega)**b", ("a", "b"), "Let a scale with the data, and it alone."),
        ("a*cos(omega)**b", ("b",), "Let a scale with the data, and it alone."),
        ("a*cos(omega) + b + c", ("b",), "Let a, b and c scale with the data, and them alone."),
        ("cos(omega)**a", ("a",), "No choice of its parameters scales it: let none scale."),
    ],
)
def test_what_does_not_scale_says_what_would(
    expression: str, said: tuple[str, ...], cure: str
) -> None:
    with pytest.raises(WrongUse) as caught:
        make_formula_model(scaling(expression, *said))
    assert caught.value.hint == cure
