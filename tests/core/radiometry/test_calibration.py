"""From panels to a channel: every model on its own data, and every bad table in one sentence."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.radiometry import chain as chains
from app.core.radiometry.budget import error_budget
from app.core.radiometry.calibration import Wishes, calibrate, make_channel
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.marks import reflect
from app.core.radiometry.models import PAPERS, RANGE_EFFECTS, RESPONSES, choose_model
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.range_curve import PolynomialCurve, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.residuals import gather_evidence, score_materials
from app.core.radiometry.salca import SalcaResponse

RHO = np.array([0.04, 0.1, 0.25, 0.45, 0.7, 0.95])
AWAY = np.array([2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0])
TRUE_RESPONSES = {
    "log": LogResponse(600.0, 1780.0),
    "linear": LinearResponse(2.5e-4, 0.05),
    "proportional": Proportional(1500.0),
    "salca": SalcaResponse(137.21, 407.04, 16.83),
}
LEVELS = (3.0, 2.2, 1.5, 1.0, 0.7, 0.4, 0.25)


def true_steps(response: str, effect: str):  # type: ignore[no-untyped-def]
    step = TRUE_RESPONSES[response]
    scale = "additive" if response == "log" else "multiplicative"
    levels = tuple(600 * np.log10(LEVELS)) if response == "log" else LEVELS
    curves = {
        "inverse-square": InverseSquare(8.0),
        "polynomial": PolynomialCurve(scale, tuple(AWAY), levels, 8.0),
        "spline": SplineCurve(scale, tuple(AWAY), levels, 8.0),
        "analytic": AnalyticRange(1.5, 0.18, 0.84, nearest=2.0, farthest=30.0),
        "analytic-inner": AnalyticRange(1.5, 0.18, 0.84, "inner", nearest=2.0, farthest=30.0),
    }
    if not effect:
        return (step,)
    behind = response == "log" and effect in ("polynomial", "spline")
    return (step, curves[effect]) if behind else (curves[effect], step)


def make(steps, noise: float = 0.0, powers: bool = True) -> PanelTable:  # type: ignore[no-untyped-def]
    """A movable and a fixed set of panels in a scan for each range."""
    random = np.random.default_rng(5)
    strength = random.uniform(0.6, 1.0, len(AWAY)) if powers else np.ones(len(AWAY))
    strength[3] = 1.0
    rows = [
        (rho, distance, f"s{k}", f"{kind}{rho:g}", strength[k])
        for k, away in enumerate(AWAY)
        for kind, distance in (("m", away), ("f", 8.0))
        for rho in RHO
    ]
    rho, distance, scan, panel, power = (np.array(column) for column in zip(*rows, strict=True))
    dn = chains.respond(steps, rho * power, distance)
    dn = dn + noise * random.standard_normal(len(dn))
    return make_table(distance, dn, rho, 785.0, scan=scan, panel=panel)


@pytest.mark.parametrize("effect", ["", *RANGE_EFFECTS])
@pytest.mark.parametrize("response", RESPONSES)
def test_every_model_finds_its_own_truth(response: str, effect: str) -> None:
    steps = true_steps(response, effect)
    table = make(steps)
    breaks = tuple(AWAY) if effect in ("polynomial", "spline") else ()
    wishes = Wishes(reference_scan="s3", breaks=breaks)
    found = calibrate(table, choose_model(f"{response}+{effect}".rstrip("+")), wishes)
    assert np.abs(found.fit.residual).max() < 1e-4 * np.abs(table.dn).max()
    assert found.fit.found.natural()[: len(chains.values(steps))] == pytest.approx(
        chains.values(steps), rel=2e-3, abs=1e-3
    )


@pytest.mark.parametrize("name", PAPERS)
def test_the_channel_gives_the_panels_back(name: str) -> None:
    model = choose_model(name)
    effect = model.range_effect.name if model.range_effect else ""
    table = make(true_steps(model.response.name, effect), noise=0.05, powers=False)
    if not effect:
        table = table.pick(table.distance == 8.0).pick(np.arange(48) < 6)
    found = calibrate(table, model, Wishes(reference_scan=None if not effect else "s3"))
    scores = score_materials(found)
    channel = make_channel(found, gather_evidence(found, scores))
    rho, marks = reflect(channel, table.dn, table.distance)
    known = marks == 0
    assert known.mean() > 0.95
    assert rho[known] == pytest.approx(table.reflectance[known], rel=0.1, abs=0.01)
    assert np.shape(channel.fit_covariance) == (len(channel.free), len(channel.free))
    assert channel.evidence is not None
    assert channel.evidence.rmse < 0.01


def test_powers_are_found_beside_a_range_effect() -> None:
    table = make(true_steps("linear", "polynomial"), noise=0.5)
    found = calibrate(table, choose_model("linear+polynomial"), Wishes(reference_scan="s3"))
    random = np.random.default_rng(5)
    truth = random.uniform(0.6, 1.0, len(AWAY))
    truth[3] = 1.0
    assert list(found.fit.powers().values()) == pytest.approx(truth, rel=0.01)
    assert found.fit.power_sigma()["s3"] == 0.0
    assert found.fixed_panels == tuple(f"f{rho:g}" for rho in RHO)
    assert found.reference_range == 8.0


def test_saturated_and_dark_rows_are_left_out_and_counted() -> None:
    table = make(true_steps("log", ""), noise=0.2, powers=False)
    table = table.pick(table.distance == 8.0).pick(np.arange(48) < 6)
    top, low = float(np.sort(table.dn)[-1]), float(table.dn.min())
    found = calibrate(table, choose_model("log"), Wishes(saturated=top, dark=low))
    assert (found.saturated, found.dark, len(found.table)) == (1, 1, 4)
    assert make_channel(found).saturated == top


def small(**columns: object) -> PanelTable:
    rho = np.array([0.1, 0.3, 0.6, 0.9])
    table = make_table(np.full(4, 4.4), 1000 * rho, rho, 785.0, panel=list("abcd"))
    return replace(table, **columns)


def one_panel(count: int) -> PanelTable:
    away = AWAY[:count]
    return make_table(away, 1500.0 - 30 * away, np.full(count, 0.99), 785.0)


@pytest.mark.parametrize(
    ("table", "model", "wishes", "words"),
    [
        (small(), "log+polynomial", Wishes(), "All panels are at 4.4 m.*--model log"),
        (small(distance=np.array([1, 2, 1, 2.0])), "proportional+spline", Wishes(), "3 ranges"),
        (small(), "log", Wishes(saturated=50.0), "All 4 panels are saturated"),
        (small(), "log", Wishes(saturated=200.0), "needs panels of 2 reflectances"),
        (small(dn=np.full(4, 2033.0)), "log", Wishes(), "All 4 rows have 2033 DN, as if saturated"),
        (small(dn=np.array([1, 2, 3, 3.0])), "log", Wishes(), "c and d.*3, as if.*--saturated 3,"),
        (small(dn=1e3 + 1e-10 * np.arange(4)), "log", Wishes(), "does not rise"),
        (small(dn=1e3 - 5e-13 * np.arange(4)), "linear", Wishes(), "does not rise|as if saturated"),
        (one_panel(3), "balduzzi", Wishes(), "2 reflectances.*range effect alone: --model poly"),
        (one_panel(1), "spline", Wishes(), "All panels are at 2 m.*other ranges"),
        (small(), "log", Wishes(breaks=(3.0,)), "no pieces.*--break-at"),
        (small(), "log", Wishes(reference_range=3.0), "no range effect.*--reference-range"),
        (one_panel(3), "spline", Wishes(fixed_panels=("0.99",)), "measures no power"),
        (small(dn=np.array([-200, 300, 600, 900])), "proportional", Wishes(), "Row 1 has -200 DN"),
        (small(dn=np.array([900, 600, 300, 100.0])), "log", Wishes(), "does not rise"),
        (small(), "log", Wishes(fixed_panels=("z",)), "no panel z"),
        (small(), "log", Wishes(reference_scan="z"), "no scan z"),
        (small(reflectance=np.array([10, 30, 60, 90.0])), "log", Wishes(), "percent"),
    ],
)  # fmt: skip
def test_bad_tables_are_refused_in_one_sentence(
    table: PanelTable, model: str, wishes: Wishes, words: str
) -> None:
    with pytest.raises((BadInput, WrongUse), match=words):
        calibrate(table, choose_model(model), wishes)


def test_a_little_below_zero_is_noise() -> None:
    table = small(dn=np.array([-3.0, 300, 600, 900]))
    assert calibrate(table, choose_model("proportional")).fit.freedom == 3


@pytest.mark.parametrize("name", ["sqrt", "log+cubic", "+polynomial", ""])
def test_unknown_models_are_refused_with_all_names(name: str) -> None:
    with pytest.raises(WrongUse, match=r"no calibration model.*salca.*hancock"):
        choose_model(name)


@pytest.mark.parametrize("response", RESPONSES)
@pytest.mark.parametrize("effect", ["", *RANGE_EFFECTS])
@pytest.mark.parametrize("seed", range(3))
def test_nonsense_ends_in_a_sentence_or_a_fit(response: str, effect: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 25))
    table = make_table(
        random.uniform(1, 30, count),
        random.normal(300, 400, count),
        random.uniform(0.01, 1, count),
        785.0,
        panel=[str(k) for k in range(count)],
    )
    model = choose_model(f"{response}+{effect}".rstrip("+"))
    with contextlib.suppress(BadInput, WrongUse):  # anything else is a fault of ours
        found = calibrate(table, model)
        assert np.isfinite(found.fit.found.natural()).all()


def test_as_many_rows_as_parameters_are_solved_and_nothing_is_known_of_the_error() -> None:
    table = small().pick(np.array([True, False, False, True]))
    for model, steps in (("log", LogResponse), ("linear", LinearResponse)):
        found = calibrate(table, choose_model(model))
        assert isinstance(found.fit.found.steps[0], steps)
        assert found.fit.fitted == pytest.approx(table.dn)
        assert (found.fit.freedom, found.fit.noise) == (0, None)
        assert np.isnan([found.fit.low, found.fit.high]).all()
        channel = make_channel(found)
        assert (channel.noise, channel.fit_covariance) == (None, ())
    sure = calibrate(replace(table, dn_sigma=np.full(2, 3.0)), choose_model("log"))
    line = np.stack([np.log10(table.reflectance), np.ones(2)], axis=1)
    expected = 9.0 * np.linalg.inv(line.T @ line)
    assert sure.fit.noise_covariance == pytest.approx(expected)
    assert np.array(make_channel(sure).fit_covariance)[1:, 1:] == pytest.approx(expected)
    with pytest.raises(BadInput, match="needs panels of 2"):
        calibrate(table.pick(np.array([True, False])), choose_model("log"))


@pytest.mark.parametrize("model", ["proportional", "kaasalainen"])
def test_one_panel_at_one_range_is_divided_by(model: str) -> None:
    found = calibrate(one_panel(1), choose_model(model))
    assert found.model.range_effect is None
    assert found.fit.found.natural() == pytest.approx([1440.0 / 0.99])


@pytest.mark.parametrize("model", ["proportional+polynomial", "kaasalainen"])
def test_one_panel_over_ranges_is_divided_by_at_its_own_range(model: str) -> None:
    random = np.random.default_rng(2)
    away = np.array([2.0, 3, 4, 5, 6, 8, 10])
    dn = 1000 * random.uniform(0.5, 1.0, len(away))  # no curve that a few nodes could follow
    found = calibrate(make_table(away, dn, np.full(7, 0.99), 785.0), choose_model(model))
    channel = make_channel(found)
    rho, _ = reflect(channel, 0.4 * dn, away)
    assert rho == pytest.approx(np.full(7, 0.4 * 0.99))
    assert found.fit.freedom == 0


def test_salca_with_several_scans_needs_a_fixed_panel_or_a_word() -> None:
    table = make(true_steps("salca", ""), noise=0.05, powers=False)
    moved = table.pick(np.char.startswith(table.panel, "m"))
    with pytest.raises(BadInput, match=r"7 scans.*--same-power"):
        calibrate(moved, choose_model("salca"))
    found = calibrate(moved, choose_model("salca"), Wishes(same_power=True))
    assert set(found.fit.powers().values()) == {1.0}
    assert calibrate(table, choose_model("log"), Wishes(same_power=True)).fixed_panels == ()
    with pytest.raises(WrongUse, match="--fixed-panel or --same-power"):
        calibrate(table, choose_model("log"), Wishes(same_power=True, fixed_panels=("f0.1",)))


@pytest.mark.parametrize("given", [False, True])
def test_the_error_of_three_panels_is_honest(given: bool) -> None:
    random = np.random.default_rng(11)
    rho = np.array([0.5, 0.25, 0.12])
    true, asked = LogResponse(600.0, 1780.0), np.array([0.35])
    number = true.respond(asked, np.ones(1))
    missed, count = 0, 400
    for _ in range(count):
        dn = true.respond(rho, np.ones(3)) + 3.0 * random.standard_normal(3)
        table = make_table(
            np.full(3, 4.4), dn, rho, 1550.0, dn_sigma=np.full(3, 3.0) if given else None
        )
        channel = make_channel(calibrate(table, choose_model("log")))
        seen = chains.invert(channel.steps, number, np.full(1, 4.4))
        sigma = error_budget(channel, seen, number, np.full(1, 4.4)).fit
        missed += int(abs(seen[0] - asked[0]) > 2.0 * sigma[0])
    assert missed <= 0.08 * count


def test_few_residuals_that_are_small_by_chance_do_not_make_a_given_noise_smaller() -> None:
    table = replace(small(dn=1780 + 600 * np.log10([0.1, 0.3, 0.6, 0.9])), dn_sigma=np.full(4, 3.0))
    fit = calibrate(table, choose_model("log")).fit
    assert fit.scale == 1.0
    kept = np.array(make_channel(calibrate(table, choose_model("log"))).fit_covariance)[1:, 1:]
    assert kept == pytest.approx(fit.noise_covariance, rel=1e-9)
    rough = replace(table, dn=table.dn + np.array([30.0, -30.0, -30.0, 30.0]))
    found = calibrate(rough, choose_model("log"))
    assert found.fit.scale > 1.0
    widened = np.array(make_channel(found).fit_covariance)[1:, 1:]
    wanted = found.fit.noise_covariance * (4.302653 / 1.959964) ** 2
    assert widened == pytest.approx(wanted, rel=1e-6)
