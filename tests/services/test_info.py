"""The shape of ``leafscope info --json`` is a contract."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from app.formats import e57
from app.formats.cloud import Cloud
from app.formats.saving import save
from app.model.scan import Channel, Grid, Pose, Scan
from app.services.info import describe_opened, describe_scans
from app.services.opening import Opening

KEYS = [
    "points", "grid", "scanner", "channels", "bounds", "attributes", "details", "warnings",
]  # fmt: skip


def make_scan(shift: float = 0.0) -> Scan:
    xyz = np.array([[0.0, 1.0, 2.0], [np.nan, 0.0, 0.0], [3.0, -1.0, 5.0]]) + shift
    values = {"reflectance_1063": np.array([0.1, 0.2, 0.3], np.float32)}
    return Scan(
        "s",
        xyz,
        values,
        (Channel("reflectance_1063", "reflectance_1063", 1063.0, "reflectance"),),
        Pose((1.0 + shift, 2.0, 3.0)),
        Grid(2, 4, np.array([0, 0, 1], np.int32), np.array([0, 1, 3], np.int32)),
        warnings=("from the file",),
    )


def test_one_scan() -> None:
    facts = describe_scans([make_scan()])
    assert list(facts) == KEYS
    assert facts == {
        "points": 3,
        "grid": [2, 4],
        "scanner": [1.0, 2.0, 3.0],
        "channels": [{"name": "reflectance_1063", "wavelength_nm": 1063.0, "kind": "reflectance"}],
        "bounds": [[0.0, -1.0, 2.0], [3.0, 1.0, 5.0]],
        "attributes": ["reflectance_1063"],
        "details": {},
        "warnings": ["from the file", "1 points have coordinates that are not finite."],
    }
    assert json.loads(json.dumps(facts, allow_nan=False)) == facts


def test_several_scans_have_totals() -> None:
    facts = describe_scans([make_scan(), make_scan(10.0)])
    assert list(facts) == [*KEYS, "scans"]
    assert facts["points"] == 6
    assert facts["grid"] == [2, 4]  # both agree
    assert facts["scanner"] is None  # they differ
    assert len(facts["channels"]) == 1
    assert facts["bounds"] == [[0.0, -1.0, 2.0], [13.0, 11.0, 15.0]]
    assert [part["scanner"][0] for part in facts["scans"]] == [1.0, 11.0]


def test_nothing_is_null() -> None:
    facts = describe_scans([Scan("s", np.empty((0, 3)))])
    assert facts == {
        "points": 0, "grid": None, "scanner": None, "channels": [], "bounds": None,
        "attributes": [], "details": {}, "warnings": [],
    }  # fmt: skip
    both = describe_scans([Scan("s", np.empty((0, 3)))] * 2)
    assert both["bounds"] is None


def test_a_file(tmp_path: Path) -> None:
    save(tmp_path / "a.e57", Cloud(make_scan()), e57.write, sidecar=False)
    facts = describe_opened(Opening(tmp_path / "a.e57"))
    assert facts["points"] == 3
    assert facts["grid"] == [2, 4]
    assert facts["scanner"] == [1.0, 2.0, 3.0]
    assert facts["bounds"] == [[0.0, -1.0, 2.0], [3.0, 1.0, 5.0]]


@pytest.mark.data
def test_the_pump(shared_data: Path) -> None:
    facts = describe_opened(
        Opening(shared_data / "pump_e57_gridded" / "pumpAVisualReferenceImage.e57")
    )
    assert facts["points"] == 155_201
    assert facts["grid"] == [1074, 345]
    assert facts["scanner"] is None
    assert [channel["name"] for channel in facts["channels"]] == ["intensity"]
