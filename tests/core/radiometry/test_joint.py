"""The joint fit: its Jacobian, its covariances and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry.joint import Undetermined, find_singular, fit_jointly, predict
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.profile import Noise
from app.core.radiometry.range_curve import PolynomialCurve
from app.core.radiometry.range_effect import AnalyticRange
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.unknowns import Unknowns

RHO = np.array([0.05, 0.12, 0.25, 0.5, 0.9])
SALCA = (AnalyticRange(1.5, 0.18, 0.84), SalcaResponse(137.0, 407.0, 16.8))
LOG = (
    LogResponse(600.0, 1780.0),
    PolynomialCurve("additive", (2.0, 8.0, 30.0), (90, 0, -500), 8.0),
)


def make(steps, seed: int | None = 0) -> tuple[PanelTable, Unknowns]:  # type: ignore[no-untyped-def]
    away = np.array([2.0, 5.0, 8.0, 15.0, 30.0])
    powers = np.array([1.0, 0.6, 0.8, 0.9, 0.7])
    rows = [(r, d, s) for s, d in enumerate(away) for r in RHO]
    rows += [(r, 8.0, s) for s in range(5) for r in RHO[::2]]
    rho, distance, scan = (np.array(column) for column in zip(*rows, strict=True))
    kind = ["m"] * 25 + ["f"] * 15
    table = make_table(
        distance,
        np.zeros(len(rho)),
        rho,
        785.0,
        scan=[f"s{int(k)}" for k in scan],
        panel=[f"{k}{r:g}" for k, r in zip(kind, rho, strict=True)],
        reflectance_sigma=0.02 * rho,
    )
    truth = Unknowns(steps, table.scans, powers, np.array([False, True, True, True, True]))
    dn = predict(truth, table)[0]
    if seed is not None:
        dn = dn + 0.5 * np.random.default_rng(seed).standard_normal(len(dn))
    return replace(table, dn=dn), truth


@pytest.mark.parametrize("steps", [SALCA, LOG])
def test_the_jacobian_is_that_of_differences(steps) -> None:  # type: ignore[no-untyped-def]
    table, truth = make(steps)
    _, jacobian, slope = predict(truth, table)
    for k in range(len(truth)):
        ends = []
        for sign in (1, -1):
            vector = truth.vector()
            vector[k] += sign * 1e-6
            ends.append(predict(truth.at(vector), table)[0])
        expected = (ends[0] - ends[1]) / 2e-6
        assert jacobian[:, k] == pytest.approx(expected, rel=1e-5, abs=1e-4)
    brighter = replace(table, reflectance=table.reflectance + 1e-7)
    by_rho = (predict(truth, brighter)[0] - predict(truth, table)[0]) / 1e-7
    assert slope == pytest.approx(by_rho, rel=1e-4)


@pytest.mark.parametrize("steps", [SALCA, LOG])
def test_the_truth_comes_back_without_noise(steps) -> None:  # type: ignore[no-untyped-def]
    table, truth = make(steps, seed=None)
    off = truth.at(truth.vector() + 0.05)
    found = fit_jointly(table, off)
    assert found.found.natural() == pytest.approx(truth.natural(), rel=1e-7)


def test_a_straight_line_has_the_covariance_of_the_textbook() -> None:
    random = np.random.default_rng(7)
    rho = np.tile(RHO, 6)
    dn = 1780 + 600 * np.log10(rho) + 3.0 * random.standard_normal(len(rho))
    names = [f"p{k}" for k in range(len(rho))]
    table = make_table(np.ones(len(rho)), dn, rho, 785.0, panel=names)
    start = Unknowns((LogResponse(500.0, 1700.0),), ("1",), np.ones(1), np.zeros(1, bool))
    found = fit_jointly(table, start, Noise(1.0))
    line, covariance = np.polyfit(np.log10(rho), dn, 1, cov=True)
    assert found.found.natural() == pytest.approx(line, rel=1e-8)
    assert found.noise_covariance == pytest.approx(covariance, rel=1e-6)
    assert found.noise.constant == pytest.approx(3.0, rel=0.3)
    assert found.freedom == 28


def test_the_panel_covariance_is_that_of_refits_with_wrong_panels() -> None:
    table, truth = make(LOG, seed=1)
    best = fit_jointly(table, truth, Noise(0.5))
    moved = []
    for panel in table.panels:
        mine = table.panel == panel
        shift = np.where(mine, 1e-4 * table.reflectance, 0.0)
        refit = fit_jointly(
            replace(table, reflectance=table.reflectance + shift), truth, Noise(0.5)
        )
        moved.append((refit.found.natural() - best.found.natural()) * 0.02 / 1e-4)
    expected = np.array(moved).T @ np.array(moved)
    size = np.sqrt(np.diag(expected))
    assert best.panel_covariance / np.outer(size, size) == pytest.approx(
        expected / np.outer(size, size), abs=0.02
    )


def test_without_a_fixed_power_one_singular_value_is_zero() -> None:
    table, truth = make(SALCA)
    free = replace(truth, sought=np.ones(5, bool))
    singular = find_singular(predict(free, table)[1])[0]
    assert singular[-1] < 1e-12 * singular[0]
    assert find_singular(predict(truth, table)[1])[0][-1] > 1e-3
    with pytest.raises(Undetermined, match=r"m, k, power of .*--reference-scan") as caught:
        fit_jointly(table, free)
    assert len([name for name in caught.value.names if name.startswith("power")]) == 5


def test_fewer_rows_than_parameters_are_told() -> None:
    table, truth = make(SALCA)
    few = table.pick(np.arange(len(table)) % 5 == 0)
    with pytest.raises(BadInput, match="8 rows cannot determine 10 parameters"):
        fit_jointly(few, truth)


def test_the_best_of_several_starts_is_taken() -> None:
    table, truth = make(SALCA)
    lost = truth.at(truth.vector() + np.array([0, 5.0, 3.0, 0, 0, 0, 0, 0, 0, 0]))
    found = fit_jointly(table, (lost, truth), Noise(0.5))
    assert found.found.natural() == pytest.approx(
        fit_jointly(table, truth, Noise(0.5)).found.natural(), rel=1e-5
    )


def test_sigma_of_the_rows_is_used() -> None:
    table, truth = make(LOG)
    sigma = np.full(len(table), 0.5)
    sigma[0] = 1e6
    spoilt = table.dn.copy()
    spoilt[0] += 400
    found = fit_jointly(replace(table, dn=spoilt, dn_sigma=sigma), truth)
    assert found.found.natural() == pytest.approx(truth.natural(), rel=0.02, abs=2.0)
    assert found.sigma == pytest.approx(sigma)
