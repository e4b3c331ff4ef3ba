"""Own indices: written, renamed, removed, tried; wavelengths find their channels."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import MissingChannel, WrongUse
from app.model.corrections import Correction
from app.model.parameters import Formula
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.services.corrections import apply_corrections
from app.services.formula_values import nearest_channel, try_formula, write_symbol
from app.services.formulas import put_formula, remove_formula
from app.services.opening import add_scans
from app.services.synthetic_footprints import index_in


@pytest.fixture
def opened() -> tuple[Project, str]:
    near, far = np.array([0.4, 0.5, 0.6, np.nan]), np.array([0.2, 0.2, 0.0, 0.1])
    channels = (Channel("near", "near", 1063.0, "reflectance"),
                Channel("far", "far", 1545.0, "reflectance"))  # fmt: skip
    xyz = np.column_stack((np.full(4, 3.0), np.arange(4.0), np.zeros(4)))
    scan = Scan("s", xyz, {"near": near, "far": far}, channels, Pose((0, 0, 0), known_by="given"))
    project = Project()
    (key,) = add_scans(project, [scan])
    return project, key


def names(project: Project, key: str) -> list[str]:
    return [formula.name for formula in project.state.scan(key).parameters.formulas]


def test_it_is_written_renamed_in_place_and_removed(opened: tuple[Project, str]) -> None:
    project, key = opened
    for name in ("one", "two"):
        picks = put_formula(project, key, Formula(name, "r1060 / r1550"))
        assert [pick.channel for pick in picks] == ["near", "far"]
    put_formula(project, key, Formula("first", "near / far"), instead_of="one")
    assert names(project, key) == ["first", "two"]
    project.undo()
    assert names(project, key) == ["one", "two"]
    remove_formula(project, key, "one")
    assert names(project, key) == ["two"]
    with pytest.raises(WrongUse, match="no index one"):
        remove_formula(project, key, "one")


@pytest.mark.parametrize("name", ["", "2nd", "a b", "ndi", "near", "two"])
def test_names_that_are_none_or_taken_are_refused(opened: tuple[Project, str], name: str) -> None:
    project, key = opened
    for own in ("one", "two"):
        put_formula(project, key, Formula(own, "near"))
    with pytest.raises(WrongUse):
        put_formula(project, key, Formula(name, "near / far"), instead_of="one")
    assert names(project, key) == ["one", "two"]


def test_its_values_are_counted_as_numpy_counts_them(opened: tuple[Project, str]) -> None:
    project, key = opened
    found = try_formula(project, key, "r1063 / r1545", None)
    expected = np.array([2.0, 2.5])
    assert (found.count, found.undefined) == (2, 2)
    assert (found.low, found.high) == (2.0, 2.5)
    assert found.mean == pytest.approx(expected.mean())
    assert found.sd == pytest.approx(expected.std(ddof=1))
    none = try_formula(project, key, "near / 0", np.array([0]))
    assert (none.count, none.undefined) == (0, 1)


def test_the_nearest_channel_of_a_wavelength(opened: tuple[Project, str]) -> None:
    project, key = opened
    pick = nearest_channel(project, key, 1070.5)
    assert (pick.channel, pick.symbol, pick.distance_nm) == ("near", "r1070_5", 7.5)
    assert [write_symbol(nm) for nm in (564.3, 900.0, 20000.0)] == ["r564_3", "r900", "r9999"]
    bare = Scan("b", np.zeros((1, 3)), {"i": np.ones(1)}, (Channel("i", "i"),))
    (other,) = add_scans(project, [bare])
    with pytest.raises(MissingChannel):
        nearest_channel(project, other, 900.0)


def test_an_own_index_can_be_had_of_corrected_channels(opened: tuple[Project, str]) -> None:
    project, key = opened
    put_formula(project, key, Formula("mine", "r1060 / r1550"))
    made = [Correction(name, "wf2", {"b": 1.0}) for name in ("near", "far")]
    apply_corrections(project, key, made)
    assert index_in(project, key, "mine_wf2").channels == ("near_wf2", "far_wf2")
    assert index_in(project, key, "mine").channels == ("near", "far")
