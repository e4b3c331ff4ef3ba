"""Corrected channels as fields: lazy, per leaf, with σ and marks, never mixed in an index."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from app.core.errors import BadInput, MissingScanner, WrongUse
from app.core.indices import NAMED
from app.core.workflows.marks import GOOD, NO_CORRECTION, SMALL_BRACKET
from app.model.codec import decode, encode
from app.model.corrections import Correction
from app.model.operations import AddScan, SetParameters, SetPose
from app.model.parameters import Parameters
from app.model.project import Project
from app.model.scan import Scan
from app.services.corrections import apply_corrections, remove_corrections
from app.services.leaves import leaves_from_labels, measure_leaves
from app.simulate.scenes import leaf_row_scan

NIR, SWIR = "reflectance_1063", "reflectance_1545"


@pytest.fixture(scope="module")
def row() -> Scan:
    """Flat leaves at 0, 15 … 75°, without noise."""
    return leaf_row_scan(step_deg=0.08)


@pytest.fixture
def opened(row: Scan) -> tuple[Project, str]:
    project = Project()
    key = project.shelve(row)
    project.do(AddScan(key, row.name, None))
    return project, key


def wf2(source: str = NIR, b: float = 1.0, **more: object) -> Correction:
    return Correction(source, "wf2", {"b": b}, **more)  # type: ignore[arg-type]


def test_a_corrected_channel_stands_beside_its_source(opened: tuple[Project, str]) -> None:
    project, key = opened
    before = project.field(key, NIR)
    apply_corrections(project, key, [wf2(origin="the test")])
    channel = project.state.scan(key).channel(f"{NIR}_wf2")
    assert (channel.wavelength_nm, channel.kind) == (1063.0, "reflectance")
    assert "b = 1 (the test)" in channel.calibration
    angle = np.deg2rad(project.field(key, "incidence"))
    values, mark = project.field(key, f"{NIR}_wf2"), project.field(key, f"{NIR}_wf2_mark")
    good = mark == GOOD
    np.testing.assert_allclose(values[good], (before / np.cos(angle))[good], rtol=1e-12)
    assert (mark[np.cos(angle) < 0.25] == SMALL_BRACKET).all()
    assert np.isnan(values[~good]).all()
    np.testing.assert_array_equal(project.field(key, NIR), before)
    assert project.state.scan(key).channel_in_use("this").name == NIR
    project.undo()
    assert f"{NIR}_wf2" not in project.catalogue(key)


def test_an_index_never_mixes_workflows(opened: tuple[Project, str]) -> None:
    project, key = opened
    plain = project.field(key, "ndi")
    apply_corrections(project, key, [wf2(NIR, 0.9), wf2(SWIR, 0.5)])
    np.testing.assert_array_equal(project.field(key, "ndi"), plain)
    a, b = (project.field(key, f"{name}_wf2") for name in (NIR, SWIR))
    np.testing.assert_allclose(project.field(key, "ndi_wf2"), (a - b) / (a + b), rtol=1e-12)
    remove_corrections(project, key, [f"{SWIR}_wf2"])
    assert "ndi_wf2" not in project.catalogue(key)
    assert f"{NIR}_wf2" in project.catalogue(key)


def test_leaves_may_have_corrections_of_their_own(opened: tuple[Project, str]) -> None:
    project, key = opened
    leaves = leaves_from_labels(project, key, "truth_leaf")
    own = wf2(b=0.5, leaves=(leaves[1],))
    apply_corrections(project, key, [own])
    mark, leaf = project.field(key, f"{NIR}_wf2_mark"), project.field(key, "leaf")
    assert set(np.unique(leaf[mark == GOOD])) == {2.0}
    assert (mark[leaf == 1.0] == NO_CORRECTION).all()
    apply_corrections(project, key, [wf2(b=0.2)])
    values, angle = project.field(key, f"{NIR}_wf2"), np.deg2rad(project.field(key, "incidence"))
    for number, b in ((1.0, 0.2), (2.0, 0.5)):
        here = (leaf == number) & np.isfinite(values)
        wanted = (project.field(key, NIR) / (1 - b * (1 - np.cos(angle))))[here]
        np.testing.assert_allclose(values[here], wanted, rtol=1e-12)
    apply_corrections(project, key, [wf2(b=0.7, leaves=(leaves[1],))])
    assert len(project.state.scan(key).parameters.corrections) == 2
    with pytest.raises(WrongUse, match="Two corrections"):
        apply_corrections(project, key, [wf2(b=0.7, leaves=(leaves[1], leaves[2]))])


def test_only_points_asked_for_are_computed_and_a_change_renews_only_its_own(
    opened: tuple[Project, str],
) -> None:
    project, key = opened
    apply_corrections(project, key, [wf2(NIR), wf2(SWIR)])
    some = np.arange(40)
    project.field(key, f"{NIR}_wf2", some)
    project.field(key, f"{SWIR}_wf2", some)
    counts = project.cache.computed(key)
    assert counts[f"{NIR}_wf2"] == counts["incidence"] == 40
    apply_corrections(project, key, [wf2(NIR, 0.8)])
    project.field(key, f"{NIR}_wf2", some)
    project.field(key, f"{SWIR}_wf2", some)
    counts = project.cache.computed(key)
    assert (counts[f"{NIR}_wf2"], counts[f"{SWIR}_wf2"], counts["incidence"]) == (80, 40, 40)


def test_sigma_has_the_parts_of_channel_angle_and_fit(opened: tuple[Project, str]) -> None:
    project, key = opened
    apply_corrections(project, key, [wf2(b=0.8, covariance={"b": {"b": 0.01}})])
    some = np.flatnonzero(project.field(key, f"{NIR}_wf2_mark") == GOOD)[:500]
    angle, sigma_angle = (
        np.deg2rad(project.field(key, n, some)) for n in ("incidence", "incidence_sigma")
    )
    value = project.field(key, NIR, some)
    bracket = 1 - 0.8 * (1 - np.cos(angle))
    parts = (
        value * 0.8 * np.sin(angle) / bracket**2 * sigma_angle,
        value * (1 - np.cos(angle)) / bracket**2 * 0.1,
    )
    found = project.field(key, f"{NIR}_wf2_sigma", some)
    np.testing.assert_allclose(found, np.hypot(*parts), rtol=1e-9)
    title = project.catalogue(key)[f"{NIR}_wf2_sigma"].title
    assert "of angle and fit only" in title


def test_leaf_tables_have_the_corrected_channels_and_indices(opened: tuple[Project, str]) -> None:
    project, key = opened
    leaves = leaves_from_labels(project, key, "truth_leaf")
    apply_corrections(project, key, [wf2(NIR, 1.0), wf2(SWIR, 1.0)])
    measured = measure_leaves(project, key, leaves[:3])
    names = [f"{NIR}_wf2_mean", f"{NIR}_wf2_marked", "ndi_of_means", "ndi_wf2_of_means"]
    assert all(name in measured[0] for name in names)
    project.do(SetPose(key, None))
    assert f"{NIR}_wf2_mean" not in measure_leaves(project, key, leaves[:1])[0]


def test_what_cannot_be_corrected_is_refused(opened: tuple[Project, str]) -> None:
    project, key = opened
    apply_corrections(project, key, [wf2()])
    with pytest.raises(WrongUse, match="corrected already"):
        apply_corrections(project, key, [wf2(f"{NIR}_wf2")])
    with pytest.raises(WrongUse, match="There are"):
        remove_corrections(project, key, ["nothing"])
    scan = project.state.scan(key).scan
    channels = tuple(replace_kind(channel) for channel in scan.channels)
    other = project.shelve(scan.with_channels(channels))
    project.do(AddScan(other, "dB", None))
    with pytest.raises(BadInput, match="dB"):
        apply_corrections(project, other, [wf2()])
    project.do(SetPose(other, None))
    with pytest.raises(MissingScanner):
        apply_corrections(project, other, [wf2()])


def replace_kind(channel: object) -> object:
    from dataclasses import replace as change

    return change(channel, kind="dB")  # type: ignore[type-var]


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"workflow": "wf2", "values": {}}, "b is missing"),
        ({"workflow": "wf2", "values": {"b": 1.0, "m": 0.3}}, "m is not one"),
        ({"workflow": "wf3", "values": {"k_d": 0.5}}, "m is missing"),
        ({"workflow": "wf3", "values": {"k_d": 1.5, "m": 0.3}}, "k_d = 1.5"),
        ({"workflow": "wf4", "values": {}}, "wf2, wf3"),
        ({"workflow": "wf2", "values": {"b": 1.0}, "least_bracket": 0.0}, "bracket"),
        ({"workflow": "wf2", "values": {"b": 1.0}, "fitted": (1.0, 0.5)}, "angles"),
    ],
)
def test_corrections_that_cannot_be(values: dict[str, object], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        Correction("a", **values)  # type: ignore[arg-type]


def test_corrections_survive_a_session() -> None:
    full = Correction(NIR, "wf3", {"k_d": 1.0}, {"k_d": {"k_d": 0.1}}, 0.3, (0.1, 1.2), "x", ("l",))
    parameters = replace(Parameters(), corrections=(full,), synthetic_footprint=0.05)
    step = decode(encode(SetParameters("scan-00001", parameters), {}, "a"), {})
    assert isinstance(step, SetParameters)
    assert step.parameters == parameters


def test_smoothing_makes_fields_of_channels_and_indices(opened: tuple[Project, str]) -> None:
    project, key = opened
    assert not any("smoothed" in name for name in project.catalogue(key))
    apply_corrections(project, key, [wf2(NIR), wf2(SWIR)])
    old = project.state.scan(key).parameters
    project.do(SetParameters(key, replace(old, synthetic_footprint=0.03), "drag"))
    a, b = (project.field(key, f"{name}_smoothed") for name in (NIR, SWIR))
    np.testing.assert_allclose(project.field(key, "ndi_smoothed"), (a - b) / (a + b), rtol=1e-12)
    assert np.nanstd(a) < np.nanstd(project.field(key, NIR))
    assert "ndi_wf2_smoothed" in project.catalogue(key)
    project.do(SetParameters(key, replace(old, synthetic_footprint=0.2), "drag"))
    assert np.nanstd(project.field(key, f"{NIR}_smoothed")) < np.nanstd(a)
    project.undo()
    assert "ndi_smoothed" not in project.catalogue(key)
    with pytest.raises(WrongUse, match="diameter"):
        Parameters(synthetic_footprint=-1.0)
    assert set(NAMED) <= set(project.catalogue(key))
