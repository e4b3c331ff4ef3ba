"""Parts of the bench are what they say, its figures come from known ones, and it runs."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.marks import reflect
from app.core.radiometry.panels import make_table
from app.services.bench.radiometry import budgets, fits, goals, hits, pictures, responses, waveforms
from app.services.bench.radiometry.budgets import Tally
from app.services.bench.radiometry.goals import Goal
from app.services.bench.radiometry.hancock import NOISES, TABLE_III, make_panels, true_steps
from app.services.bench.radiometry.new_scans import TARGETS, scan_targets
from app.services.bench.radiometry.plans import PLANS, carry_out
from app.services.bench.radiometry.range_methods import WORLDS, compare_ranges
from app.services.bench.radiometry.run import TABLES, bench_radiometry, refuse_bench_radiometry
from app.services.bench.radiometry.sights import ends_of, see_panels, take_instrument
from app.services.bench.results import write_bench


@pytest.fixture(scope="module")
def quick():
    return bench_radiometry(quick=True)


def test_the_quick_bench_writes_what_it_says(quick, tmp_path):
    assert tuple(table.name for table in quick.tables) == TABLES
    refuse_bench_radiometry(tmp_path, overwrite=False)
    files = write_bench(quick, tmp_path)
    assert (tmp_path / "radiometry.png").stat().st_size > 20_000
    assert {file.name for file in files} == {file.name for file in tmp_path.iterdir()}
    with pytest.raises(BadInput):
        refuse_bench_radiometry(tmp_path, overwrite=False)


def test_ours_is_more_exact_than_what_is_simpler(quick):
    rows = {(r["inverse"], r["way"]): r for r in find(quick, "radiometry_inverses")}
    for inverse in responses.list_inverses():
        assert rows[inverse.name, "ours"]["largest_error"] < 1e-9
    for nm in (1063, 1545):
        assert rows[f"SALCA {nm} nm", "table"]["largest_error"] > 1e-6
        assert rows[f"SALCA {nm} nm", "brentq"]["time"] > 10


def test_a_range_effect_that_the_world_does_not_have_is_told_by_its_error(quick):
    rows = {(r["instrument"], r["range_effect"]): r for r in find(quick, "radiometry_ranges")}
    for world in WORLDS:
        assert rows[world.instrument, "monotone spline"]["rmse_percent"] < 2.5
        assert rows[world.instrument, "none"]["rmse_percent"] > 50
    assert rows["salca", "analytic, outer"]["rmse_percent"] < 0.8


def test_the_joint_fit_beats_the_stages(quick):
    rows = {(r["wavelength_nm"], r["noise"], r["fit"]): r for r in find(quick, "radiometry_fits")}
    for nm in TABLE_III:
        joint, staged = (rows[nm, "1 % + 1 DN", name] for name in ("joint", "staged"))
        assert joint["failed"] == 0
        assert joint["rmse_percent"] < staged["rmse_percent"]


def test_goals_name_every_kind_once(quick):
    rows = find(quick, "radiometry_goals")
    assert len({(r["group"], r["goal"]) for r in rows}) == len(rows)
    assert sum(r["goal"] == "million points per second" for r in rows) == len(
        responses.list_inverses()
    )


def find(bench, name):
    (table,) = (table for table in bench.tables if table.name == name)
    return table.rows


@pytest.mark.parametrize(
    ("goal", "verdict", "limit"),
    [
        (Goal("a", "b", 1.0, low=1.0), "reached", "≥ 1"),
        (Goal("a", "b", 0.9, low=1.0), "NOT REACHED", "≥ 1"),
        (Goal("a", "b", 1.1, high=1.0), "NOT REACHED", "≤ 1"),
        (Goal("a", "b", 0.95, 0.9, 1.1), "reached", "0.9 to 1.1"),
        (Goal("a", "b", float("nan"), 0.9, 1.1), "NOT REACHED", "0.9 to 1.1"),
    ],
)
def test_verdicts(goal, verdict, limit):
    assert goal.verdict == verdict
    assert goal.as_row()["limit"] == limit


def test_the_ratio_farthest_from_one_is_judged():
    rows = [
        {"instrument": "x", "power_from": "none", "of": of, "ratio": ratio}
        for of, ratio in (("point", 1.05), ("point", 0.5), ("mean", 1.3), ("mean", 1.0))
    ]
    point, mean = goals.judge_budget(rows)
    assert point.found == 0.5
    assert mean.found == pytest.approx(np.sqrt((1.3**2 + 1.0) / 2))


def test_an_error_without_a_value_is_infinite():
    assert responses._find_error(np.array([1.0, np.nan]), np.ones(2)) == np.inf
    assert responses._find_error(np.array([1.0, 1.1]), np.ones(2)) == pytest.approx(0.1)


def test_panels_face_the_scanner_and_are_hit_in_full():
    tool = take_instrument("ls880")
    sight = see_panels(tool, (0.9, 0.1), 5.0, 3)
    assert min(np.bincount(sight.panel)) >= 144
    assert np.allclose(sight.light[sight.of(0)], 0.9, rtol=1e-3)
    assert np.allclose(sight.light[sight.of(1)], 0.1, rtol=1e-3)
    assert sight.distance.mean() == pytest.approx(5.0, abs=0.002)
    again, other = (see_panels(tool, (0.9, 0.1), 5.0, seed) for seed in (3, 4))
    assert (again.dn == sight.dn).all()
    assert (other.dn != sight.dn).any()


def test_neighbours_share_no_noise():
    dn = see_panels(take_instrument("ls880"), (0.5,), 5.0, 3).dn[:, 0]
    assert abs(np.corrcoef(dn[1:], dn[:-1])[0, 1]) < 0.2


def test_ends_of_the_scale():
    assert ends_of(take_instrument("x330")) == (-2048.0, 2033.0)
    assert ends_of(take_instrument("two_colour")) == (-np.inf, np.inf)


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: f"{plan.instrument}, {plan.drift}")
def test_a_calibration_gives_back_new_targets(plan):
    calibrated = carry_out(plan, 5)
    scan = scan_targets(plan, calibrated, 5)
    for k, channel in enumerate(calibrated.channels):
        rho, _ = reflect(channel, scan.dn[:, k], scan.distance, float(scan.power[k]))
        for number, target in enumerate(TARGETS):
            mine = scan.target == number
            assert np.nanmean(rho[mine]) == pytest.approx(target, rel=0.08)
            assert np.allclose(scan.rho[mine, k], target, rtol=1e-3)


def test_figures_of_known_tallies():
    tallies = [Tally(4e-4, 0.01, (3e-4, 0.0, 1e-4, 0.0, 0.0), 10, 1)] * 2
    row = budgets._tell((PLANS[0], 0, 0.5, "point"), tallies)
    assert (row["rms_percent"], row["predicted_percent"], row["ratio"]) == (4.0, 4.0, 1.0)
    assert (row["bias_percent"], row["largest"], row["lost"]) == (2.0, "noise", 2)
    assert row["noise_percent"] == pytest.approx(100 / 0.5 * np.sqrt(3e-4), rel=0.01)


def test_a_fit_that_gives_up_has_failed():
    def fail(table):
        raise BadInput("no")

    table = make_panels(1545, NOISES[0], np.random.default_rng(0))
    assert fits.attempt(fail, table, 1545).error == np.inf
    assert fits.attempt(lambda _: true_steps(1545), table, 1545).error < 1e-12


def test_a_curve_without_steps_goes_through_panels_that_it_can_follow():
    from app.services.bench.radiometry.range_methods import _fit_whole_linear, _fit_whole_log

    away, rho = (a.ravel() for a in np.meshgrid(np.arange(1.0, 9.0), (0.1, 0.5, 0.9)))
    linear = 40.0 + 1000.0 * rho * (1.0 - 0.05 * away)
    logarithmic = 600.0 * np.log10(rho) + 1700.0 - 3.0 * away**2
    for fit, dn in ((_fit_whole_linear, linear), (_fit_whole_log, logarithmic)):
        invert = fit(make_table(away, dn, rho, 785.0))
        assert np.allclose(invert(dn, away), rho, rtol=1e-7)


def test_records_hold_the_energy_that_they_say():
    case = waveforms.Case(0.0)
    records = waveforms.draw_records(case, 20)
    assert np.allclose(
        records.samples.sum(axis=1) * waveforms.STEP / waveforms.AREA, records.energy
    )
    highest = np.argmax(records.samples, axis=1)
    assert (np.abs(highest - records.place) <= 0.5 + 1e-9).all()
    double = waveforms.draw_records(waveforms.Case(0.0, apart=4.0), 20)
    assert np.allclose(
        double.samples.sum(axis=1) * waveforms.STEP / waveforms.AREA, 1.5 * double.energy
    )


def test_jumps_and_holes():
    seen = hits.see(hits.QUICK_VIEWS[0])
    jump, holes = (hits.find_level(seen, holes=holes) for holes in (False, True))
    assert (holes <= jump).all()
    assert 0.1 < jump.mean() < 0.9
    row, column = seen.cells.row, seen.cells.column
    rim = (row == 0) | (column == 0)
    assert not holes[rim].any()


def test_hits_without_any_have_no_share():
    assert np.isnan(hits._percent(np.empty(0)))
    assert hits._percent(np.array([True, False])) == 50.0


def test_a_picture_without_errors_on_a_log_axis(quick, tmp_path):
    pictures.draw_costs(quick.tables[1:6], tmp_path / "costs.png")
    assert (tmp_path / "costs.png").stat().st_size > 20_000


def test_ranges_between_panels():
    for world in WORLDS:
        assert all(
            a < b < c
            for a, b, c in zip(world.ranges, world.between, world.ranges[1:], strict=False)
        )
        assert world.reference in world.ranges


def test_salca_responds_as_the_simulator():
    tool = take_instrument("salca")
    sight = see_panels(tool, (0.5,), 8.0, 1)
    for k, nm in enumerate((1063, 1545)):
        dn = chains.respond(true_steps(nm), np.array([0.5]), np.array([8.0]))[0]
        assert sight.dn[:, k].mean() == pytest.approx(dn, abs=1.0)


def test_compare_ranges_counts_targets():
    rows = compare_ranges(quick=True).rows
    assert all(0 <= row["lost"] < row["targets"] for row in rows)
