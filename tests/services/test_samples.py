"""Two scanners of the same leaves, from other places with other steps, against the truth."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, LeafscopeError, MissingChannel, WrongUse
from app.core.sample_means import pair_nearest
from app.formats.cloud import Cloud
from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Channel, Scan
from app.services.export import export
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening
from app.services.samples import WHOLE, SampleTable, Wanted, tabulate_files, tabulate_samples
from app.simulate.beam import grid_of_field
from app.simulate.detector import Ideal
from app.simulate.simulation import run_simulation
from app.simulate.virtual_scan import arrange, find_instrument, find_scene

ASKED = Wanted(("nldi",), full_hits=True)
NM = {"x330": 1550, "hds6100": 690}


def look(tool: str, step_deg: float, place: tuple[float, float, float]) -> Scan:
    """The row of leaves at known tilts, as an instrument sees it that reports reflectance."""
    instrument = replace(find_instrument(tool), detector=Ideal())
    scene = arrange(find_scene("leaf_row"), instrument, step_deg).scene
    grid = grid_of_field(step_deg, (-15.0, 6.0), (-4.0, 1.5))
    scan = run_simulation(scene, grid, instrument, place, 3).scan
    return replace(scan, name=tool)


@pytest.fixture(scope="module")
def scans() -> dict[str, Scan]:
    return {
        "x330": look("x330", 0.03, (0.0, 0.0, 1.6)),
        "hds6100": look("hds6100", 0.04, (0.05, 0.35, 1.7)),
    }


@pytest.fixture(scope="module")
def files(
    scans: Mapping[str, Scan], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Opening, ...]:
    folder = tmp_path_factory.mktemp("samples")
    for tool, scan in scans.items():
        export(Cloud(scan), folder / f"{tool}.laz")
    return tuple(Opening(folder / f"{tool}.laz") for tool in scans)


def tabulate(
    files: tuple[Opening, ...], out: Path, wanted: Wanted = ASKED, **how: object
) -> SampleTable:
    label = {} if "by_leaf" in how else {"label_field": "truth_leaf"}
    return tabulate_files(files, out, wanted, **{**label, **how})  # type: ignore[arg-type]


def true_nldi(scans: Mapping[str, Scan], leaf: int) -> float:
    mean = {}
    for tool, nm in NM.items():
        known = scans[tool].attributes
        mine = (known["truth_leaf"] == leaf) & (known["truth_hit_fraction"] > 0.98)
        mean[nm] = float(known[f"truth_reflectance_{nm}"][mine].astype(float).mean())
    return (mean[690] - mean[1550]) / (mean[690] + mean[1550])


def test_indices_of_means_are_the_truth(
    scans: Mapping[str, Scan], files: tuple[Opening, ...], tmp_path: Path
) -> None:
    table = tabulate(files, tmp_path / "full.csv")
    assert [row["sample"] for row in table.rows] == [f"truth_leaf {k}" for k in range(6)]
    *seen, steepest = table.rows
    # The second scanner sees the last leaf edge-on: its beam is wider than what it sees of it.
    assert steepest["reflectance_1550_n"] > 100
    assert steepest["reflectance_690_n"] == 0
    assert steepest["nldi_of_means"] is None
    off = [row["nldi_of_means"] - true_nldi(scans, k) for k, row in enumerate(seen)]
    assert np.abs(off).max() < 0.005
    sure = [row["nldi_of_means_se"] for row in seen]
    assert (np.array(sure) > 0.0).all()
    assert np.abs(np.array(off) / sure).mean() < 4.0
    assert not table.pairs
    assert "nldi_mean_of_points" not in table.rows[0]
    assert table.rows[0]["reflectance_1550_n"] != table.rows[0]["reflectance_690_n"]
    partly = tabulate(files, tmp_path / "all.csv", Wanted(("nldi",)))
    worse = [partly.rows[k]["nldi_of_means"] - true_nldi(scans, k) for k in range(5)]
    assert np.abs(worse).max() > 5 * np.abs(off).max()  # what the rims of the leaves do


def test_the_table_is_written_as_it_is_told(files: tuple[Opening, ...], tmp_path: Path) -> None:
    out = tmp_path / "table.csv"
    table = tabulate(files, out)
    with out.open(newline="") as file:
        written = list(csv.DictReader(file))
    assert len(written) == 6
    for row, told in zip(written, table.rows, strict=True):
        assert row["sample"] == told["sample"]
        value = told["nldi_of_means"]
        assert row["nldi_of_means"] == ("" if value is None else repr(value))
        assert int(row["reflectance_690_n"]) == told["reflectance_690_n"]


def test_pairs_only_where_asked_and_their_shares_are_told(
    scans: Mapping[str, Scan], files: tuple[Opening, ...], tmp_path: Path
) -> None:
    wanted = replace(ASKED, pair_within=0.001)
    table = tabulate(files, tmp_path / "pairs.csv", wanted)
    told = table.pairs["nldi"]
    assert told["pairs"] == sum(int(row["nldi_mean_of_pairs_n"]) for row in table.rows)
    shares = told["matched_shares"]
    assert set(shares) == {"x330", "hds6100"}
    assert all(0.01 < share < 1.0 for share in shares.values())
    flat = table.rows[0]
    assert flat["nldi_mean_of_pairs"] == pytest.approx(true_nldi(scans, 0), abs=0.01)
    assert flat["nldi_matched_share_reflectance_690"] > 0.0
    wider = tabulate(files, tmp_path / "wide.csv", replace(wanted, pair_within=0.004))
    assert wider.pairs["nldi"]["pairs"] > told["pairs"]


def test_pairs_at_edges_are_biased(scans: Mapping[str, Scan]) -> None:
    one, two = scans["x330"], scans["hds6100"]
    pairs = pair_nearest(one.xyz, two.xyz, 0.002)
    a, b = ({k: v[rows].astype(float) for k, v in scan.attributes.items()}
            for scan, rows in ((one, pairs.first), (two, pairs.second)))  # fmt: skip
    leaf = (a["truth_leaf"] >= 0) & (b["truth_leaf"] >= 0)
    share = np.minimum(a["truth_hit_fraction"], b["truth_hit_fraction"])
    off = []
    for kind in ("reflectance_{}", "truth_reflectance_{}"):
        red, infrared = b[kind.format(690)], a[kind.format(1550)]
        off.append((red - infrared) / (red + infrared))
    error = off[0] - off[1]
    assert abs(error[leaf & (share > 0.98)].mean()) < 0.001
    assert abs(error[leaf & (share < 0.9)].mean()) > 0.01


def test_leaves_found_in_each_scan_are_matched_by_place(
    scans: Mapping[str, Scan], files: tuple[Opening, ...], tmp_path: Path
) -> None:
    table = tabulate(files, tmp_path / "found.csv", by_leaf=True)
    both = [row for row in table.rows if row["nldi_of_means"] is not None]
    found = sorted(float(row["nldi_of_means"]) for row in both)
    truths = [true_nldi(scans, k) for k in range(5)]
    near = [min(abs(value - truth) for truth in truths) for value in found]
    assert sum(off < 0.02 for off in near) >= 4


def test_without_leaves_a_scan_is_one_sample(files: tuple[Opening, ...], tmp_path: Path) -> None:
    table = tabulate_files(files, tmp_path / "whole.csv", Wanted(("nldi", "lri")))
    (row,) = table.rows
    assert row["sample"] == WHOLE
    red, infrared = row["reflectance_690_mean"], row["reflectance_1550_mean"]
    assert row["lri_of_means"] == pytest.approx(infrared / red)
    assert row["nldi_of_means"] == pytest.approx((red - infrared) / (red + infrared))


def test_one_scan_with_both_channels_has_both_means(leaves: Scan, tmp_path: Path) -> None:
    project = Project()
    project.do(AddScan(project.shelve(leaves), "leaves", None))
    leaves_from_labels(project, "scan-00001", "truth_leaf")
    row = tabulate_samples(project, ["scan-00001"], Wanted(("ndi",))).rows[0]
    mine = leaves.attributes["truth_leaf"] == 0
    a, b = (leaves.channel_values(f"reflectance_{nm}")[mine] for nm in (1063, 1545))
    assert row["ndi_mean_of_points"] == pytest.approx(((a - b) / (a + b)).mean())
    assert row["ndi_of_means"] == pytest.approx((a.mean() - b.mean()) / (a.mean() + b.mean()))
    assert row["ndi_mean_of_points"] != row["ndi_of_means"]
    with pytest.raises(WrongUse, match="nothing to pair"):
        tabulate_samples(project, ["scan-00001"], Wanted(("ndi",), pair_within=0.001))


def test_raw_numbers_are_warned_about_and_equal_names_kept_apart(
    files: tuple[Opening, ...], scans: Mapping[str, Scan], tmp_path: Path
) -> None:
    for tool, nm in NM.items():
        raw = replace(
            scans[tool],
            attributes={"intensity": 1000 * scans[tool].attributes[f"reflectance_{nm}"]},
            channels=(Channel("intensity", "intensity", float(nm), "DN"),),
        )
        export(Cloud(raw), tmp_path / f"{tool}.laz")
    raw_files = tuple(Opening(tmp_path / f"{tool}.laz") for tool in NM)
    table = tabulate_files(raw_files, tmp_path / "raw.csv", Wanted(("nldi",)))
    assert "raw DN" in table.warnings[0]
    assert {"intensity_mean", "intensity_scan2_mean"} <= set(table.rows[0])
    assert tabulate(files, tmp_path / "fine.csv").warnings == ()


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"wanted": Wanted(("nonsense",))}, WrongUse, "no index"),
        ({"wanted": Wanted(("ndi",))}, MissingChannel, "1063"),
        ({"wanted": Wanted((), pair_within=0.001)}, WrongUse, "index of each pair"),
        ({"wanted": Wanted(("nldi",), pair_within=-1.0)}, WrongUse, "positive distance"),
        ({"label_field": "nothing"}, WrongUse, "no field"),
        ({"label_field": "truth_incidence"}, BadInput, "decimals"),
        ({"by_leaf": True, "label_field": "truth_leaf"}, WrongUse, "not both"),
    ],
)
def test_what_cannot_be_is_said_and_nothing_written(
    files: tuple[Opening, ...], tmp_path: Path, change: dict[str, object],
    error: type[LeafscopeError], says: str,
) -> None:  # fmt: skip
    with pytest.raises(error, match=says):
        tabulate(files, tmp_path / "table.csv", **change)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_the_same_file_twice_and_samples_without_company(
    files: tuple[Opening, ...], scans: Mapping[str, Scan], tmp_path: Path
) -> None:
    with pytest.raises(WrongUse, match="given twice"):
        tabulate((files[0], files[0]), tmp_path / "table.csv")
    other = dict(scans["x330"].attributes)
    other["truth_leaf"] = np.where(other["truth_leaf"] >= 0, other["truth_leaf"] + 50, -1)
    export(Cloud(replace(scans["x330"], attributes=other)), tmp_path / "other.laz")
    with pytest.raises(BadInput, match="more than one of the scans"):
        tabulate((Opening(tmp_path / "other.laz"), files[1]), tmp_path / "table.csv")
    assert not (tmp_path / "table.csv").exists()
