"""The commands that fit: Kaasalainen's tables, every option, every refusal in a sentence."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import curve_fit

from app.cli import run
from app.core.phase import get_model

Capture = pytest.CaptureFixture[str]
BECKMANN = get_model("lambert-beckmann")
DEGREES = np.arange(0.0, 81.0, 5.0)
PAIRS = [r for r in BECKMANN.references if r.source.startswith("Kaasalainen")]
FORMULA = """
name = "power"
expression = "a*cos(omega)**p"
[[parameters]]
name = "a"
typical = [0.1, 2.0]
scales = true
[[parameters]]
name = "p"
typical = [0.2, 3.0]
"""


@pytest.fixture(autouse=True)
def own_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "own-models"
    monkeypatch.setenv("LEAFSCOPE_MODELS", str(folder))
    return folder


def write(path: Path, rows: Sequence[Sequence[object]]) -> Path:
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return path


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Curves without noise of the 56 pairs that Kaasalainen prints, in 5° steps."""
    rows: list[list[object]] = [["sample", "channel", "angle", "I"]]
    for reference in PAIRS:
        sample, channel = reference.sample.split(", channel ")
        curve = BECKMANN.evaluate(np.deg2rad(DEGREES), {"f": 700.0, **reference.values})
        rows += [[sample, channel, a, float(i)] for a, i in zip(DEGREES, curve, strict=True)]
    return write(tmp_path_factory.mktemp("k") / "k.csv", rows)


