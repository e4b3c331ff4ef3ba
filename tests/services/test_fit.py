"""Fits of tables: dialects of CSV, groups, the JSON shape, errors in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled, WrongUse
from app.core.phase import get_model
from app.core.progress import LiveProgress
from app.core.units import to_radians
from app.services.fit import fit_groups, fit_table
from app.services.lab.method import Method, fit_by

TRUE = {"f": 900.0, "k_d": 0.45, "m": 0.32}
DEGREES = np.arange(0.0, 81.0, 5.0)


def curve(model: str = "lambert-beckmann", **values: float) -> np.ndarray:
    return get_model(model).evaluate(to_radians(DEGREES), values or TRUE)


def write(path: Path, rows: list[list[object]], separator: str = ",", end: str = "\n") -> Path:
    text = end.join(separator.join(map(str, row)) for row in rows) + end
    path.write_bytes(text.encode("utf-8"))
    return path


def leaf_rows(*names: str) -> list[list[object]]:
    return [[a, v, name] for name in names for a, v in zip(DEGREES, curve(), strict=True)]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_dialects(tmp_path: Path, separator: str, end: str) -> None:
    rows = [['"angle, deg"', '"I;1"', "leaf"], *leaf_rows("a", "b")]
    path = write(tmp_path / "t.csv", rows, separator, end)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    report = fit_table(path, "angle, deg", "I;1", ["leaf"], "lambert-beckmann")
    assert [one.group for one in report.fits] == [{"leaf": "a"}, {"leaf": "b"}]
    for one in report.fits:
        assert one.result is not None
        assert one.result.values == pytest.approx(TRUE, rel=1e-9)


def test_json_is_the_contract(tmp_path: Path) -> None:
    path = write(tmp_path / "t.csv", [["w", "i", "leaf"], *leaf_rows("a"), [3.0, 1.0, "short"]])
    plain = fit_table(path, "w", "i", ["leaf"], "lambert-beckmann").as_dict()
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    good, bad = plain["fits"]
    for one in (good, bad):
        assert list(one)[:6] == ["group", "model", "n", "parameters", "rss", "warnings"]
        assert set(one) >= {"intervals", "covariance", "aic", "aicc", "bic", "angles_deg", "kind"}
        assert list(one["parameters"]) == ["f", "k_d", "m"]
        assert all(set(p) == {"value", "sd", "unit"} for p in one["parameters"].values())
    assert good["group"] == {"leaf": "a"}
    assert good["n"] == len(DEGREES)
    assert good["warnings"] == []
    assert good["angles_deg"] == pytest.approx([0.0, 80.0])
    assert good["intervals"]["f"] == pytest.approx([900.0, 900.0], rel=1e-6)
    assert bad["rss"] is None
    assert bad["angles_deg"] is None
    assert bad["covariance"] == {}
    assert all(p["value"] is None and p["sd"] is None for p in bad["parameters"].values())
    assert "needs more pairs" in bad["warnings"][0]


def test_undetermined_roughness_is_null(tmp_path: Path) -> None:
    rows = [["w", "i"], *zip(DEGREES, np.cos(to_radians(DEGREES)), strict=True)]
    plain = fit_table(write(tmp_path / "t.csv", rows), "w", "i", [], "lambert-beckmann").as_dict()
    (one,) = plain["fits"]
    assert one["group"] == {}
    assert one["parameters"]["k_d"] == {"value": 1.0, "sd": None, "unit": "1"}
    assert one["parameters"]["m"]["value"] is None


def test_groups_of_two_columns(tmp_path: Path) -> None:
    rows: list[list[object]] = [["leaf", "nm", "w", "i"]]
    for leaf, nm, f in (("b", 690, 2.0), ("a", 690, 3.0), ("b", 1550, 4.0)):
        rows += [[leaf, nm, a, f * np.cos(to_radians(a))] for a in DEGREES]
    rows = [rows[0], *rows[:0:-1]]
    report = fit_table(write(tmp_path / "t.csv", rows), "w", "i", ["leaf", "nm"], "lambert")
    found = [(g.group, g.result.values["f"]) for g in report.fits if g.result]
    assert found == [
        ({"leaf": "b", "nm": "1550"}, pytest.approx(4.0)),
        ({"leaf": "a", "nm": "690"}, pytest.approx(3.0)),
        ({"leaf": "b", "nm": "690"}, pytest.approx(2.0)),
    ]


def test_decimal_comma(tmp_path: Path) -> None:
    rows = [["w", "i"], *([f"{a:.1f}".replace(".", ","), f"{v:.6f}".replace(".", ",")]
            for a, v in zip(DEGREES, curve(), strict=True))]  # fmt: skip
    (one,) = fit_table(write(tmp_path / "t.csv", rows, ";"), "w", "i", [], "lambert-beckmann").fits
    assert one.result is not None
    assert one.result.values == pytest.approx(TRUE, rel=1e-6)


def test_empty_cells_and_lines_are_left_out(tmp_path: Path) -> None:
    rows: list[list[object]] = [["w", "i"], [10, ""], [], ["nan", 4], [90, 1], [-2, 1]]
    rows += [list(pair) for pair in zip(DEGREES, curve(), strict=True)]
    (one,) = fit_table(write(tmp_path / "t.csv", rows), "w", "i", [], "lambert-beckmann").fits
    assert one.n == len(DEGREES)
    assert len(one.warnings) == 2
    assert all(w.startswith("2 of 21") for w in one.warnings)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("w,j\n1,2\n", "no column 'i'.*w, j"),
        ("w,i,i\n1,2,3\n", "more than one column 'i'"),
        ("w,i\n1,2\n3,much\n", "row 3.*'much'.*column i"),
        ("w,i\n1,2\n1_0,2\n", "row 3.*'1_0'"),
        ("w,i\n1,2,3\n", "row 2 has 3 cells"),
        ("w,i\n", "no rows"),
        ("", "no column"),
        ('w,i\n1,"2\n', "not a readable table"),
    ],
)
def test_bad_tables_are_refused_in_words(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(BadInput, match=says):
        fit_table(path, "w", "i", [], "lambert")


def test_unreadable_files_are_refused_in_words(tmp_path: Path) -> None:
    binary = tmp_path / "scan.laz"
    binary.write_bytes(bytes(range(256)) * 9)
    for path, says in (
        (tmp_path / "none.csv", "No such file"),
        (tmp_path, "directory"),
        (binary, "UTF-8"),
    ):
        with pytest.raises(BadInput, match=says):
            fit_table(path, "w", "i", [], "lambert")


def test_unknown_model_is_wrong_use_before_the_file_is_read(tmp_path: Path) -> None:
    with pytest.raises(WrongUse, match="fourier-2"):
        fit_table(tmp_path / "none.csv", "w", "i", [], "phong")


def test_points_of_several_leaves() -> None:
    result = fit_by(Method(), "lambert-beckmann", np.tile(DEGREES, 3), np.tile(curve(), 3))
    assert result.values == pytest.approx(TRUE, rel=1e-9)
    assert result.n == 3 * len(DEGREES)
    held = fit_by(Method(), "lambert-beckmann", DEGREES, curve(), fixed={"m": 0.3})
    assert held.values["m"] == 0.3


def test_wrong_fixed_parameter_stops_all_groups() -> None:
    with pytest.raises(WrongUse, match="no parameter"):
        fit_groups([({}, DEGREES, curve())], "lambert", fixed={"m": 0.3})


def test_groups_can_be_cancelled() -> None:
    stop = LiveProgress(print, lambda: True)
    with pytest.raises(Cancelled):
        fit_groups([({}, DEGREES, curve())], "lambert", progress=stop)
