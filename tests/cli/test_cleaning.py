"""``leafscope clean``: settings, report, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.formats.cloud import Cloud
from app.model.operations import MarkGhosts
from app.model.points import PointSet
from app.model.scan import Channel, Scan
from app.model.view_state import ViewState
from app.services.cleanup.answers import SETTINGS
from app.services.export import export
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, open_file
from app.services.reading import read_file
from app.services.sessions import save_session

Capture = pytest.CaptureFixture[str]


def clean(capsys: Capture, *args: object) -> dict:
    assert run(["clean", *map(str, args), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_settings_go_from_few_ghosts_to_many(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    found = {}
    for setting in ("careful", "normal", "strict"):
        out = tmp_path / f"{setting}.npz"
        found[setting] = clean(
            capsys, leaves_file, "--mode", "delete", "--setting", setting, "--out", out
        )
        assert found[setting]["threshold"] == SETTINGS[setting]
    counts = [found[setting]["ghosts"] for setting in SETTINGS]
    assert counts == sorted(counts)
    assert counts[0] < counts[2]
    own = clean(capsys, leaves_file, "--mode", "delete", "--threshold", "0.8", "--out",
                tmp_path / "own.npz")  # fmt: skip
    assert own["ghosts"] == counts[0]
    assert own["setting"] == "careful"


def test_auto_corrects_what_is_sure_and_deletes_or_marks_the_rest(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    out, report = tmp_path / "auto.npz", tmp_path / "auto.json"
    found = clean(capsys, leaves_file, "--mode", "auto", "--out", out, "--report", report)
    assert found["corrected"] + found["deleted"] == found["ghosts"]
    assert min(found["corrected"], found["deleted"]) > 0
    assert json.loads(report.read_text()) == found
    (scan,) = found["scans"]
    assert scan["method"] == "scan grid"
    assert sum(sum(counts.values()) for counts in scan["reasons"].values()) == found["ghosts"]
    assert scan["shift_median_mm"] <= scan["shift_95_mm"]
    with np.load(out) as written:
        assert len(written["xyz"]) == found["points"] - found["deleted"]
    left = clean(capsys, leaves_file, "--mode", "auto", "--uncertain", "mark", "--out",
                 tmp_path / "left.npz")  # fmt: skip
    assert (left["left_marked"], left["deleted"]) == (found["deleted"], 0)
    surer = clean(capsys, leaves_file, "--mode", "auto", "--sure", "0.95", "--out",
                  tmp_path / "surer.npz")  # fmt: skip
    assert surer["corrected"] < found["corrected"]


def test_marking_writes_why(leaves_file: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "marked.npz"
    found = clean(capsys, leaves_file, "--mode", "mark", "--out", out)
    with np.load(out) as written:
        ghost, reason = written["ghost"], written["ghost_reason"]
        score, confidence = written["ghost_score"], written["ghost_confidence"]
    assert ghost.sum() == found["ghosts"] == found["left_marked"]
    assert set(np.unique(reason[ghost])) <= set(map(float, found["reason_numbers"]))
    assert (score[ghost] >= found["threshold"]).all()
    assert np.isnan(confidence[~ghost]).all()
    assert ((confidence[ghost] >= 0) & (confidence[ghost] <= 1)).all()


def test_the_beam_is_said_and_people_can_read_it(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    args = ["clean", str(leaves_file), "--mode", "auto", "--instrument", "two_colour", "--out",
            str(tmp_path / "o.npz")]  # fmt: skip
    assert run(args) == 0
    said = capsys.readouterr().out
    for words in ("score: scan grid; threshold 0.5 (normal)", "instrument two_colour",
                  "between two surfaces: ", "corrected ghosts moved by"):  # fmt: skip
        assert words in said


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (["--sure", "1.5"], "0 to 1"),
        (["--threshold", "2"], "above 0 and up to 1"),
        (["--threshold", "0"], "0 would call all so"),
        (["--threshold", "nan"], "above 0 and up to 1"),
        (["--report", "SAME"], "both the result and the report"),
        (["--setting", "wild"], "wild"),
    ],
)
def test_what_is_refused(
    leaves_file: Path, tmp_path: Path, capsys: Capture, extra: list[str], words: str
) -> None:
    out = tmp_path / "o.npz"
    extra = [str(out) if arg == "SAME" else arg for arg in extra]
    assert run(["clean", str(leaves_file), "--mode", "auto", "--out", str(out), *extra]) != 0
    said = capsys.readouterr()
    assert words in said.err + said.out
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("--mode", "delete", "--setting", "strict", "--threshold", "0.9"), "both name"),
        (("--mode", "delete", "--sure", "0.1"), "makes none"),
        (("--mode", "correct", "--uncertain", "mark"), "belongs to mode auto"),
        (("--mode", "auto", "--find-leaves", "--label-field", "truth_leaf"), "not from both"),
    ],
)
def test_options_without_a_say_are_refused(
    leaves_file: Path, tmp_path: Path, capsys: Capture, options: tuple[str, ...], word: str
) -> None:
    out = tmp_path / "out.npz"
    assert run(["clean", str(leaves_file), *options, "--out", str(out)]) == 2
    assert word in capsys.readouterr().err
    assert not out.exists()


def test_leaves_of_a_label_field_are_counted_with_their_areas(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    args = ["--label-field", "truth_leaf", "--report", tmp_path / "r.json"]
    found = clean(capsys, leaves_file, "--mode", "auto", *args, "--out", tmp_path / "o.npz")
    (scan,) = json.loads((tmp_path / "r.json").read_text())["scans"]
    assert scan["leaves"] == found["scans"][0]["leaves"]
    assert len(scan["leaves"]) == 6
    for leaf in scan["leaves"]:
        assert leaf["after"] <= leaf["before"]
        if leaf["area_before_cm2"] is not None:
            assert leaf["area_after_cm2"] == pytest.approx(leaf["area_before_cm2"], rel=0.2)
    assert sum(leaf["area_after_cm2"] is not None for leaf in scan["leaves"]) >= 4
    assert sum(leaf["deleted"] for leaf in scan["leaves"]) > 0
    assert scan["no_leaves"] is None


def test_leaves_can_be_found_or_are_missed_in_words(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    found = clean(capsys, leaves_file, "--mode", "auto", "--find-leaves", "--out",
                  tmp_path / "o.npz")  # fmt: skip
    assert len(found["scans"][0]["leaves"]) >= 5
    out = tmp_path / "p.npz"
    report = ["--report", str(tmp_path / "p.json")]
    assert run(["clean", str(leaves_file), "--mode", "mark", "--out", str(out), *report]) == 0
    assert "by leaf: The scan has no leaves to count by" in capsys.readouterr().out
    assert "--find-leaves" in json.loads((tmp_path / "p.json").read_text())["scans"][0]["no_leaves"]
    args = ["--find-leaves", "--out", str(tmp_path / "q.npz")]
    assert run(["clean", str(leaves_file), "--mode", "delete", *args]) == 0
    said = capsys.readouterr().out
    assert " cm², 0 corrected, " in said
    assert re.search(r"\d leaves, \d changed", said)


@pytest.fixture
def session_file(leaves_file: Path, tmp_path: Path) -> tuple[Path, np.ndarray]:
    """A session with leaves, an own threshold and some ghosts that the user keeps."""
    project, (key,) = open_file(Opening(leaves_file))
    leaves_from_labels(project, key, "truth_leaf")
    project.set_parameters(key, ghost_threshold=0.8)
    kept = np.flatnonzero(project.field(key, "ghost") == 1.0)[::20][:10]
    project.do(MarkGhosts(key, kept=PointSet(kept)))
    save_session(project, ViewState(current=key), tmp_path / "some.leafscope")
    return tmp_path / "some.leafscope", kept


def test_a_session_brings_its_leaves_threshold_and_answers(
    session_file: tuple[Path, np.ndarray], tmp_path: Path, capsys: Capture
) -> None:
    session, kept = session_file
    for mode in ("auto", "correct", "delete", "mark"):
        out = tmp_path / f"{mode}.npz"
        found = clean(capsys, session, "--mode", mode, "--out", out)
        assert (found["threshold"], found["kept"]) == (0.8, len(kept))
        assert len(found["scans"][0]["leaves"]) == 6
        with np.load(out) as written:
            assert (written["ghost_mark"] == -1).sum() == len(kept) + found["corrected"]
            assert len(written["xyz"]) == found["points"] - found["deleted"]
            if mode in ("auto", "correct"):
                moved = written["ghost_moved"] != 0.0
                assert (written["ghost_mark"][~moved] == -1).sum() >= len(kept)
    args = ["clean", str(session), "--mode", "mark", "--out", str(tmp_path / "n.npz")]
    assert run([*args, "--origin", "0,0,0"]) == 2
    assert "A session knows how its files are read" in capsys.readouterr().err


@pytest.fixture
def scattered_file(leaves: Scan, tmp_path: Path) -> Path:
    """A third of the points in random order: nobody can tell rows and columns."""
    chance = np.random.default_rng(3)
    chosen = chance.permutation(len(leaves))[: len(leaves) // 3]
    scan = Scan("scattered", leaves.xyz[chosen], {}, (), leaves.pose)
    export(Cloud(scan), tmp_path / "scattered.ply")
    return tmp_path / "scattered.ply"


def test_without_rows_and_columns_nothing_is_corrected(
    scattered_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    out = tmp_path / "o.npz"
    assert run(["clean", str(scattered_file), "--mode", "correct", "--out", str(out)]) != 0
    said = capsys.readouterr().err
    assert "nothing can be corrected" in said
    assert "--mode mark" in said
    assert not out.exists()


def test_without_rows_and_columns_auto_marks_unless_told_to_delete(
    scattered_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    found = clean(capsys, scattered_file, "--mode", "auto", "--out", tmp_path / "a.npz")
    assert found["left_marked"] == found["ghosts"] > 0
    assert found["deleted"] == found["corrected"] == 0
    assert "weaker" in found["score_from"]
    assert any("weaker one of density" in note for note in found["notes"])
    told = ["--uncertain", "delete", "--out", tmp_path / "b.npz"]
    assert clean(capsys, scattered_file, "--mode", "auto", *told)["deleted"] == found["ghosts"]


def read_back(path: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Coordinates and columns as any reader has them."""
    if path.suffix == ".npz":
        with np.load(path) as written:
            return written["xyz"], {name: written[name] for name in written.files}
    (scan,) = read_file(path)
    return scan.xyz, dict(scan.attributes)


