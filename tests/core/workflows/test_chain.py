"""The workflows against curves with known parameters, finite differences and Monte Carlo."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.core.phase import get_model
from app.core.workflows import WORKFLOWS, Limits, correct
from app.core.workflows.marks import (
    BEYOND_FITTED,
    GOOD,
    NEGATIVE,
    NO_ANGLE,
    NO_INTENSITY,
    SMALL_BRACKET,
)
from app.core.workflows.published import find_published, list_published

ANGLE = np.deg2rad(np.linspace(0.0, 89.0, 90))
GLOSSY = {"f": 0.7, "k_d": 0.45, "m": 0.35}
VALUES = {"wf2": {"b": 0.8}, "wf3": GLOSSY, "wf3_subtracted": GLOSSY}


@pytest.mark.parametrize("b", [-0.4, 0.25, 0.82, 1.0, 1.78, 2.3])
def test_a_leaf_that_follows_b_becomes_flat(b: float) -> None:
    intensity = get_model("incidence-b").evaluate(ANGLE, {"a": 0.4, "b": b})
    found = correct("wf2", intensity, ANGLE, {"b": b})
    bracket = 1 - b * (1 - np.cos(ANGLE))
    assert (found.marks[bracket >= 0.25] == GOOD).all()
    assert (found.marks[bracket < 0.25] == SMALL_BRACKET).all()
    assert np.isnan(found.values[bracket < 0.25]).all()
    np.testing.assert_allclose(found.values[bracket >= 0.25], 0.4, rtol=1e-12)


@pytest.mark.parametrize("workflow", ["wf3", "wf3_subtracted"])
@pytest.mark.parametrize("k_d", [0.2, 0.6, 1.0])
def test_a_glossy_leaf_gives_its_diffuse_reflectance_at_every_angle(
    workflow: str, k_d: float
) -> None:
    values = GLOSSY | {"k_d": k_d}
    intensity = get_model("lambert-beckmann").evaluate(ANGLE, values)
    given = {name: value for name, value in values.items() if name != "m" or k_d < 1}
    found = correct(workflow, intensity, ANGLE, given)
    kept = np.cos(ANGLE) >= 0.25
    np.testing.assert_allclose(found.values[kept], 0.7 * k_d, rtol=1e-9)
    assert (found.marks[~kept] == SMALL_BRACKET).all()


@pytest.mark.parametrize("workflow", list(WORKFLOWS))
def test_slopes_agree_with_finite_differences(workflow: str) -> None:
    angle = np.deg2rad(np.linspace(1.0, 74.0, 40))
    intensity, values = np.linspace(0.2, 0.9, 40), VALUES[workflow]

    def run(intensity: np.ndarray, angle: np.ndarray, values: dict[str, float]) -> np.ndarray:
        return correct(workflow, intensity, angle, values, Limits(1e-9)).values

    slopes, h = correct(workflow, intensity, angle, values, Limits(1e-9)).slopes, 1e-6
    by_value = (run(intensity + h, angle, values) - run(intensity - h, angle, values)) / (2 * h)
    by_angle = (run(intensity, angle + h, values) - run(intensity, angle - h, values)) / (2 * h)
    np.testing.assert_allclose(slopes.by_value, by_value, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(slopes.by_angle, by_angle, rtol=1e-5, atol=1e-7)
    complete = dict(WORKFLOWS[workflow].assumed) | values
    for name in WORKFLOWS[workflow].parameters:
        up, down = (run(intensity, angle, complete | {name: complete[name] + s}) for s in (h, -h))
        np.testing.assert_allclose(
            slopes.by_parameter[name], (up - down) / (2 * h), rtol=1e-5, atol=1e-7
        )


@pytest.mark.parametrize("workflow", list(WORKFLOWS))
def test_sigma_agrees_with_monte_carlo(workflow: str) -> None:
    random = np.random.default_rng(3)
    angle, intensity = np.deg2rad(np.array([5.0, 25.0, 45.0])), np.array([0.5, 0.4, 0.3])
    values = dict(WORKFLOWS[workflow].assumed) | VALUES[workflow]
    names = [n for n in WORKFLOWS[workflow].parameters if n in VALUES[workflow]]
    root = random.normal(size=(len(names), len(names))) * 0.004
    table = root @ root.T
    rows = (dict(zip(names, row, strict=True)) for row in table)
    covariance = dict(zip(names, rows, strict=True))
    found = correct(workflow, intensity, angle, values)
    sigma = found.sigma(0.01, np.full(3, 0.01), covariance)
    drawn = []
    for shift in random.multivariate_normal(np.zeros(len(names)), table, 20_000):
        moved = values | {n: values[n] + s for n, s in zip(names, shift, strict=True)}
        noise = random.normal(0, 0.01, (2, 3))
        drawn.append(correct(workflow, intensity + noise[0], angle + noise[1], moved).values)
    np.testing.assert_allclose(sigma, np.std(drawn, axis=0), rtol=0.03)


def test_points_that_cannot_be_corrected_say_why() -> None:
    angle = np.deg2rad([10.0, 70.0, 20.0, np.nan, 5.0, 54.0])
    intensity = np.array([0.3, 0.3, np.nan, 0.3, 0.3, 0.3])
    limits = Limits(0.25, (np.deg2rad(8.0), np.deg2rad(60.0)))
    found = correct("wf2", intensity, angle, {"b": 2.3}, limits)
    wanted = [GOOD, BEYOND_FITTED, NO_INTENSITY, NO_ANGLE, BEYOND_FITTED, SMALL_BRACKET]
    assert found.marks.tolist() == wanted
    assert np.isfinite(found.values).tolist() == [mark == GOOD for mark in wanted]


def test_what_falls_below_zero_is_marked_and_kept() -> None:
    found = correct("wf3_subtracted", np.array([0.1, 0.9]), np.zeros(2), GLOSSY)
    assert found.marks.tolist() == [NEGATIVE, GOOD]
    np.testing.assert_allclose(found.values, np.array([0.1, 0.9]) - 0.7 * 0.55)


def test_the_factor_explodes_as_science_says() -> None:
    angle = np.deg2rad([50.0, 54.0])
    found = correct("wf2", np.ones(2), angle, {"b": 2.3}, Limits(0.01))
    np.testing.assert_allclose(found.values, [5.6, 19.0], rtol=0.02)


@given(
    st.floats(0.0, 90.0),
    st.floats(0.0, 1.0),
    st.floats(0.001, 1.0),
    st.sampled_from(sorted(VALUES)),
)
def test_never_infinite_and_never_more_than_the_bracket_allows(
    degrees: float, k_d: float, m: float, workflow: str
) -> None:
    values = {"f": 1.0, "k_d": k_d, "m": m, "b": 1.0}
    found = correct(workflow, np.array([0.5]), np.deg2rad(np.array([degrees])), values)
    assert not np.isinf(found.values).any()
    if workflow == "wf3" and found.marks[0] == GOOD:
        assert 0.0 <= found.values[0] <= 0.5 / 0.25 * (1 + 1e-12)


def test_the_published_parameters_are_those_of_the_paper() -> None:
    assert set(list_published()) == {"lime", "birch", "maple", "spruce", "pine"}
    assert find_published("lime", 1550.0, "wf2") == {"b": 1.78}
    assert find_published("birch", 690.0, "wf3") == {"k_d": 0.78, "m": 0.58}
    unknown = [("oak", 1550.0, "wf2"), ("lime", 905.0, "wf2"), ("lime", None, "wf2")]
    for species, nm, workflow in [*unknown, ("lime", 690.0, "wf3_subtracted")]:
        with pytest.raises(WrongUse):
            find_published(species, nm, workflow)
    with pytest.raises(WrongUse, match="wf2, wf3"):
        correct("wf9", np.ones(1), np.zeros(1), {})
