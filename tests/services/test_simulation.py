"""From an order to files: what is written, what is refused, and that it is the same again."""

from __future__ import annotations

import csv
import json
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled, LeafscopeError, WrongUse
from app.core.progress import LiveProgress
from app.services.reading import SHARE_OF_FREE, read_file
from app.services.simulation import Targets, simulate_file
from app.services.simulation_order import Estimate, Order, estimate, refuse_too_large, set_up
from app.simulate.virtual_scan import simulate

COARSE = Order("leaf", step_deg=0.1)

TEN_LINES = """\
name = "two leaves"
instrument = "ls880"
step_deg = 0.1
[[part]]
kind = "leaf"
tilt_deg = 30
[[part]]
kind = "wall"
range = 4
"""


def test_the_file_holds_the_scan_with_all_its_truth(tmp_path: Path) -> None:
    out = tmp_path / "leaf.laz"
    report = simulate_file(COARSE, Targets(out))
    expected = simulate("leaf", step_deg=0.1).scan
    (scan,) = read_file(out)
    np.testing.assert_allclose(scan.xyz, expected.xyz, atol=1e-4)
    assert set(expected.attributes) <= set(scan.attributes)
    for name in ("truth_leaf", "truth_ghost", "truth_incidence", "reflectance_1063"):
        np.testing.assert_array_equal(scan.attributes[name], expected.attributes[name])
    assert scan.pose is not None
    assert scan.pose.position == (0.0, 0.0, 1.6)
    assert [c.wavelength_nm for c in scan.channels] == [1063.0, 1545.0]
    grid = scan.grid
    assert grid is not None
    assert report["beams"] == grid.rows * grid.columns
    assert report["points"] == len(scan)
    assert report["ghosts"] == pytest.approx(np.mean(expected.attributes["truth_ghost"] == 1))
    assert report["channels"] == ["reflectance_1063", "reflectance_1545"]
    speed = report["beams"] / report["seconds"] / 1e6
    assert report["million_beams_per_second"] == pytest.approx(speed)


