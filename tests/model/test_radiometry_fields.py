"""Reflectance as fields of a scan: lazy, with σ and marks, before the raw channel, undoable."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput, MissingChannel, MissingScanner
from app.core.radiometry.drift import Power
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.marks import BEYOND_RANGE, GOOD, SATURATED
from app.core.radiometry.profile import ChannelCalibration, Noise, Profile
from app.core.radiometry.range_curve import PolynomialCurve
from app.model.codec import decode, encode
from app.model.operations import AddScan, SetParameters
from app.model.parameters import ScanPower
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.services.laser_power import use_powers
from app.services.radiometry import apply_profile, check_profile

ZERO3 = ((0.0,) * 3,) * 3
CURVE = PolynomialCurve("additive", (1.0, 3.56, 10.0), (30.0, 0.0, -200.0), 3.56)
RESPONSE = (Power(), LogResponse(600.0, 1784.0))
PROFILE = Profile(
    "mine",
    tuple(
        ChannelCalibration(
            f"intensity_{nm:g}",
            (*RESPONSE, CURVE),
            wavelength_nm=nm,
            saturated=2047.0,
            nearest=1.0,
            farthest=10.0,
            noise=Noise(2.0),
            fit_covariance=((0.0,) * 5,) * 5,
            panel_covariance=((0.0,) * 5,) * 5,
        )
        for nm in (1063.0, 1545.0)
    ),
    instrument="two_colour",
)


def some_scan(**changes: object) -> Scan:
    """Six points on a line away from the scanner, in two colours."""
    away = np.array([2.0, 3.56, 5.0, 8.0, 12.0, 3.0])
    numbers = {
        "intensity_1063": np.array([1700.0, 1650.0, 1600.0, 1500.0, 1400.0, 2047.0]),
        "intensity_1545": np.array([1600.0, 1550.0, 1500.0, 1400.0, 1300.0, 1500.0]),
    }
    channels = tuple(Channel(n, n, float(n[-4:])) for n in numbers)
    values = {
        "name": "line",
        "xyz": np.stack([away, 0 * away, 0 * away], axis=1),
        "attributes": numbers,
        "channels": channels,
        "pose": Pose((0.0, 0.0, 0.0)),
    }
    return Scan(**(values | changes))  # type: ignore[arg-type]


def open_scan(scan: Scan, profile: Profile | None = PROFILE) -> tuple[Project, str]:
    project = Project()
    key = project.shelve(scan)
    project.do(AddScan(key, scan.name, None))
    if profile is not None:
        apply_profile(project, key, profile)
    return project, key


def test_reflectance_its_sigma_and_its_mark_are_fields() -> None:
    project, key = open_scan(some_scan())
    found = project.field(key, "reflectance_1063")
    scan = project.state.scan(key).scan
    level = np.interp(scan.xyz[:, 0], CURVE.ranges, CURVE.levels)
    wanted = 10 ** ((scan.attributes["intensity_1063"] - level - 1784) / 600)
    wanted[[4, 5]] = np.nan  # too far; saturated
    np.testing.assert_allclose(found, wanted, rtol=1e-12)
    marks = project.field(key, "reflectance_1063_mark")
    assert marks.tolist() == [GOOD, GOOD, GOOD, GOOD, BEYOND_RANGE, SATURATED]
    sigma = project.field(key, "reflectance_1063_sigma")
    np.testing.assert_allclose(sigma, wanted * np.log(10) / 600 * 2.0, rtol=1e-12)


def test_only_the_points_asked_for_are_computed() -> None:
    project, key = open_scan(some_scan())
    asked = np.array([1, 3])
    few = project.field(key, "reflectance_1545", asked)
    assert project.cache.computed(key)["reflectance_1545"] == 2
    np.testing.assert_array_equal(few, project.field(key, "reflectance_1545")[asked])


def test_calibrated_channels_come_first_for_indices_and_fits() -> None:
    project, key = open_scan(some_scan())
    state = project.state.scan(key)
    names = [channel.name for channel in state.channels]
    assert names == ["reflectance_1063", "reflectance_1545", "intensity_1063", "intensity_1545"]
    assert state.channel_in_use("a test").name == "reflectance_1063"
    assert state.channel("reflectance_1545").calibration == "mine"
    near, far = (project.field(key, f"reflectance_{nm}") for nm in (1063, 1545))
    np.testing.assert_allclose(project.field(key, "ndi"), (near - far) / (near + far))


def test_a_profile_is_one_step_and_undo_takes_its_fields_away() -> None:
    project, key = open_scan(some_scan())
    project.undo()
    assert "reflectance_1063" not in project.catalogue(key)
    one, two = (project.field(key, f"intensity_{nm}") for nm in (1063, 1545))
    np.testing.assert_allclose(project.field(key, "ndi"), (one - two) / (one + two))
    project.redo()
    assert np.isfinite(project.field(key, "reflectance_1063")[:4]).all()


def test_the_power_of_a_scan_divides_and_adds_to_sigma() -> None:
    project, key = open_scan(some_scan())
    whole = project.field(key, "reflectance_1063").copy()
    before = project.field(key, "reflectance_1063_sigma").copy()
    other = project.field(key, "reflectance_1545").copy()
    use_powers(project, key, (ScanPower("reflectance_1063", 0.8, 0.04),))
    np.testing.assert_allclose(project.field(key, "reflectance_1063"), whole / 0.8)
    after = project.field(key, "reflectance_1063_sigma")
    np.testing.assert_allclose(after, np.hypot(before / 0.8, whole / 0.8 * 0.05))
    np.testing.assert_array_equal(project.field(key, "reflectance_1545"), other)


def test_an_operation_with_a_profile_survives_the_session_file() -> None:
    project, _ = open_scan(some_scan())
    step = project.history.done[-1]
    arrays: dict[str, np.ndarray] = {}
    again = decode(encode(step, arrays, "a"), arrays)
    assert isinstance(again, SetParameters)
    assert again == step


def test_a_profile_of_another_instrument_is_refused() -> None:
    scan = some_scan(metadata={"instrument": "simulated: FARO LS880"})
    with pytest.raises(BadInput, match=r"two_colour.*LS880"):
        check_profile(scan, PROFILE)
    project, key = open_scan(scan, None)
    with pytest.raises(BadInput):
        apply_profile(project, key, PROFILE)
    assert project.state.scan(key).parameters.profile is None
    assert len(project.history.done) == 1


def test_a_profile_without_a_channel_here_is_refused_with_what_there_is() -> None:
    other = some_scan(channels=(Channel("intensity_1063", "intensity_1063", 690.0),))
    with pytest.raises(MissingChannel, match=r"1063.*690 nm"):
        check_profile(other, PROFILE)
    raw = some_scan().channels
    reflectance = some_scan(channels=tuple(replace(c, kind="reflectance") for c in raw))
    with pytest.raises(MissingChannel, match="reflectance"):
        check_profile(reflectance, PROFILE)


def test_a_channel_is_known_by_its_wavelength_too_and_alone_by_being_alone() -> None:
    scan = some_scan()
    renamed = scan.with_channels((Channel("a", "intensity_1063", 1064.0),))
    project, key = open_scan(renamed)
    assert np.isfinite(project.field(key, "reflectance_1063")[0])
    with pytest.raises(MissingChannel, match="1545"):
        project.field(key, "reflectance_1545")
    alone = scan.with_channels((Channel("intensity", "intensity_1545"),))
    one = msgspec.structs.replace(PROFILE, channels=PROFILE.channels[1:])
    project, key = open_scan(alone, one)
    assert np.isfinite(project.field(key, "reflectance_1545")[0])


def test_a_profile_over_range_needs_the_scanner() -> None:
    project, key = open_scan(some_scan(pose=None))
    with pytest.raises(MissingScanner):
        project.field(key, "reflectance_1063")


def test_decibels_are_taken_as_they_are() -> None:
    numbers = {"Reflectance": np.array([0.0, -10.0, -3.0, 1.0, np.nan, -20.0])}
    channels = (Channel("Reflectance", "Reflectance", 1550.0, "dB"),)
    scan = some_scan(attributes=numbers, channels=channels, pose=None)
    riegl = Profile("RIEGL", (ChannelCalibration("Reflectance", (Decibel(),)),))
    project, key = open_scan(scan, riegl)
    found = project.field(key, "reflectance_linear")
    np.testing.assert_allclose(found, 10 ** (numbers["Reflectance"] / 10))
    assert project.state.scan(key).channels[0].wavelength_nm == 1550.0
    assert np.isnan(project.field(key, "reflectance_linear_sigma")).all()