@pytest.mark.parametrize("suffix", [".npz", ".ply", ".laz", ".las", ".csv", ".ptx", ".e57"])
def test_moved_points_are_told_apart_and_put_back_by_arithmetic(
    leaves_file: Path, leaves: Scan, tmp_path: Path, capsys: Capture, suffix: str
) -> None:
    out = tmp_path / f"out{suffix}"
    found = clean(capsys, leaves_file, "--mode", "correct", "--out", out)
    xyz, held = read_back(out)
    moved = held["ghost_moved"] != 0.0
    assert 0 < moved.sum() <= found["corrected"]
    vector = np.stack([held[f"ghost_moved_{axis}"] for axis in "xyz"], axis=1).astype(np.float64)
    np.testing.assert_array_equal(vector.any(axis=1), moved)
    length = 1000.0 * np.linalg.norm(vector, axis=1)
    np.testing.assert_allclose(length, np.abs(held["ghost_moved"]), rtol=1e-6)
    confidence = held["ghost_moved_confidence"]
    assert (confidence[moved] >= found["sure"] - 1e-6).all()
    assert np.isfinite(confidence).sum() == found["corrected"]
    assert (held["ghost_mark"][moved] == -1).all()
    source, _ = read_back(leaves_file)
    measured = xyz - vector
    if suffix != ".ptx":  # which is written cell by cell
        np.testing.assert_allclose(measured, source, atol=2e-5)
    else:
        one, two = (np.sort(np.linalg.norm(a, axis=1)) for a in (measured, source))
        np.testing.assert_allclose(one, two, atol=2e-5)


