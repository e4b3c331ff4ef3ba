"""Samples × channels: gathered, fitted in one batch, kept in one step, written."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled, WrongUse
from app.core.progress import LiveProgress
from app.model.fit_method import Method
from app.model.operations import SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.services.curves import fit_again, result_of
from app.services.fit import FitReport
from app.services.lab.fit_table import SampleLeaves, each_leaf, record_fits, tabulate_fits
from app.services.lab.gather import gather
from app.services.lab.method import fit_by
from app.services.lab.table_files import fits_as_text, write_fits
from app.services.lab.uncertainty import bootstrap

Rig = tuple[Project, str, list[str]]
BECKMANN = "lambert-beckmann"


def test_points_come_with_their_leaves(rig: Rig) -> None:
    project, key, leaves = rig
    project.do(SetDeleted(key, PointSet(np.arange(10))))
    found = gather(project, key, [leaves[2], leaves[0]], "near")
    assert len(found) == 790
    assert found.point.min() == 10
    assert set(found.leaf[found.point >= 800]) == {0}
    assert set(found.leaf[found.point < 400]) == {1}
    assert len(found.of_leaf(1)) == 390
    whole = gather(project, key, (), "near")
    assert len(whole) == 1190
    assert set(whole.leaf) == {-1}
    with pytest.raises(WrongUse, match="leaf-00009"):
        gather(project, key, ["leaf-00009"], "near")


def test_a_table_of_leaves_and_channels(rig: Rig) -> None:
    project, key, leaves = rig
    samples = (*each_leaf(project, key), SampleLeaves("all", tuple(leaves)))
    table = tabulate_fits(project, key, samples, ("near", "far"), BECKMANN, Method("bins"))
    assert len(table.report.fits) == 8
    for (sample, channel), cell in table.cells.items():
        keys = next(s.leaves for s in samples if s.name == sample)
        measured = gather(project, key, keys, channel)
        alone = fit_by(Method("bins"), BECKMANN, measured.angle, measured.value)
        assert cell.result is not None
        assert cell.result.values == pytest.approx(alone.values, rel=1e-6)
        assert cell.result.values["k_d"] == pytest.approx(
            0.8 if channel == "near" else 0.5, abs=0.05
        )


def test_all_fits_are_one_step_and_replay_to_the_same(rig: Rig) -> None:
    project, key, _ = rig
    method = Method("bins", width=4.0)
    table = tabulate_fits(
        project, key, each_leaf(project, key), ("near", "far"), BECKMANN, method, fixed={"m": 0.3}
    )
    assert not project.state.fits
    records = record_fits(project, table)
    assert len(records) == len(project.state.fits) == 6
    assert project.history.done[-1].title == "Fit 6 curves"
    for record in records:
        assert record.method_used == method
        again = fit_again(project, record)
        assert again.values == pytest.approx(result_of(record).values, rel=1e-6)
        assert again.parameters["m"].fixed
    project.undo()
    assert not project.state.fits


def test_a_cell_that_cannot_be_fitted_says_why(rig: Rig) -> None:
    project, key, leaves = rig
    project.do(SetDeleted(key, PointSet(np.arange(2, 400))))
    samples = each_leaf(project, key, leaves[:2])
    table = tabulate_fits(project, key, samples, ("near",), BECKMANN)
    bad, good = table.report.fits
    assert bad.result is None
    assert "needs more pairs" in bad.warnings[0]
    assert good.result is not None
    assert len(record_fits(project, table)) == 1
    assert project.history.done[-1].title == f"Fit {BECKMANN} to near"
    nothing = tabulate_fits(project, key, samples[:1], ("near",), BECKMANN)
    with pytest.raises(BadInput, match="Nothing could be fitted"):
        record_fits(project, nothing)


def test_tables_that_cannot_be_are_refused(rig: Rig) -> None:
    project, key, leaves = rig
    twice = (SampleLeaves("a", (leaves[0],)), SampleLeaves("a", (leaves[1],)))
    with pytest.raises(WrongUse, match="Two samples are named a"):
        tabulate_fits(project, key, twice, ("near",), BECKMANN)
    with pytest.raises(BadInput, match="at least one"):
        tabulate_fits(project, key, twice[:1], (), BECKMANN)
    stop = LiveProgress(print, lambda: True)
    with pytest.raises(Cancelled):
        tabulate_fits(project, key, twice[:1], ("near",), BECKMANN, progress=stop)


@pytest.fixture
def report(rig: Rig) -> FitReport:
    project, key, _ = rig
    samples = each_leaf(project, key)
    return tabulate_fits(project, key, samples, ("near", "far"), BECKMANN).report


def test_a_long_table_has_a_row_for_each_parameter(report: FitReport) -> None:
    rows = list(csv.DictReader(io.StringIO(fits_as_text(report, "csv"))))
    assert len(rows) == 3 * 2 * 3
    first, result = rows[1], report.fits[0].result
    assert result is not None
    assert (first["sample"], first["channel"], first["parameter"]) == ("Leaf 1", "near", "k_d")
    assert float(first["value"]) == result.values["k_d"]
    low, high = result.interval("k_d") or (0.0, 0.0)
    assert (float(first["low_95"]), float(first["high_95"])) == (low, high)
    assert float(first["aicc"]) == result.aicc
    assert {row["unit"] for row in rows} == {"value", "1"}


def test_a_wide_table_is_samples_by_channels(report: FitReport) -> None:
    rows = list(csv.reader(io.StringIO(fits_as_text(report, "tsv", wide=True)), delimiter="\t"))
    assert rows[0] == ["parameter", "quantity", "sample", "near", "far"]
    assert [row[:3] for row in rows[1:4]] == [["f", "value", f"Leaf {i}"] for i in (1, 2, 3)]
    k_d = {row[2]: row[3:] for row in rows if row[:2] == ["k_d", "value"]}
    for one in report.fits:
        place = ("near", "far").index(one.group["channel"])
        assert one.result is not None
        assert float(k_d[one.group["sample"]][place]) == one.result.values["k_d"]


def test_latex_is_escaped_rounded_and_balanced(report: FitReport) -> None:
    text = fits_as_text(report, "tex")
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == 3
    assert r"\caption{k\_d: Lambert--Beckmann, fitted to single points." in text
    assert r"sample & near & far \\" in text
    assert text.count("{") == text.count("}")
    (line,) = [row for row in text.splitlines() if row.startswith("Leaf 1")][1:2]
    result = report.fits[0].result
    assert result is not None
    sd = result.parameters["k_d"].sd
    assert sd is not None
    shown = line.split("&")[1].strip().strip("$").split(r" \pm ")
    assert float(shown[0]) == pytest.approx(result.values["k_d"], abs=sd / 10)
    assert float(shown[1]) == pytest.approx(sd, rel=0.05)


def test_files_by_their_ending(report: FitReport, tmp_path: Path) -> None:
    write_fits(report, tmp_path / "fits.json")
    plain = json.loads((tmp_path / "fits.json").read_text())
    assert [one["group"]["channel"] for one in plain["fits"][:2]] == ["near", "far"]
    assert plain["method"]["to"] == "points"
    with pytest.raises(BadInput, match="exists already"):
        write_fits(report, tmp_path / "fits.json")
    with pytest.raises(WrongUse, match=r"\.csv, \.tsv, \.tex, \.json"):
        write_fits(report, tmp_path / "fits.xlsx")
    assert [path.name for path in tmp_path.glob("fits*")] == ["fits.json"]


def test_a_name_is_never_run_by_a_spreadsheet(rig: Rig) -> None:
    project, key, leaves = rig
    samples = (SampleLeaves("=1+2", tuple(leaves)),)
    report = tabulate_fits(project, key, samples, ("near",), "lambert").report
    assert "'=1+2" in fits_as_text(report, "csv")
    bare = FitReport((replace(report.fits[0], group={}),))
    with pytest.raises(BadInput, match="sample and channel"):
        fits_as_text(bare, "csv", wide=True)


def test_the_bootstrap_of_a_table_of_leaves(rig: Rig) -> None:
    project, key, leaves = rig
    measured = gather(project, key, leaves, "near")
    for method in (Method(), Method("bins")):
        rows = bootstrap(method, BECKMANN, measured, count=200)
        f = next(row for row in rows if row.name == "f")
        assert (f.low, f.high) == pytest.approx((0.5, 0.5), rel=0.02)
        assert f.known == 1.0
        assert "200 draws of 3 leaves. Only 3 leaves" in f.words
    with pytest.raises(BadInput, match="at least two leaves"):
        bootstrap(Method(), BECKMANN, measured.of_leaf(0), count=20)
    with pytest.raises(WrongUse, match="least squares"):
        bootstrap(Method("edge"), BECKMANN, measured, count=20)