@pytest.fixture(scope="module")
def noisy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six leaves of one kind, of which each is a little brighter or darker as a whole."""
    generator = np.random.default_rng(4)
    curve = BECKMANN.evaluate(np.deg2rad(DEGREES), {"f": 50.0, "k_d": 0.6, "m": 0.3})
    rows: list[list[object]] = [["leaf", "angle", "I"]]
    for leaf in range(6):
        bright = 1.0 + 0.1 * generator.standard_normal()
        seen = bright * curve * (1.0 + 0.02 * generator.standard_normal(len(curve)))
        rows += [[leaf, a, float(i)] for a, i in zip(DEGREES, seen, strict=True)]
    return write(tmp_path_factory.mktemp("n") / "n.csv", rows)


def fit(table: Path, *words: object) -> list[str]:
    return ["fit", str(table), "--x", "angle", "--y", "I", *map(str, words)]


def answer(capsys: Capture, words: Sequence[object]) -> Any:
    assert run([*map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_kaasalainens_tables_3_and_4_come_out_as_printed(printed: Path, tmp_path: Path) -> None:
    out = tmp_path / "wide.csv"
    words = ("--group", "sample", "--group", "channel", "--model", "lambert-beckmann")
    assert run(fit(printed, *words, "--table", out, "--wide")) == 0
    rows = list(csv.reader(out.open()))
    assert rows[0] == ["parameter", "quantity", "sample", *map(str, range(1, 9))]
    samples = list(dict.fromkeys(r.sample.split(",")[0] for r in PAIRS))
    assert [row[2] for row in rows if row[:2] == ["k_d", "value"]] == samples
    found = {(row[0], row[2]): row[3:] for row in rows if row[1] == "value"}
    for reference in PAIRS:
        sample, channel = reference.sample.split(", channel ")
        k_d, m = (found[name, sample][int(channel) - 1] for name in ("k_d", "m"))
        assert float(k_d) == pytest.approx(reference.values["k_d"], abs=1e-6)
        if reference.values["k_d"] == 1.0:
            assert m == ""
        else:
            assert float(m) == pytest.approx(reference.values["m"], abs=1e-6)


def test_a_fit_tells_all_of_its_numbers(noisy: Path, capsys: Capture) -> None:
    found = answer(capsys, fit(noisy, "--model", "lambert-beckmann"))
    (one,) = found["fits"]
    table = np.array(list(csv.reader(noisy.open()))[1:], float)
    expected, covariance = curve_fit(
        lambda a, f, k, m: BECKMANN.evaluate(a, {"f": f, "k_d": k, "m": m}),
        np.deg2rad(table[:, 1]), table[:, 2], [50.0, 0.6, 0.3],
    )  # fmt: skip
    values = [one["parameters"][name]["value"] for name in ("f", "k_d", "m")]
    assert values == pytest.approx(expected, rel=1e-4)
    told = [[one["covariance"][a][b] for b in ("f", "k_d", "m")] for a in ("f", "k_d", "m")]
    np.testing.assert_allclose(told, covariance, rtol=2e-2)
    assert one["angles_deg"] == pytest.approx([0.0, 80.0])
    low, high = one["intervals"]["k_d"]
    assert low < values[1] < high
    n = len(table)
    assert one["aic"] == pytest.approx(n * np.log(one["rss"] / n) + 8)
    assert one["bic"] == pytest.approx(n * np.log(one["rss"] / n) + 4 * np.log(n))
    assert found["method"]["to"] == "points"


def test_what_is_fitted_is_a_choice(noisy: Path, capsys: Capture) -> None:
    kinds = {}
    for words in (["--on", "bins", "--bin-width", "10"], ["--on", "edge", "--quantile", "0.8"],
                  ["--loss", "huber"], ["--angles", "0,45"], ["--fix", "m=0.3"]):  # fmt: skip
        (one,) = answer(capsys, fit(noisy, "--model", "lambert-beckmann", *words))["fits"]
        kinds[words[1]] = one
    assert (kinds["bins"]["kind"], kinds["bins"]["n"]) == ("bins", 9)
    assert [kinds["edge"][name] for name in ("kind", "tau", "aic")] == ["edge", 0.8, None]
    assert kinds["edge"]["parameters"]["f"]["value"] > kinds["bins"]["parameters"]["f"]["value"]
    assert kinds["huber"]["scale"] > 0
    assert kinds["0,45"]["angles_deg"] == pytest.approx([0.0, 40.0])
    assert kinds["m=0.3"]["parameters"]["m"] == {"value": 0.3, "sd": None, "unit": "1"}


def test_intervals_by_profile_and_by_leaf(noisy: Path, capsys: Capture) -> None:
    words = fit(noisy, "--model", "lambert-beckmann", "--profile", "--bootstrap", "leaf")
    (one,) = answer(capsys, [*words, "--trials", "200"])["fits"]
    plain = one["intervals"]["m"]
    by_profile = [one["profile"]["m"][end] for end in ("low", "high")]
    assert by_profile == pytest.approx(plain, rel=0.1)
    by_leaf = one["bootstrap"]["f"]
    assert by_leaf["high"] - by_leaf["low"] > 2.0
    assert by_leaf["known"] == 1.0
    # Brightness differs between leaves, shape does not: points alone would hide both.
    assert one["bootstrap"]["m"]["high"] - one["bootstrap"]["m"]["low"] < plain[1] - plain[0]
    assert run([*words, "--trials", "50"]) == 0
    said = capsys.readouterr().out
    assert "by profile:" in said
    assert "by leaf:" in said
    assert "50 draws of 6 leaves" in said


def test_models_side_by_side(noisy: Path, capsys: Capture) -> None:
    found = answer(capsys, fit(noisy, "--compare"))
    assert found["fits"] == []
    (table,) = found["comparisons"]
    best = [row["model"] for row in table["models"] if row["best"]]
    assert best == ["lambert-beckmann"]
    assert {"aic", "aicc", "bic", "weight", "rmse"} <= set(table["models"][0])
    assert run(fit(noisy, "--compare", "--group", "leaf", "--model", "lambert")) == 0
    said = capsys.readouterr().out
    assert said.count("models side by side") == 6
    assert "leaf 0: lambert, 17 points" in said


def test_a_formula_of_ones_own(noisy: Path, tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "power.toml"
    path.write_text(FORMULA)
    (one,) = answer(capsys, fit(noisy, "--formula-model", path))["fits"]
    assert one["model"] == "power"
    table = np.array(list(csv.reader(noisy.open()))[1:], float)
    expected, _ = curve_fit(
        lambda a, f, p: f * np.cos(a) ** p, np.deg2rad(table[:, 1]), table[:, 2], [50.0, 1.0]
    )
    values = [one["parameters"][name]["value"] for name in ("a", "p")]
    assert values == pytest.approx(expected, rel=1e-4)
    for words, code, says in (
        (["--formula-model", path, "--model", "lambert"], 2, "not by both"),
        (["--formula-model", path, "--on", "edge"], 2, "least squares only"),
        (["--formula-model", path, "--profile"], 2, "cannot be had of a formula"),
    ):
        assert run(fit(noisy, *words)) == code
        assert says in capsys.readouterr().err
    path.write_text(FORMULA.replace("a*cos", "a*secret*cos"))
    assert run(fit(noisy, "--formula-model", path)) == 3
    assert "secret" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--model", "lambert", "--group", "species"], 3, "no column 'species'"),
        (["--model", "lambert", "--bootstrap", "plant"], 3, "no column 'plant'"),
        (["--model", "phong"], 2, "no model 'phong'"),
        ([], 2, "Say which model"),
        (["--model", "lambert", "--on", "edge", "--quantile", "1.2"], 2, "between 0 and 1"),
        (["--model", "lambert", "--quantile", "0.9"], 2, "--on edge"),
        (["--model", "lambert", "--on", "bins", "--bin-width", "0"], 2, "wider than 0"),
        (["--model", "lambert", "--on", "bins", "--loss", "huber"], 2, "single points"),
        (["--model", "lambert", "--angles", "10"], 2, "LOW,HIGH"),
        (["--model", "lambert", "--angles", "50,10"], 2, "rise within"),
        (["--model", "lambert", "--fix", "m=0.3"], 2, "no parameter 'm'"),
        (["--model", "lambert-beckmann", "--fix", "m"], 2, "NAME=VALUE"),
        (["--model", "lambert-beckmann", "--fix", "m=7"], 2, "outside its bounds"),
        (["--model", "lambert", "--bootstrap", "leaf", "--trials", "0"], 2, "1 to 100000"),
        (["--model", "lambert", "--wide"], 2, "--table"),
        (["--model", "lambert", "--table", "fits.xlsx"], 2, "Endings"),
        (["--model", "lambert", "--figure", "fits.bmp"], 2, "Endings"),
        (["--compare", "--table", "fits.csv"], 2, "fits of one model"),
        (["--model", "lambert", "--on", "edge", "--profile"], 2, "least squares only"),
    ],
)
def test_bad_words_are_refused_in_a_sentence(
    noisy: Path, capsys: Capture, words: list[str], code: int, says: str
) -> None:
    assert run(fit(noisy, *words)) == code
    said = capsys.readouterr().err
    assert says in said
    assert len(said.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("rows", "model", "says"),
    [
        ([[20.0, i] for i in range(9)], "lambert", "All angles are equal"),
        ([[20.0 + i / 10, i] for i in range(9)], "lambert-beckmann", "needs more pairs"),
        ([[a, ""] for a in range(9)] + [[9, 1.0]], "lambert", "there are 1"),
    ],
)
def test_groups_that_cannot_be_fitted_say_why(
    tmp_path: Path, capsys: Capture, rows: list[list[object]], model: str, says: str
) -> None:
    table = write(tmp_path / "t.csv", [["angle", "I"], *rows])
    on = ["--on", "bins"] if model == "lambert-beckmann" else []
    (one,) = answer(capsys, fit(table, "--model", model, *on))["fits"]
    assert one["rss"] is None
    assert says in one["warnings"][0]


def test_columns_without_numbers_are_refused(tmp_path: Path, capsys: Capture) -> None:
    table = write(tmp_path / "t.csv", [["angle", "I"], [1, ""], [2, "nan"]])
    assert run(fit(table, "--model", "lambert")) == 3
    assert "t.csv holds no number in column 'I'." in capsys.readouterr().err


def test_files_are_refused_before_the_work_and_written_whole(
    noisy: Path, tmp_path: Path, capsys: Capture
) -> None:
    table, figure = tmp_path / "t.tex", tmp_path / "f.svg"
    words = fit(noisy, "--group", "leaf", "--model", "lambert", "--table", table)
    words += ["--figure", str(figure)]
    assert run(words) == 0
    assert table.read_text().count(r"\toprule") == 1
    assert figure.read_text().startswith("<?xml")
    assert run(words) == 3
    assert "exists already" in capsys.readouterr().err
    assert run([*words, "--overwrite"]) == 0
