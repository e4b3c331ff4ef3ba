"""Wrinkles of the leaves of a scan, from each source of a curve."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled, MissingScanner, WrongUse
from app.core.progress import LiveProgress
from app.core.units import to_degrees
from app.core.wrinkling.leaf import Choices
from app.formats.cloud import Cloud
from app.model.leaf import Leaf
from app.model.operations import MarkGhosts, PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel
from app.services.beams import beam_of_instrument
from app.services.curves import fit_leaves, use_fit
from app.services.export import export
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, add_scans, set_parameters
from app.services.wrinkles.gather import gather_leaves
from app.services.wrinkles.goniometer import read_goniometer
from app.services.wrinkles.measure import measure_wrinkles
from app.services.wrinkles.request import (
    CurveInUse,
    OwnCurve,
    ScanCurve,
    SpeciesSource,
    TableCurve,
    WrinkleRequest,
)
from app.services.wrinkles.run import tabulate_wrinkles
from app.services.wrinkles.scale import find_scale
from app.services.wrinkles.species import find_species_curve, list_species_curves
from app.services.wrinkles.table import COLUMNS, tabulate
from app.simulate.virtual_scan import simulate

CHANNEL = "reflectance_1545"
K_D, M = 0.72, 0.30


@pytest.fixture(scope="module")
def scan():
    """A row of flat leaves at 0, 15, … 75°."""
    return simulate("leaf_row", seed=3, step_deg=0.036).scan


@pytest.fixture
def project(scan):
    """A project with that scan and its leaves, and the key of the scan."""
    made = Project()
    key = add_scans(made, [scan])[0]
    set_parameters(made, key, beam=beam_of_instrument("two_colour"))
    leaves_from_labels(made, key, "truth_leaf")
    return made, key


@pytest.fixture
def table(tmp_path):
    """A goniometer table of the leaf that the scene is made of."""
    path = tmp_path / "gonio.csv"
    omega = np.deg2rad(np.arange(0, 86, 5))
    specular = np.exp(-(np.tan(omega) ** 2) / M**2) / np.cos(omega) ** 5
    value = 0.27 * (K_D * np.cos(omega) + (1 - K_D) * specular)
    rows = [f"{a},{v}" for a, v in zip(np.rad2deg(omega), value, strict=True)]
    path.write_text("\n".join(["angle,value", *rows]))
    return path


def measure(project, source, offset=None, **more):
    made, key = project
    return measure_wrinkles(made, key, WrinkleRequest(source, offset, CHANNEL, **more))


def test_a_goniometer_table_gives_angles_and_says_so(project, table, scan):
    found = measure(project, TableCurve(table))
    assert [leaf.calibration.case for leaf in found.leaves] == ["known"] * 6
    assert "each with its error" in found.leaves[0].calibration.sentence
    right, valid = [], 0
    for leaf in found.leaves[1:4]:
        true = scan.attributes["truth_incidence"][leaf.points]
        ok = leaf.judged.angles.valid
        right.append(np.abs(to_degrees(leaf.judged.angles.omega[ok]) - true[ok]) <= 5)
        valid += ok.sum()
    assert np.concatenate(right).mean() > 0.95
    assert valid > 1000


def test_a_table_row_per_leaf(project, table):
    rows = tabulate(measure(project, TableCurve(table)))
    assert len(rows) == 6
    for degrees, row in zip((15, 30, 45), rows[1:4], strict=True):
        assert row["omega_plane_deg"] == pytest.approx(degrees, abs=1.0)
        assert row["omega_mean_deg"] == pytest.approx(degrees, abs=2.0)
        assert row["wrinkle_index_deg"] < 1.5
        assert row["sigma_reflectance_median_deg"] == 0.0
        assert row["valid"] + sum(n for k, n in row.items() if k.startswith("n_")) == row["points"]
        assert row["noise"] == pytest.approx(0.03, rel=0.15)
    assert rows[5]["n_steeper_than_the_limit"] > 0


def test_an_offset_of_the_right_kind(project, table):
    plain = tabulate(measure(project, TableCurve(table)))
    darker = tabulate(measure(project, TableCurve(table), 1.1))
    assert darker[3]["offset_kind"] == "factor"
    assert darker[3]["omega_mean_deg"] > plain[3]["omega_mean_deg"] + 3


def test_a_levelled_leaf_claims_differences_only(project, table):
    found = measure(project, TableCurve(table), "fit")
    leaf = found.leaves[2]
    assert leaf.calibration.case == "levelled"
    assert "not ω itself" in leaf.calibration.sentence
    assert abs(to_degrees(leaf.judged.spread.mean)) < 1.0
    assert leaf.judged.offset.sigma > 0.0
    assert found.leaves[5].judged is None
    assert "steepest valid angle" in found.leaves[5].refusal


def test_a_species_gives_an_interval(project):
    found = measure(project, SpeciesSource("maple", reflectance=0.27))
    leaf = found.leaves[3]
    assert leaf.calibration.case == "species"
    assert "8 %" in leaf.calibration.sentence
    parts = leaf.judged.angles.parts
    ok = leaf.judged.angles.valid
    assert np.nanmedian(parts["reflectance"][ok]) > np.nanmedian(parts["noise"][ok])
    with pytest.raises(BadInput, match="--reflectance"):
        measure(project, SpeciesSource("maple"))  # four leaves face the scanner, five are needed
    with pytest.raises(WrongUse, match="Species:"):
        measure(project, SpeciesSource("oak"))


def test_a_flat_leaf_has_no_curve_of_its_own(project):
    found = measure(project, OwnCurve())
    assert [leaf.judged for leaf in found.leaves] == [None] * 6
    assert "no curve of its own" in found.leaves[0].refusal
    with pytest.raises(WrongUse, match="no offset"):
        measure(project, OwnCurve(), 1.2)


def test_with_nothing_known_one_curve_goes_through_all_leaves(project, scan):
    made, key = project
    found = measure_wrinkles(made, key, WrinkleRequest(channel=CHANNEL))
    for leaf in found.leaves[:4]:
        assert leaf.calibration.case == "levelled"
        assert "6 leaves of this scan" in leaf.calibration.curve.origin
    for leaf in found.leaves[1:4]:  # flat ones at 15, 30 and 45°
        assert leaf.judged.angles.valid.mean() > 0.85
        assert abs(to_degrees(leaf.judged.spread.mean)) < 0.5
        assert to_degrees(leaf.judged.spread.sd) < 3.0
        assert to_degrees(leaf.judged.index.high) < 1.5
    omega = np.deg2rad(np.array([15.0, 30.0, 45.0, 55.0]))
    curve = found.leaves[0].calibration.curve
    specular = np.exp(-(np.tan(omega) ** 2) / M**2) / np.cos(omega) ** 5
    true = K_D * np.cos(omega) + (1 - K_D) * specular
    ratio = curve.evaluate(omega) / true
    assert ratio / ratio.mean() == pytest.approx(1.0, abs=0.04)
    for leaf in found.leaves[4:]:
        assert "steepest valid angle" in leaf.refusal
        assert "Scan it from where it faces the scanner more." in leaf.refusal
    with pytest.raises(WrongUse, match="levelled"):
        measure(project, ScanCurve(), 1.2)
    levelled = measure(project, ScanCurve(), "fit").leaves[2].judged
    assert levelled.offset == found.leaves[2].judged.offset


def test_walls_and_panels_are_left_out_of_that_curve(scan):
    wall = np.flatnonzero(scan.attributes["truth_surface"] == 6)
    bright = scan.attributes[CHANNEL].copy()
    bright[wall] *= 2.0
    made = Project()
    key = add_scans(made, [replace(scan, attributes={**scan.attributes, CHANNEL: bright})])[0]
    set_parameters(made, key, beam=beam_of_instrument("two_colour"))
    leaves_from_labels(made, key, "truth_leaf")
    made.do(PutLeaf("leaf-00009", Leaf("leaf-00009", key, "Wall", PointSet(wall), ())))
    found = measure((made, key), ScanCurve())
    assert len(found.leaves) == 7
    assert "6 leaves of this scan" in found.leaves[0].calibration.curve.origin


def test_leaves_at_one_angle_get_the_cosine_and_are_told_so(project):
    made, key = project
    for leaf in made.state.leaves_of(key)[1:]:
        made.do(PutLeaf(leaf.key, None))
    found = measure(project, ScanCurve())
    assert found.leaves[0].calibration.curve.origin == "cosine (Lambert)"
    assert "--species NAME --offset fit" in " ".join(found.warnings)


def test_numbers_of_an_unknown_scale_get_no_cosine(scan):
    blank = Project()
    raw = (Channel("raw", CHANNEL, None, "DN"),)
    key = add_scans(blank, [replace(scan, channels=raw, metadata={})])[0]
    leaves_from_labels(blank, key, "truth_leaf")
    for leaf in blank.state.leaves_of(key)[1:]:
        blank.do(PutLeaf(leaf.key, None))
    with pytest.raises(BadInput, match="--instrument"):
        measure_wrinkles(blank, key, WrinkleRequest(channel="raw"))


def test_all_tables_have_the_same_columns(project, table):
    for source, offset in ((ScanCurve(), None), (OwnCurve(), None), (TableCurve(table), "fit")):
        rows = tabulate(measure(project, source, offset))
        assert [tuple(row) for row in rows] == [COLUMNS] * 6
    assert rows[5]["wrinkle_index_deg"] is None
    assert rows[5]["refusal"]


def test_an_offset_of_dn_is_told_as_a_factor_too(scan):
    made = Project()
    light = 600.0 * np.log10(scan.attributes[CHANNEL].clip(1e-6))
    dn = Channel("dn", "dn", 785.0, "DN")
    raw = replace(scan, attributes={**scan.attributes, "dn": light + 50.0}, channels=(dn,))
    key = add_scans(made, [raw])[0]
    leaves_from_labels(made, key, "truth_leaf")
    set_parameters(made, key, beam=beam_of_instrument("two_colour"))
    request = WrinkleRequest(SpeciesSource("maple"), "fit", "dn", "ls880")
    rows = tabulate(measure_wrinkles(made, key, request))
    # 0.27 is the leaf's own reflectance: the 50 DN come on top of it.
    assert rows[2]["offset_as_factor"] == pytest.approx(0.27 * 10 ** (50 / 600), rel=0.3)
    assert rows[2]["offset"] == pytest.approx(600 * np.log10(rows[2]["offset_as_factor"]))
    assert rows[2]["case"] == "levelled"


def test_ghosts_are_never_valid_and_in_no_mean(project, table, scan):
    made, key = project
    before = measure(project, TableCurve(table)).leaves[2]
    valid = before.points[before.judged.angles.valid]
    marked = valid[:: max(len(valid) // 40, 1)]
    dark = scan.attributes[CHANNEL].copy()
    dark[marked] = 100.0  # a mean that holds one would be nonsense
    made.do(MarkGhosts(key, ghosts=PointSet(np.sort(marked))))
    other = Project()
    bright = add_scans(other, [replace(scan, attributes={**scan.attributes, CHANNEL: dark})])[0]
    set_parameters(other, bright, beam=beam_of_instrument("two_colour"))
    leaves_from_labels(other, bright, "truth_leaf")
    other.do(MarkGhosts(bright, ghosts=PointSet(np.sort(marked))))
    for document, scan_key in ((made, key), (other, bright)):
        request = WrinkleRequest(TableCurve(table), channel=CHANNEL)
        after = measure_wrinkles(document, scan_key, request).leaves[2]
        inside = np.isin(after.points, marked)
        assert not after.judged.angles.valid[inside].any()
        assert np.abs(to_degrees(after.judged.spread.mean)) < 2.0
        row = tabulate(measure_wrinkles(document, scan_key, request))[2]
        assert row["n_ghosts"] >= len(marked)


def test_a_leaf_of_ghosts_says_so(project, table):
    made, key = project
    leaf = made.state.leaves_of(key)[2]
    made.do(MarkGhosts(key, ghosts=leaf.members))
    found = measure(project, TableCurve(table)).leaves[2]
    assert found.judged is None
    assert "are no ghosts" in found.refusal


def test_the_curve_in_use(project):
    made, key = project
    with pytest.raises(BadInput, match="No angular curve"):
        measure(project, CurveInUse())
    keys = [leaf.key for leaf in made.state.leaves_of(key)]
    use_fit(made, fit_leaves(made, key, keys, "lambert-beckmann", CHANNEL))
    known = measure(project, CurveInUse(of_this_leaf=True))
    assert known.leaves[2].calibration.case == "known"
    assert measure(project, CurveInUse()).leaves[2].calibration.case == "species"
    assert known.leaves[2].judged.plane.incidence == pytest.approx(np.deg2rad(30), abs=0.02)


def test_without_means_the_error_is_larger(project, table):
    means = measure(project, TableCurve(table)).leaves[2].judged
    single = measure(project, TableCurve(table), choices=Choices(means=False)).leaves[2].judged
    assert np.nanmedian(single.angles.parts["noise"]) > 2 * np.nanmedian(
        means.angles.parts["noise"]
    )


def test_saturated_values_are_marked(project, table):
    found = measure(project, TableCurve(table), saturated=0.2)
    row = tabulate(found)[1]
    assert row["n_saturated"] > 0.5 * row["points"]


def test_what_the_scan_lacks_is_said(project, scan, table):
    made, key = project
    set_parameters(made, key, beam=None)
    from app.model.parameters import Parameters

    blank = Project()
    other = add_scans(blank, [scan.with_pose(None)])[0]
    leaves_from_labels(blank, other, "truth_leaf")
    with pytest.raises(MissingScanner):
        measure_wrinkles(blank, other, WrinkleRequest(TableCurve(table), channel=CHANNEL))
    assert Parameters().beam is None
    third = add_scans(blank, [scan])[0]
    leaves_from_labels(blank, third, "truth_leaf")
    channel = blank.state.scan(third).channel(CHANNEL)
    gathered = gather_leaves(blank, third, None, channel, None)
    assert "in part" in gathered.warnings[0]
    assert all(points.full is None for _, _, points in gathered)


def test_it_can_be_cancelled(project, table):
    made, key = project
    with pytest.raises(Cancelled):
        measure_wrinkles(
            made, key, WrinkleRequest(TableCurve(table), channel=CHANNEL),
            progress=LiveProgress(lambda *_: None, lambda: True),
        )  # fmt: skip


def test_scales(scan):
    dn = Channel("i", "i", 785.0, "DN")
    assert find_scale(dn, scan, "ls880").per_decade == 600.0
    assert find_scale(dn, scan, "ls880").saturated == 2047
    assert find_scale(Channel("i", "i", None, "dB"), scan).per_decade == 10.0
    assert find_scale(Channel("i", "i", None, "linear"), scan).scale == "linear"
    with pytest.raises(WrongUse, match="Calibrate"):
        find_scale(dn, scan, "salca")
    with pytest.raises(WrongUse):
        find_scale(dn, scan, "nobody")


def test_species_are_found_by_wavelength():
    assert len(list_species_curves()) == 66
    assert find_species_curve("Birch", 785.0).wavelength_nm == 764.8
    assert find_species_curve("rose", 785.0).wavelength_nm == 795.0
    with pytest.raises(WrongUse, match="wavelength"):
        find_species_curve("birch", None)
    with pytest.raises(WrongUse, match="within"):
        find_species_curve("birch", 1064.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("angle,value\n", "no rows"),
        ("a,b\n1,2\n", "no column"),
        ("angle,value\n10,x\n", "not a number"),
        ("angle,value\n-10,0.2\n20,0.1\n", "0° to 90°"),
        ("angle,value\n100,0.2\n", "0° to 90°"),
        ("angle,value\n10,\n", "no row with"),
        ("angle,value\n10,0.2\n20,0.1\n", "more pairs"),
        ("angle,value\n0.1,1\n0.3,0.9\n0.5,0.8\n0.7,0.7\n1.1,0.6\n", "radians"),
    ],
)
def test_tables_that_are_none(tmp_path, text, says):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(BadInput, match=says):
        read_goniometer(path, "linear")


def test_from_a_file_to_a_table_and_a_picture(scan, table, tmp_path):
    file, out = tmp_path / "row.laz", tmp_path / "out.json"
    export(Cloud(scan), file)
    report = tabulate_wrinkles(
        Opening(file), out, WrinkleRequest(TableCurve(table), channel=CHANNEL), "truth_leaf",
        {"beam": beam_of_instrument("two_colour")}, tmp_path / "map.png",
    )  # fmt: skip
    assert len(report.rows) == 6
    assert json.loads(out.read_text(encoding="utf-8"))["leaves"][1]["claim"]
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"
    assert report.as_dict()["written"] == [str(out), str(tmp_path / "map.png")]
    request = WrinkleRequest(TableCurve(table), channel=CHANNEL)
    for wrong in (table, tmp_path / "x.xls", out, tmp_path / "none" / "a.csv"):
        with pytest.raises((BadInput, WrongUse)):
            tabulate_wrinkles(Opening(file), wrong, request, "truth_leaf")
    with pytest.raises(WrongUse, match=r"\.png"):
        tabulate_wrinkles(Opening(file), tmp_path / "a.csv", request, picture=tmp_path / "a.gif")
