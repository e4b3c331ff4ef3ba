"""Facts of the papers that a single model must show."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.fitting import fit
from app.core.phase import MODELS, Reference
from app.core.phase.cosine import expect_amplitude
from app.core.phase.incidence_b import find_reach
from app.core.units import to_degrees, to_radians
from app.core.workflows.chain import Limits, correct

STEPS = to_radians(np.arange(0.0, 81.0, 5.0))
BECKMANN = MODELS["lambert-beckmann"]


def list_references() -> list[object]:
    return [
        pytest.param(name, reference, id=f"{name}: {reference.sample}")
        for name, model in MODELS.items()
        for reference in model.references
    ]


@pytest.mark.parametrize(("name", "reference"), list_references())
def test_printed_parameters_are_recovered(name: str, reference: Reference) -> None:
    model = MODELS[name]
    rest = {p.name: max(p.typical) / 3 for p in model.parameters}
    values = rest | dict(reference.values)
    found = fit(model, STEPS, model.evaluate(STEPS, values)).values
    for parameter, printed in reference.values.items():
        if parameter == "m" and values["k_d"] == 1.0:
            assert np.isnan(found["m"])
        else:
            assert found[parameter] == pytest.approx(printed, abs=1e-9)


def test_all_printed_samples_are_there() -> None:
    assert len(BECKMANN.references) == 7 * 8 + 10
    assert len(MODELS["incidence-b"].references) == 10
    assert len(MODELS["cosine"].references) == 12 * 3


def test_beckmann_is_the_printed_formula() -> None:
    f, k_d, m = 1.3, 0.4, 0.25
    direct = f * (
        k_d * np.cos(STEPS) + (1 - k_d) * np.exp(-(np.tan(STEPS) ** 2) / m**2) / np.cos(STEPS) ** 5
    )
    curve = BECKMANN.evaluate(STEPS, {"f": f, "k_d": k_d, "m": m})
    np.testing.assert_allclose(curve, direct, rtol=1e-13)


def test_no_m_is_needed_without_specular_part() -> None:
    for values in ({"f": 2.0, "k_d": 1.0, "m": np.nan}, {"f": 2.0, "k_d": 1.0}):
        np.testing.assert_allclose(BECKMANN.evaluate(STEPS, values), 2.0 * np.cos(STEPS))
        assert np.isfinite(BECKMANN.inverse(np.array([1.0]), values)).all()
    assert not BECKMANN.evaluate(STEPS, {"f": 0.0}).any()


@pytest.mark.parametrize(("m", "rises"), [(0.60, False), (0.63, False), (0.64, True), (0.9, True)])
def test_specular_term_rises_above_root_04(m: float, rises: bool) -> None:
    values = {"f": 1.0, "k_d": 0.0, "m": m}
    near = BECKMANN.evaluate(to_radians(np.array([0.0, 3.0])), values)
    assert (near[1] > near[0]) == rises
    warnings = fit(BECKMANN, STEPS, BECKMANN.evaluate(STEPS, values)).warnings
    assert any("unphysical" in w for w in warnings) == rises


def test_peak_between_zero_and_the_first_angle_is_called_extrapolated() -> None:
    angles = to_radians(np.arange(20.0, 80.0, 2.0))
    values = {"f": 1.0, "k_d": 0.5, "m": 0.15}
    result = fit(BECKMANN, angles, BECKMANN.evaluate(angles, values))
    assert any("extrapolated" in w for w in result.warnings)


def factor_of(b: float, *angles_deg: float, limits: Limits | None = None) -> np.ndarray:
    angle = to_radians(np.array(angles_deg))
    return correct("wf2", np.ones(len(angle)), angle, {"b": b}, limits or Limits()).values


def test_bracket_of_the_steepest_leaf() -> None:
    factor = factor_of(2.3, 0.0, 45.0, 50.0, 54.0, 60.0)
    assert factor[:2] == pytest.approx([1.0, 1 / (1 - 2.3 * (1 - np.sqrt(0.5)))])
    assert np.isnan(factor[2:]).all()
    wide = factor_of(2.3, 50.0, 54.0, 55.7, limits=Limits(least_bracket=0.01))
    assert wide[0] == pytest.approx(5.6, abs=0.05)
    assert wide[1] == pytest.approx(19.0, abs=0.5)
    assert np.isnan(wide[2])
    assert to_degrees(find_reach(2.3, 0.0)) == pytest.approx(55.6, abs=0.05)


def test_angles_beyond_the_fit_are_not_corrected() -> None:
    angles = to_radians(np.array([10.0, 20.0, 30.0]))
    factor = factor_of(1.0, 10.0, 20.0, 30.0, limits=Limits(fitted=(angles[1], angles[1])))
    assert np.isnan(factor).tolist() == [True, False, True]


def test_flat_leaf_reaches_edge_on() -> None:
    assert find_reach(0.58) == pytest.approx(np.pi / 2)


def test_cosine_keeps_the_peak_within_45_degrees() -> None:
    model = MODELS["cosine"]
    angles = to_radians(np.arange(-50.0, 51.0, 5.0))
    far = {"A": 0.2, "mu": 70.0, "nu": 0.5}
    found = fit(model, angles, model.evaluate(angles, far)).values
    assert found == pytest.approx({"A": -0.2, "mu": -20.0, "nu": 0.5}, rel=1e-10)


def test_amplitude_of_pure_noise() -> None:
    angles = to_radians(np.arange(-50.0, 51.0, 5.0))
    expected = expect_amplitude(angles, 0.055)
    assert expected == pytest.approx(0.030, abs=5e-4)
    rng = np.random.default_rng(3)
    columns = np.column_stack((np.cos(2 * angles), np.sin(2 * angles), np.ones(len(angles))))
    noise = 0.055 * rng.standard_normal((len(angles), 20000))
    p, q, _ = np.linalg.lstsq(columns, noise, rcond=None)[0]
    assert np.hypot(p, q).mean() == pytest.approx(expected, rel=0.02)


def test_cosine_of_noise_is_doubted() -> None:
    angles = to_radians(np.arange(-50.0, 51.0, 5.0))
    noise = 0.1 + 0.055 * np.random.default_rng(0).standard_normal((100, len(angles)))
    swing = noise + np.cos(2 * angles)

    def count_doubts(rows: np.ndarray, fixed: dict[str, float]) -> int:
        results = [fit("cosine", angles, row, fixed=fixed) for row in rows]
        return sum(any("scatter" in w for w in result.warnings) for result in results)

    # 2.5 times the mean is exceeded by 1 % of amplitudes with a round spread, 5 % with a flat one.
    assert 90 <= count_doubts(noise, {}) < 100
    assert count_doubts(swing, {}) == 0
    assert count_doubts(noise, {"mu": 0.0}) == 0


def test_polynomial_beyond_60_degrees_is_warned_of() -> None:
    angles = to_radians(np.arange(0.0, 71.0, 5.0))
    assert any("60°" in w for w in fit("polynomial-4", angles, np.cos(angles)).warnings)
    below = angles[angles < to_radians(58.0)]
    assert not fit("polynomial-4", below, np.cos(below)).warnings
