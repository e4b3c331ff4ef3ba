"""A series: a file per step, a table of them, and what is left after a cancel."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled, LeafscopeError, WrongUse
from app.core.progress import LiveProgress
from app.services.reading import read_file
from app.services.simulation import Targets, simulate_file
from app.services.simulation_order import Order
from app.services.simulation_series import simulate_series

STAGE = Order("goniometer", step_deg=0.2)
ANGLES = "stage.angle_deg=0:60:30"


def read_table(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_folder_gets_a_file_per_step_and_a_table(tmp_path: Path) -> None:
    out = tmp_path / "new" / "stage"
    report = simulate_series(STAGE, ANGLES, Targets(out, tmp_path / "leaves.csv"))
    rows = read_table(out / "series.csv")
    assert list(rows[0]) == ["file", "key", "value", "points"]
    assert [row["file"] for row in rows] == [f"goniometer_angle_deg_{a}.laz" for a in (0, 30, 60)]
    assert {row["key"] for row in rows} == {"stage.angle_deg"}
    assert [row["value"] for row in rows] == ["0", "30", "60"]
    for row in rows:
        (scan,) = read_file(out / row["file"])
        assert len(scan) == int(row["points"])
        angle = scan.attributes["truth_incidence"][scan.attributes["truth_leaf"] == 0]
        assert np.median(angle) == pytest.approx(float(row["value"]), abs=1)
    assert report["points"] == sum(int(row["points"]) for row in rows)
    assert [step["value"] for step in report["steps"]] == [0, 30, 60]
    leaves = read_table(tmp_path / "leaves.csv")
    assert [float(row["tilt_deg"]) for row in leaves] == pytest.approx([0, 30, 60])
    assert leaves[1]["file"] == rows[1]["file"]


def test_a_file_names_the_files_of_the_series(tmp_path: Path) -> None:
    simulate_series(STAGE, "seed=1,2", Targets(tmp_path / "run.npz"))
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["run_seed_1.npz", "run_seed_2.npz", "run_series.csv"]
    simulate_file(Order("goniometer", seed=2, step_deg=0.2), Targets(tmp_path / "alone.npz"))
    with np.load(tmp_path / "alone.npz") as alone, np.load(tmp_path / "run_seed_2.npz") as step:
        np.testing.assert_array_equal(alone["xyz"], step["xyz"])


def test_the_scene_brings_its_own_series(tmp_path: Path) -> None:
    report = simulate_series(Order("shoot", step_deg=0.3), "", Targets(tmp_path))
    assert report["key"] == "shoot_1.angle_deg"
    assert [step["value"] for step in report["steps"]] == list(range(0, 81, 10))


def test_instruments_can_be_a_series(tmp_path: Path) -> None:
    report = simulate_series(
        Order("leaf", step_deg=0.2), "instrument=x330,salca", Targets(tmp_path)
    )
    assert [step["instrument"] for step in report["steps"]] == ["FARO X330", "SALCA"]
    assert (tmp_path / "leaf_instrument_salca.laz").is_file()


@pytest.mark.parametrize(
    ("order", "series", "out", "error"),
    [
        (Order("leaf"), "", "new", WrongUse),
        (STAGE, "nonsense", "new", WrongUse),
        (STAGE, "stage.bogus=1,2", "new", WrongUse),
        (STAGE, "nobody.angle_deg=1,2", "new", WrongUse),
        (STAGE, "seed=1,1", "new", WrongUse),
        (STAGE, "instrument=ls880,nothing", "new", WrongUse),
        (STAGE, "seed=1,2", "run.docx", WrongUse),
        (STAGE, "instrument=ls880,salca", "run.ptx", WrongUse),
        (STAGE, "seed=1,2", "taken", BadInput),
        (STAGE, "seed=1,2", "old", BadInput),
    ],
)
def test_refused_before_anything_is_scanned(
    order: Order,
    series: str,
    out: str,
    error: type[LeafscopeError],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "taken").write_bytes(b"precious")
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "goniometer_seed_2.laz").write_bytes(b"precious")
    monkeypatch.setattr("app.services.simulation_order.Setup.scan", None)
    with pytest.raises(error):
        simulate_series(order, series, Targets(tmp_path / out))
    assert sorted(path.name for path in tmp_path.rglob("*")) == [
        "goniometer_seed_2.laz", "old", "taken",
    ]  # fmt: skip


def test_waveforms_are_for_one_scan(tmp_path: Path) -> None:
    with pytest.raises(WrongUse, match="one scan"):
        simulate_series(STAGE, ANGLES, Targets(tmp_path, waveforms=tmp_path / "w.npz"))


def test_what_was_done_before_a_cancel_is_whole_and_in_the_table(tmp_path: Path) -> None:
    second = tmp_path / "goniometer_angle_deg_30.laz"
    fractions: list[float] = []
    progress = LiveProgress(lambda fraction, _: fractions.append(fraction), second.exists)
    with pytest.raises(Cancelled):
        simulate_series(STAGE, ANGLES, Targets(tmp_path), progress)
    rows = read_table(tmp_path / "series.csv")
    assert [row["file"] for row in rows] == ["goniometer_angle_deg_0.laz", second.name]
    names = {path.name for path in tmp_path.iterdir()}
    data = {row["file"] for row in rows}
    assert names == {"series.csv", *data, *(f"{name}.leafscope.json" for name in data)}
    for name in data:
        assert len(read_file(tmp_path / name)) == 1
    assert fractions == sorted(fractions)
    assert 1 / 3 < fractions[-1] <= 2 / 3 + 1e-9


def test_an_older_series_is_replaced_on_request(tmp_path: Path) -> None:
    simulate_series(STAGE, "seed=1,2", Targets(tmp_path))
    with pytest.raises(BadInput, match="exists already"):
        simulate_series(STAGE, "seed=2,3", Targets(tmp_path))
    simulate_series(STAGE, "seed=2,3", Targets(tmp_path, overwrite=True))
    assert [row["value"] for row in read_table(tmp_path / "series.csv")] == ["2", "3"]


def test_negative_values_stay_numbers_in_the_table(tmp_path: Path) -> None:
    simulate_series(STAGE, "stage.angle_deg=-30:0:30", Targets(tmp_path))
    assert [row["value"] for row in read_table(tmp_path / "series.csv")] == ["-30", "0"]
