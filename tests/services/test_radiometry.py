"""A profile on a scan: the panel's mean, the laser's power, an explained reflectance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace as replace_struct

from app.core.errors import BadInput, MissingChannel, WrongUse
from app.core.radiometry import chain as chains
from app.core.radiometry.drift import Power
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.profile import ChannelCalibration, Noise, Profile
from app.core.radiometry.range_effect import InverseSquare
from app.formats.cloud import Cloud
from app.model.operations import AddScan, SetDeleted
from app.model.parameters import ScanPower
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.services.compute import compute_file
from app.services.error_budget import explain_reflectance
from app.services.export import export
from app.services.laser_power import measure_by_label, parse_powers, power_from_panel, use_powers
from app.services.leaves import leaves_from_labels, measure_leaves
from app.services.opening import Opening
from app.services.panel_readings import measure_panel
from app.services.profiles import find_profile
from app.services.radiometry import (
    apply_profile,
    check_profile,
    join_profiles,
    take_partial_hits,
    tell_calibration,
)
from app.simulate.virtual_scan import simulate

STEPS = (InverseSquare(5.0), Power(), LogResponse(600.0, 1784.0))
PROFILE = Profile(
    "mine",
    (
        ChannelCalibration(
            "intensity_785",
            STEPS,
            wavelength_nm=785.0,
            saturated=2047.0,
            noise=Noise(3.0),
            fit_covariance=((0.0, 0.0, 0.0), (0.0, 25.0, 0.0), (0.0, 0.0, 4.0)),
            panel_covariance=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 9.0)),
        ),
    ),
)
GREY, POWER, COUNT = 0.5, 0.9, 800


@pytest.fixture
def project() -> Project:
    """A panel of 50 % (label 0) and a darker target (label 1), laser at 90 % of its power."""
    random = np.random.default_rng(7)
    along = random.uniform(4.0, 6.0, 2 * COUNT)
    xyz = np.column_stack([along, random.uniform(-0.2, 0.2, (2 * COUNT, 2))])
    label = np.repeat([0, 1], COUNT)
    rho, away = np.where(label == 0, GREY, 0.2), np.linalg.norm(xyz, axis=1)
    number = chains.respond(chains.with_power(STEPS, POWER), rho, away)
    number += 3.0 * random.standard_normal(2 * COUNT)
    scan = Scan(
        "panels",
        xyz,
        {"intensity_785": number, "label": label},
        (Channel("intensity_785", "intensity_785", 785.0),),
        Pose((0.0, 0.0, 0.0)),
    )
    made = Project()
    made.do(AddScan(made.shelve(scan), scan.name, None))
    return made


KEY = "scan-00001"
PANEL, TARGET = np.arange(COUNT), np.arange(COUNT, 2 * COUNT)


def test_a_panel_is_read_without_a_profile(project: Project) -> None:
    found = measure_panel(project, KEY, PANEL, "intensity_785")
    scan = project.state.scan(KEY).scan
    values = scan.attributes["intensity_785"][PANEL]
    assert (found.dn, found.n, found.partial_known) == (pytest.approx(values.mean()), COUNT, False)
    assert found.sigma == pytest.approx(values.std(ddof=1) / np.sqrt(COUNT))
    assert found.range_m == pytest.approx(np.linalg.norm(scan.xyz[PANEL], axis=1).mean())


def test_deleted_points_of_a_panel_do_not_count(project: Project) -> None:
    project.do(SetDeleted(KEY, PointSet(PANEL[:790])))
    assert measure_panel(project, KEY, PANEL, "intensity_785").n == 10
    project.do(SetDeleted(KEY, PointSet(PANEL[:791])))
    with pytest.raises(BadInput, match="Only 9 of 9"):
        measure_panel(project, KEY, PANEL, "intensity_785")


def test_the_power_comes_from_a_panel_and_puts_the_rest_right(project: Project) -> None:
    apply_profile(project, KEY, PROFILE)
    dim = np.nanmean(project.field(KEY, "reflectance_785")[TARGET])
    assert dim == pytest.approx(0.2 * POWER, rel=0.01)
    (power,) = power_from_panel(project, KEY, PANEL, GREY, 0.01, "Leaf 1")
    assert power.value == pytest.approx(POWER, rel=0.005)
    assert power.sigma == pytest.approx(POWER * 0.02, rel=0.02)
    assert power.origin == "panel of 50 % in Leaf 1"
    use_powers(project, KEY, (power,))
    assert np.nanmean(project.field(KEY, "reflectance_785")[TARGET]) == pytest.approx(0.2, rel=0.01)
    again = power_from_panel(project, KEY, PANEL, GREY, 0.01)[0]
    assert again.value == pytest.approx(power.value, rel=1e-9)
    project.undo()
    assert np.nanmean(project.field(KEY, "reflectance_785")[TARGET]) == pytest.approx(dim)


def test_power_needs_a_profile_that_knows_it(project: Project) -> None:
    with pytest.raises(WrongUse, match="needs a profile"):
        power_from_panel(project, KEY, PANEL, GREY)
    deaf = replace_steps((InverseSquare(5.0), LogResponse(600.0, 1784.0)))
    apply_profile(project, KEY, deaf)
    with pytest.raises(WrongUse, match="no laser power"):
        power_from_panel(project, KEY, PANEL, GREY)
    with pytest.raises(WrongUse, match="no laser power"):
        use_powers(project, KEY, (ScanPower("reflectance_785", 0.9),))
    apply_profile(project, KEY, PROFILE)
    with pytest.raises(WrongUse, match="fraction"):
        power_from_panel(project, KEY, PANEL, 50.0)
    with pytest.raises(WrongUse, match="reflectance_1550"):
        use_powers(project, KEY, (ScanPower("reflectance_1550", 0.9),))


def replace_steps(steps: tuple) -> Profile:  # type: ignore[type-arg]
    """The profile with another chain, of which no covariance is known."""
    channel = ChannelCalibration("intensity_785", steps, wavelength_nm=785.0)
    return Profile("other", (channel,))


def test_a_reflectance_is_explained_as_the_mean_of_its_points(project: Project) -> None:
    apply_profile(project, KEY, PROFILE)
    use_powers(project, KEY, (ScanPower("reflectance_785", POWER, 0.009),))
    told = explain_reflectance(project, KEY, "reflectance_785", TARGET)
    values = project.field(KEY, "reflectance_785", TARGET)
    sigma = project.field(KEY, "reflectance_785_sigma", TARGET)
    assert told.reflectance == pytest.approx(values.mean())
    assert (told.n, dict(told.marks)) == (COUNT, {})
    parts = np.array(list(told.parts.values()))
    assert told.sigma == pytest.approx(np.sqrt(np.nansum(parts**2)))
    assert told.parts["power"] == pytest.approx(told.reflectance * 0.01)
    one = explain_reflectance(project, KEY, "reflectance_785", TARGET[:1])
    assert one.sigma == pytest.approx(sigma[0])
    assert one.parts["noise"] == pytest.approx(told.parts["noise"] * np.sqrt(COUNT), rel=0.05)
    with pytest.raises(WrongUse, match="no channel of a profile"):
        explain_reflectance(project, KEY, "intensity_785", TARGET)


def test_the_table_of_leaves_tells_sigma_by_cause(project: Project) -> None:
    apply_profile(project, KEY, PROFILE)
    leaves_from_labels(project, KEY, "label")
    rows = measure_leaves(project, KEY)
    told = explain_reflectance(project, KEY, "reflectance_785", TARGET)
    assert rows[1]["reflectance_785_sigma"] == pytest.approx(told.sigma)
    assert rows[1]["reflectance_785_sigma_panels"] == pytest.approx(told.parts["panels"])
    assert "intensity_785_sigma" not in rows[1]


def test_powers_are_read_from_words() -> None:
    assert parse_powers(["a=0.9", "b=0.8:0.01"]) == (
        ScanPower("a", 0.9, 0.0, "given"),
        ScanPower("b", 0.8, 0.01, "given"),
    )
    for wrong in ("a", "a=", "a=x", "a=0.9:y", "a=0", "a=-1", "a=0.9:-1"):
        with pytest.raises(WrongUse):
            parse_powers([wrong])


def test_published_salca_turns_simulated_numbers_back_into_truth(tmp_path: Path) -> None:
    scan = simulate("panels", instrument="salca", seed=2).scan
    made = Project()
    made.do(AddScan(made.shelve(scan), scan.name, None))
    apply_profile(made, KEY, find_profile("salca"))
    for nm in (1063, 1545):
        found = made.field(KEY, f"reflectance_{nm}")
        marks = made.field(KEY, f"reflectance_{nm}_mark")
        true = scan.attributes[f"truth_reflectance_{nm}"]
        good = np.isfinite(found)
        assert good.mean() > 0.8
        assert set(np.unique(marks)) <= {0.0, 6.0}
        assert abs(np.median(found[good] / true[good]) - 1.0) < 0.005
        assert np.isnan(made.field(KEY, f"reflectance_{nm}_sigma")).all()
    few = made.known_field(KEY, "reflectance_1063")
    assert few is not None
    assert few.notes["partial hits"].startswith("left out below")
    before = np.isfinite(made.field(KEY, "reflectance_1063")).sum()
    take_partial_hits(made, KEY, True)
    assert np.isfinite(made.field(KEY, "reflectance_1063")).sum() > before


def test_a_scan_that_names_no_instrument_takes_any_profile_of_its_channels() -> None:
    scan = simulate("panels", instrument="salca", seed=2).scan
    made = Project()
    made.do(AddScan(made.shelve(replace(scan, metadata={})), scan.name, None))
    apply_profile(made, KEY, find_profile("salca"))
    made.field(KEY, "reflectance_1063")
    held = made.known_field(KEY, "reflectance_1063")
    assert held is not None
    assert held.notes["partial hits"] == "not looked for: the beam is unknown"


def test_a_file_is_computed_with_a_profile_and_the_report_says_so(tmp_path: Path) -> None:
    scan = simulate("panels", instrument="salca", seed=2).scan
    source = tmp_path / "panels.laz"
    export(Cloud(scan), source)
    opening = Opening(source, profile=find_profile("salca"), powers=("reflectance_1063=0.5",))
    fields = ("reflectance_1063", "reflectance_1063_mark", "ndi")
    report = compute_file(opening, fields, tmp_path / "out.npz")
    told = " ".join(report["warnings"])
    assert "SALCA, Hancock 2017 (published, not yours)" in told
    assert "partial hit" in told
    with np.load(tmp_path / "out.npz") as out:
        bright = np.nanmax(out["reflectance_1063"])
        assert bright > 1.5  # half the power: twice the reflectance
        assert np.isnan(out["ndi"][np.isnan(out["reflectance_1063"])]).all()


def test_errors_that_panel_and_target_share_cancel(project: Project) -> None:
    apply_profile(project, KEY, PROFILE)
    before = explain_reflectance(project, KEY, "reflectance_785", PANEL)
    use_powers(project, KEY, power_from_panel(project, KEY, PANEL, GREY))
    after = explain_reflectance(project, KEY, "reflectance_785", PANEL)
    for part in ("fit", "panels"):  # the panel itself is as sure as its own reflectance
        assert after.parts[part] < 0.02 * before.parts[part]
    assert after.reflectance == pytest.approx(GREY, rel=1e-3)
    other = project.state.scan(KEY).parameters.powers[0]
    apply_profile(project, KEY, replace_steps((Power(), LogResponse(600.0, 1784.0))))
    with pytest.raises(WrongUse, match="another profile"):
        use_powers(project, KEY, (replace_struct(other, pull=(*other.pull, 0.0)),))


def test_a_label_names_the_panel_for_the_power(project: Project) -> None:
    apply_profile(project, KEY, PROFILE)
    (power,) = measure_by_label(project, KEY, "label=0:0.5:0.01")
    assert power == power_from_panel(project, KEY, PANEL, GREY, 0.01, "label 0")[0]
    for wrong in ("label", "label=0", "label=0:x", "label=0:0.5:0.1:2", "=0:0.5", "nix=0:0.5"):
        with pytest.raises(WrongUse):
            measure_by_label(project, KEY, wrong)
    with pytest.raises(BadInput, match="No point has the label 7"):
        measure_by_label(project, KEY, "label=7:0.5")
    with pytest.raises(WrongUse, match="twice"):
        use_powers(project, KEY, (power, power))
    with pytest.raises(WrongUse, match="not a share"):
        use_powers(project, KEY, (ScanPower("reflectance_785", 93.0),))


def test_a_power_that_nobody_measured_is_unknown_and_not_zero(project: Project) -> None:
    apply_profile(project, KEY, PROFILE)
    told = explain_reflectance(project, KEY, "reflectance_785", TARGET)
    assert np.isnan(told.parts["power"])
    assert np.isnan(told.parts["range"])
    assert np.isfinite(told.sigma)
    lines = " ".join(tell_calibration(project, KEY, ["reflectance_785"]))
    assert "laser power taken as 1, not measured" in lines
    assert "from intensity_785" in lines
    use_powers(project, KEY, (ScanPower("reflectance_785", 0.9, 0.0, "given"),))
    project.field(KEY, "reflectance_785")
    assert "laser power 0.9 (given)" in " ".join(
        tell_calibration(project, KEY, ["reflectance_785"])
    )


def test_one_raw_channel_is_not_two_colours() -> None:
    """A DN column of unknown wavelength once became both channels of SALCA, and an NDI."""
    scan = simulate("panels", instrument="salca", seed=2).scan
    one = scan.with_channels((Channel("intensity_1063", "intensity_1063"),))
    made = Project()
    made.do(AddScan(made.shelve(replace(one, metadata={})), one.name, None))
    profile = find_profile("salca")
    other = replace_struct(profile, channels=(
        replace_struct(profile.channels[0], channel="a"),
        replace_struct(profile.channels[1], channel="b"),
    ))  # fmt: skip
    with pytest.raises(MissingChannel, match="cannot be both"):
        apply_profile(made, KEY, other)
    named = one.with_channels((Channel("intensity_1063", "intensity_1063", 1545.0),))
    made = Project()
    made.do(AddScan(made.shelve(replace(named, metadata={})), named.name, None))
    apply_profile(made, KEY, other)
    assert made.state.scan(KEY).channels[0].name == "reflectance_1545"


def test_1545_and_1550_nm_are_two_lasers() -> None:
    scan = simulate("panels", instrument="salca", seed=2).scan
    far = replace_struct(find_profile("salca").channels[1], channel="x", wavelength_nm=1550.0)
    with pytest.raises(MissingChannel):
        check_profile(scan, Profile("faro", (far,)))


def test_profiles_that_were_made_one_by_one_are_joined() -> None:
    first, second = find_profile("salca").channels
    mine = Profile("a", (first,), "salca")
    both = join_profiles(mine, Profile("b", (second,), "salca"))
    assert (both.name, both.channels) == ("b", (first, second))
    again = join_profiles(both, Profile("c", (first,), "salca"))
    assert {c.name for c in again.channels} == {first.name, second.name}
    assert join_profiles(find_profile("salca"), mine) is mine  # published numbers stay out
    other = Profile("d", (second,), "x330")
    assert join_profiles(mine, other) is other
    assert join_profiles(None, other) is other
