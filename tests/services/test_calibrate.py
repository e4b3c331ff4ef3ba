"""From a file of panels to profile, report and picture, and the command that does it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.calibration import Wishes
from app.core.radiometry.profile import Noise
from app.services.bench.radiometry import balduzzi, hancock, junttila
from app.services.calibrate import Naming, calibrate_table
from app.services.calibration_report import refuse_calibration, write_calibration
from app.services.panel_columns import TableOptions
from app.services.profiles import read_profile

Capture = pytest.CaptureFixture[str]


def save(path: Path, *tables) -> Path:  # type: ignore[no-untyped-def]
    lines = ["range,dn,reflectance,scan,panel,channel,wavelength_nm"]
    for table in tables:
        columns = (table.distance, table.dn, table.reflectance, table.scan, table.panel)
        for row in zip(*columns, strict=True):
            cells = [*(repr(float(v)) for v in row[:3]), *row[3:]]
            lines.append(",".join([*cells, table.channel, repr(table.wavelength_nm)]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def salca(tmp_path: Path) -> Path:
    random = np.random.default_rng(3)
    tables = [hancock.make_panels(nm, hancock.NOISES[0], random) for nm in (1063, 1545)]
    return save(tmp_path / "salca.csv", *tables)


@pytest.fixture
def faro(tmp_path: Path) -> Path:
    table, _ = junttila.make_panels(junttila.AMPLIFIERS[0], np.random.default_rng(3))
    return save(tmp_path / "faro.csv", table)


def test_two_channels_become_one_profile(salca: Path, tmp_path: Path) -> None:
    wishes = Wishes(reference_scan=hancock.REFERENCE_SCAN)
    naming = Naming("ours", "salca", Noise(2.0), margin=0.5)
    found = calibrate_table(salca, "hancock", wishes=wishes, naming=naming)
    out, report = tmp_path / "p.toml", tmp_path / "r.md"
    assert write_calibration(found, out, report) == [out, report, tmp_path / "r.png"]
    profile = read_profile(out)
    assert profile == found.profile
    assert (profile.name, profile.instrument, profile.origin) == ("ours", "salca", "yours")
    assert [c.name for c in profile.channels] == ["reflectance_1063", "reflectance_1545"]
    first = profile.channels[0]
    assert (first.nearest, first.farthest, first.noise) == (1.5, 60.5, Noise(2.0))
    text = report.read_text(encoding="utf-8")
    for words in ("95 % interval", "too narrow", "Singular values", "analytic-inner", "(r.png)",
                  "RMSE without it", "reference scan scan 6"):  # fmt: skip
        assert words in text
    assert (tmp_path / "r.png").read_bytes().startswith(b"\x89PNG")


def test_warnings_say_what_the_profile_does_not_know(faro: Path) -> None:
    found = calibrate_table(faro, "junttila-log", wishes=Wishes(saturated=2033.0))
    told = " ".join(found.channels[0].warnings)
    assert "8 saturated and 0 dark rows were left out" in told
    assert "All panels are at 4.4 m" in told
    assert "--panel-sigma" in told
    assert "--point-noise" in told
    channel = found.profile.channels[0]
    assert (channel.nearest, channel.farthest) == pytest.approx((0.9 * 4.4, 1.1 * 4.4))


def test_a_profile_holds_at_any_range_only_when_somebody_says_so(faro: Path, salca: Path) -> None:
    wishes = Wishes(saturated=2033.0)
    found = calibrate_table(faro, "junttila-log", wishes=wishes, naming=Naming(any_range=True))
    assert found.profile.channels[0].nearest is found.profile.channels[0].farthest is None
    with pytest.raises(WrongUse, match="range effect"):
        calibrate_table(salca, "hancock", naming=Naming(any_range=True))


def test_every_fault_names_its_channel(salca: Path) -> None:
    with pytest.raises(BadInput, match=r"Channel intensity_1063: .*saturated"):
        calibrate_table(salca, "hancock", wishes=Wishes(saturated=0.5))
    with pytest.raises(WrongUse, match="margin of -1 m"):
        calibrate_table(salca, "hancock", naming=Naming(margin=-1.0))


def test_nothing_is_written_where_one_file_exists(salca: Path, tmp_path: Path) -> None:
    (tmp_path / "r.png").write_bytes(b"old")
    with pytest.raises(BadInput, match=r"r\.png exists already"):
        refuse_calibration(tmp_path / "p.toml", tmp_path / "r.md", overwrite=False)
    options = TableOptions(channel="intensity_1063")
    found = calibrate_table(salca, "hancock", options)
    with pytest.raises(BadInput, match="exists already"):
        write_calibration(found, tmp_path / "p.toml", tmp_path / "r.md")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r.png", "salca.csv"]


def test_the_command_prints_and_writes(faro: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "p.toml"
    words = ["calibrate", str(faro), "--model", "junttila-log", "--out", str(out)]
    words += ["--saturated", "2033", "--fixed-panel", "50 %", "--panel-sigma", "0.02"]
    assert run([*words, "--point-noise", "12,0.001"], debug=True) == 0
    printed = capsys.readouterr().out
    assert "reflectance_1550: log, 24 rows" in printed
    assert "a0 = " in printed
    assert "power of scan 2 = " in printed
    assert read_profile(out).channels[0].noise == Noise(12.0, 0.001)
    assert run([*words, "--json", "--overwrite"], debug=True) == 0
    answer = json.loads(capsys.readouterr().out)
    (channel,) = answer["channels"]
    assert channel["saturated_left_out"] == 8
    a0 = channel["parameters"]["a0"]
    assert a0["low"] < a0["value"] < a0["high"]
    assert a0["value"] == pytest.approx(1200, rel=0.1)
    assert answer["files"] == [str(out)]


def test_the_command_with_a_curve_over_range(tmp_path: Path, capsys: Capture) -> None:
    table = save(tmp_path / "t.csv", balduzzi.make_panels(np.random.default_rng(1)))
    out = tmp_path / "p.toml"
    words = ["calibrate", str(table), "--model", "balduzzi", "--out", str(out)]
    assert run([*words, "--reference-range", "3.56"], debug=True) == 0
    assert "log+polynomial, 104 rows" in capsys.readouterr().out
    assert read_profile(out).channels[0].steps[2].reference == 3.56  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["--model", "cubic"], 2, "no calibration model"),
        (["--model", "log", "--percent"], 3, "Leave --percent out"),
        (["--model", "log", "--point-noise", "loud"], 2, "is no noise"),
        (["--model", "log", "--wavelength", "700"], 2, "says 1550 nm"),
        (["--model", "log+spline"], 3, "All panels are at 4.4 m"),
        (["--model", "log", "--saturated", "0"], 3, "are saturated"),
    ],
)
def test_bad_use_is_one_sentence_and_writes_nothing(
    faro: Path, tmp_path: Path, capsys: Capture, words: list[str], code: int, told: str
) -> None:
    out = tmp_path / "p.toml"
    assert run(["calibrate", str(faro), "--out", str(out), *words]) == code
    assert told in capsys.readouterr().err
    assert not out.exists()