@pytest.mark.parametrize("suffix", [".laz", ".e57", ".ptx", ".ply", ".csv"])
def test_every_format_brings_the_truth_back(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"leaf{suffix}"
    simulate_file(COARSE, Targets(out))
    (scan,) = read_file(out)
    expected = simulate("leaf", step_deg=0.1).scan
    assert len(scan) == len(expected)
    for name in ("truth_leaf", "truth_hit_fraction", "truth_rho_1545"):
        read, made = scan.attributes[name], expected.attributes[name]
        assert read.sum() == pytest.approx(made.sum(), rel=1e-5)


def test_the_file_says_how_to_make_it_again(tmp_path: Path) -> None:
    out = tmp_path / "leaf.laz"
    simulate_file(
        Order("leaf", "x330", 5, 0.1, "filtered", (("leaf_1.tilt_deg", 50),)), Targets(out)
    )
    said = json.loads((tmp_path / "leaf.laz.leafscope.json").read_text())["provenance"]
    assert said["noise"] == "filtered"
    scene = said["scene"]
    assert (scene["instrument"], scene["seed"], scene["step_deg"]) == ("x330", 5, 0.1)
    assert scene["part"][0]["tilt_deg"] == 50


def test_the_same_seed_gives_the_same_files(tmp_path: Path) -> None:
    def make(name: str, seed: int) -> tuple[bytes, bytes, bytes]:
        targets = Targets(*(tmp_path / f"{name}{end}" for end in (".npz", ".csv", "-waves.npz")))
        simulate_file(Order("leaf", "hsl", seed, 0.1), targets)
        points, leaves, waves = targets.points, targets.leaves, targets.waveforms
        assert leaves is not None
        assert waves is not None
        return points.read_bytes(), leaves.read_bytes(), waves.read_bytes()

    first = make("a", 1)
    assert make("b", 1) == first
    other = make("c", 2)
    assert other[0] != first[0]
    assert other[2] != first[2]


def test_a_scene_of_ten_lines(tmp_path: Path) -> None:
    scene, out = tmp_path / "mine.toml", tmp_path / "mine.npz"
    scene.write_text(TEN_LINES)
    report = simulate_file(Order(str(scene)), Targets(out))
    assert report["scene"] == "two leaves"
    with np.load(out) as written:
        angle = written["truth_incidence"][written["truth_leaf"] == 0]
        assert set(np.unique(written["truth_leaf"])) == {-1, 0}
    assert np.median(angle) == pytest.approx(30, abs=1)


def test_the_table_of_leaves_counts_their_points(tmp_path: Path) -> None:
    targets = Targets(tmp_path / "row.npz", tmp_path / "row.csv")
    simulate_file(Order("leaf_row", step_deg=0.05), targets)
    assert targets.leaves is not None
    with targets.leaves.open() as file:
        rows = list(csv.DictReader(file))
    with np.load(targets.points) as written:
        label, share = written["truth_leaf"], written["truth_hit_fraction"]
    assert [int(row["leaf"]) for row in rows] == list(range(6))
    for row in rows:
        mine = label == int(row["leaf"])
        assert int(row["points"]) == mine.sum()
        assert int(row["points_whole"]) == (mine & (share > 0.999)).sum()
        assert 0 < int(row["points_whole"]) < int(row["points"])
    tilts = [float(row["tilt_deg"]) for row in rows]
    assert tilts == pytest.approx([0, 15, 30, 45, 60, 75], abs=1e-6)
    assert {"kind", "area_m2", "centre_x", "normal_z", "water", "rho_1063"} <= set(rows[0])


def test_a_table_without_leaves_has_its_header(tmp_path: Path) -> None:
    full, bare = (Targets(tmp_path / f"{n}.npz", tmp_path / f"{n}.csv") for n in ("full", "bare"))
    simulate_file(COARSE, full)
    simulate_file(Order("panels", step_deg=0.2), bare)
    assert full.leaves is not None
    assert bare.leaves is not None
    assert bare.leaves.read_text().splitlines() == full.leaves.read_text().splitlines()[:1]


def test_waveforms_belong_to_their_points(tmp_path: Path) -> None:
    targets = Targets(tmp_path / "row.npz", waveforms=tmp_path / "waves.npz")
    simulate_file(Order("leaf_row", "salca", step_deg=0.2), targets)
    assert targets.waveforms is not None
    with np.load(targets.waveforms) as waves, np.load(targets.points) as points:
        beams, channels, samples = waves["samples"].shape
        assert waves["samples"].dtype == np.float32
        assert (channels, samples) == (2, 256)
        assert waves["channels"].tolist() == [1063.0, 1545.0]
        of_point = waves["row_of_point"]
        assert len(of_point) == len(points["xyz"])
        assert set(of_point) == set(range(beams))
        np.testing.assert_array_equal(waves["row"][of_point], points["row"])
        np.testing.assert_array_equal(waves["column"][of_point], points["column"])
        peak = waves["samples"][:, 0].argmax(axis=1) * waves["step_m"] + waves["start_m"]
        lonely = np.bincount(of_point)[of_point] == 1
        off = peak[of_point] - points["truth_range"]
        assert lonely.sum() > 100
        assert np.median(np.abs(off[lonely])) < waves["step_m"]


TWICE = Path("a.laz")


@pytest.mark.parametrize(
    ("order", "targets", "error"),
    [
        (Order("nothing"), Targets(Path("a.laz")), WrongUse),
        (Order("leaf", "nothing"), Targets(Path("a.laz")), WrongUse),
        (Order("leaf", settings=(("leaf_1.bogus", 1),)), Targets(Path("a.laz")), WrongUse),
        (Order("leaf", settings=(("nobody.tilt_deg", 1),)), Targets(Path("a.laz")), WrongUse),
        (Order("leaf", seed=-1), Targets(Path("a.laz")), WrongUse),
        (Order("leaf", step_deg=30), Targets(Path("a.laz")), WrongUse),
        (Order("leaf"), Targets(Path("a.laz"), waveforms=Path("w.npz")), WrongUse),
        (Order("leaf", "salca"), Targets(Path("a.ptx")), WrongUse),
        (Order("leaf"), Targets(Path("a.docx")), WrongUse),
        (Order("leaf"), Targets(TWICE, leaves=TWICE), WrongUse),
        (Order("leaf"), Targets(Path("nowhere/a.laz")), BadInput),
        (Order("leaf"), Targets(Path("taken.laz")), BadInput),
        (Order("leaf"), Targets(Path("a.laz"), leaves=Path("taken.laz")), BadInput),
        (Order("bad.toml"), Targets(Path("a.laz")), BadInput),
        (Order("missing.toml"), Targets(Path("a.laz")), BadInput),
        (Order("leaf", "bad.toml"), Targets(Path("a.laz")), BadInput),
        (Order("pear_row", step_deg=0.001), Targets(Path("a.laz")), BadInput),
    ],
)
def test_refused_before_anything_is_scanned(
    order: Order,
    targets: Targets,
    error: type[LeafscopeError],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("taken.laz").write_bytes(b"precious")
    Path("bad.toml").write_text("name = ")
    monkeypatch.setattr("app.services.simulation_order.Setup.scan", None)
    with pytest.raises(error):
        simulate_file(order, targets)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.toml", "taken.laz"]
    assert Path("taken.laz").read_bytes() == b"precious"


def test_a_folder_that_may_not_be_written_to_is_refused_early(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Root may write anywhere, so the system is made to say no.
    monkeypatch.setattr("app.formats.atomic.os.access", lambda *_: False)
    with pytest.raises(BadInput, match="may not write"):
        simulate_file(COARSE, Targets(tmp_path / "a.laz"))


def test_cancelled_work_leaves_nothing(tmp_path: Path) -> None:
    texts: list[str] = []
    progress = LiveProgress(
        lambda _, text: texts.append(text), lambda: any("Scanning" in text for text in texts)
    )
    with pytest.raises(Cancelled):
        simulate_file(COARSE, Targets(tmp_path / "a.laz", tmp_path / "a.csv"), progress)
    assert list(tmp_path.iterdir()) == []


def test_the_estimate_counts_beams_exactly_and_points_about() -> None:
    order = Order("scattered", "pulsed", step_deg=0.05)
    setup = set_up(order.document(), order.origin)
    found = estimate(setup)
    scan = setup.scan().scan
    assert scan.grid is not None
    assert found.beams == scan.grid.rows * scan.grid.columns
    assert found.points == pytest.approx(len(scan), rel=0.05)


def test_a_scan_that_the_memory_would_not_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = set_up(COARSE.document(), COARSE.origin)
    found = estimate(setup)
    refuse_too_large(setup, found)

    class Little:
        available = 100_000

    monkeypatch.setattr("psutil.virtual_memory", Little)
    with pytest.raises(BadInput, match="larger step"):
        refuse_too_large(setup, found)


@pytest.mark.parametrize("waveforms", [False, True])
def test_what_threads_hold_while_they_digitise_counts(
    waveforms: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    order = Order("leaf", "salca", step_deg=0.1)
    setup = set_up(order.document(), order.origin)
    noise = 3 * 8 * setup.grid.columns * 2 * 256 * 4  # threads, rows, columns, channels, samples
    monkeypatch.setattr("app.services.simulation_order.count_processors", lambda: 3)
    need = noise * 2 if waveforms else noise  # those that are kept need room too
    for free, enough in ((need * 1.01, True), (need * 0.99, False)):
        memory = SimpleNamespace(available=free / SHARE_OF_FREE)
        monkeypatch.setattr("psutil.virtual_memory", lambda memory=memory: memory)
        with nullcontext() if enough else pytest.raises(BadInput, match="larger step"):
            refuse_too_large(setup, Estimate(0, 0), waveforms)


def test_no_noise_on_request(tmp_path: Path) -> None:
    out = tmp_path / "a.npz"
    simulate_file(Order("leaf", step_deg=0.1, noise="none"), Targets(out))
    with np.load(out) as written:
        away = np.linalg.norm(written["xyz"] - (0, 0, 1.6), axis=1)
        np.testing.assert_allclose(away, written["truth_range"], atol=1e-9)