def test_a_second_clean_up_adds_its_moves(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    first, second = tmp_path / "first.ply", tmp_path / "second.ply"
    one = clean(capsys, leaves_file, "--mode", "correct", "--sure", "0.95", "--out", first)
    two = clean(capsys, first, "--mode", "correct", "--out", second)
    assert min(one["corrected"], two["corrected"]) > 0
    xyz, held = read_back(second)
    vector = np.stack([held[f"ghost_moved_{axis}"] for axis in "xyz"], axis=1)
    np.testing.assert_allclose(xyz - vector, read_back(leaves_file)[0], atol=1e-6)
    assert np.isfinite(held["ghost_moved_confidence"]).sum() > two["corrected"]


def test_the_kind_of_a_ptx_intensity_can_be_told_and_a_guess_is_noted(
    leaves: Scan, tmp_path: Path, capsys: Capture
) -> None:
    values = leaves.channel_values(leaves.channels[0].name)
    shares = {"intensity": (values / np.nanmax(values)).astype(np.float32)}
    channels = (Channel("intensity", "intensity"),)
    path = tmp_path / "share.ptx"
    export(Cloud(Scan("share", leaves.xyz, shares, channels, leaves.pose, leaves.grid)), path)
    path.with_name(path.name + ".leafscope.json").unlink()
    guessed = clean(capsys, path, "--mode", "delete", "--out", tmp_path / "a.npz")
    (note,) = (note for note in guessed["notes"] if "DN" in note)
    assert "--channel intensity=NM:reflectance" in note
    assert run(["info", str(path)]) == 0
    assert note in capsys.readouterr().out
    told = ["--channel", "intensity=1545:reflectance"]
    found = clean(capsys, path, "--mode", "delete", *told, "--out", tmp_path / "b.npz")
    assert not any("DN" in note for note in found["notes"])
    for command in ("leaves", "wrinkles"):
        out = tmp_path / f"{command}.csv"
        assert run([command, str(path), *told, "--out", str(out)]) == 0
        assert out.exists()
