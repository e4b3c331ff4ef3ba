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
    naming = Naming("ours", "salca", Noise(2.0), margin=0.1)
    found = calibrate_table(salca, "hancock", wishes=wishes, naming=naming)
    out, report = tmp_path / "p.toml", tmp_path / "r.md"
    assert write_calibration(found, out, report) == [out, report, tmp_path / "r.png"]
    profile = read_profile(out)
    assert profile == found.profile
    assert (profile.name, profile.instrument, profile.origin) == ("ours", "salca", "yours")
    assert [c.name for c in profile.channels] == ["reflectance_1063", "reflectance_1545"]
    first = profile.channels[0]
    assert (first.nearest, first.farthest) == pytest.approx((1.9, 60.1))
    assert first.noise == Noise(2.0)
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
    with pytest.raises(WrongUse, match=r"margin of 0\.5 m is more than 0\.1 m.*scan panels nearer"):
        calibrate_table(salca, "hancock", naming=Naming(margin=0.5))


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


WHITE = "range,dn,rho,panel,nm\n" + "".join(
    f"{away},{1800 - 40 * away},0.99,99 %,785\n" for away in (1, 2, 3, 5, 7, 10)
)


def told(folder: Path, text: str, model: str, naming: Naming = Naming()) -> str:  # noqa: B008
    (folder / "t.csv").write_text(text, encoding="utf-8")
    found = calibrate_table(folder / "t.csv", model, naming=naming)
    return " ".join(found.channels[0].warnings + found.warnings)


def test_a_range_correction_alone_speaks_of_dn(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "t.csv").write_text(WHITE, encoding="utf-8")
    out, report = tmp_path / "p.toml", tmp_path / "r.md"
    words = ["calibrate", str(tmp_path / "t.csv"), "--model", "polynomial", "--out", str(out)]
    assert run([*words, "--report", str(report), "--instrument", "mine"], debug=True) == 0
    caught = capsys.readouterr()
    printed = caught.out + caught.err
    assert "corrected_785: polynomial, 6 rows" in printed
    assert "corrected DN: RMSE" in printed
    assert "as many numbers as rows: how sure it is, is not known" in printed
    assert "does not know an instrument mine" in printed
    assert "power of" not in printed
    assert "nan" not in printed
    text = report.read_text(encoding="utf-8")
    assert "Corrected DN: RMSE" in text
    assert "not known" in text
    assert "reference scan" not in text
    (channel,) = read_profile(out).channels
    assert (channel.name, channel.noise, channel.fit_covariance) == ("corrected_785", None, ())
    assert run([*words, "--json", "--overwrite"], debug=True) == 0
    answer = json.loads(capsys.readouterr().out)["channels"][0]
    assert answer["noise"] is None
    assert answer["parameters"]["F(1 m)"]["low"] is None
    assert answer["unit"] == "DN"


def test_one_row_is_one_row(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "t.csv").write_text("range,dn,rho,nm\n4,900,0.9,785\n", encoding="utf-8")
    words = ["calibrate", str(tmp_path / "t.csv"), "--model", "kaasalainen"]
    assert run([*words, "--out", str(tmp_path / "p.toml")], debug=True) == 0
    printed = capsys.readouterr().out
    assert "reflectance_785: proportional, 1 row\n" in printed
    assert "gain = 1000\n" in printed


def test_warnings_of_ranges_and_of_a_model_that_does_not_fit(tmp_path: Path) -> None:
    rows = [(away, rho) for away in (2, 4, 60) for rho in (0.1, 0.4, 0.9)]
    numbers = [2000 + 600 * np.log10(rho / away) for away, rho in rows]
    told_rows = [f"{d},{dn},{r},785\n" for (d, r), dn in zip(rows, numbers, strict=True)]
    text = "d,dn,rho,nm\n" + "".join(told_rows)
    said = told(tmp_path, text, "log")
    assert "The panels are at 2 to 60 m, and the model log knows no effect of range" in said
    assert "come back with an RMSE of" in said
    assert "at 2 to 60" not in told(tmp_path, text, "log", Naming(any_range=True))
    said = told(tmp_path, text, "log+polynomial")
    assert "No panel between 4 and 60 m: the curve there is a guess" in said
    assert "between 2 and 4" not in said
    assert "RMSE of" not in said
    assert "degrees of freedom" not in said
    near = "".join(line + "\n" for line in text.splitlines()[:4])
    assert "judged by 1 degree of freedom" in told(tmp_path, near, "log")


def test_a_known_instrument_is_not_warned_of(faro: Path) -> None:
    wishes = Wishes(saturated=2033.0)
    found = calibrate_table(faro, "junttila-log", wishes=wishes, naming=Naming("", "X330"))
    assert found.warnings == ()
