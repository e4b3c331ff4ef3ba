"""Tables of panels as people write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.core.errors import BadInput, WrongUse
from app.services.panel_columns import TableOptions, parse_columns, read_panels

NM = TableOptions(wavelength_nm=785.0)


def write(folder: Path, text: str) -> Path:
    path = folder / "panels.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_usual_names_in_any_case(tmp_path: Path) -> None:
    path = write(tmp_path, "Distance;Intensity;RHO;Material;Note\n4,5;1000;0,5;white;dry\n")
    found = read_panels(path, NM)
    (table,) = found.tables
    assert (table.distance[0], table.dn[0], table.reflectance[0]) == (4.5, 1000.0, 0.5)
    assert table.panels == ("white",)
    assert table.scans == ("1",)
    assert table.channel == "intensity_785"
    assert found.ignored == ("Note",)


def test_a_table_for_each_channel(tmp_path: Path) -> None:
    rows = "range,dn,rho,channel,nm\n4,10,0.5,a,690\n4,20,0.5,b,1550\n8,5,0.5,a,690\n"
    path = write(tmp_path, rows)
    first, second = read_panels(path).tables
    assert (first.channel, first.wavelength_nm, len(first)) == ("a", 690.0, 2)
    assert (second.wavelength_nm, second.lines.tolist()) == (1550.0, [3])
    (only,) = read_panels(path, TableOptions(channel="b")).tables
    assert only.dn.tolist() == [20.0]


def test_sigmas_and_percent(tmp_path: Path) -> None:
    path = write(tmp_path, "d,dn,rho,sigma_rho,sigma_dn\n4,10,50,1,0.5\n")
    options = TableOptions(percent=True, wavelength_nm=785.0)
    (table,) = read_panels(path, options).tables
    assert (table.reflectance[0], table.reflectance_sigma[0]) == (0.5, 0.01)
    assert table.dn_sigma is not None
    assert table.dn_sigma[0] == 0.5
    path = write(tmp_path, "d,dn,rho\n4,10,50\n")
    options = TableOptions(percent=True, wavelength_nm=785.0, panel_sigma=0.02)
    assert read_panels(path, options).tables[0].reflectance_sigma[0] == pytest.approx(0.01)


def test_columns_may_be_named_by_hand(tmp_path: Path) -> None:
    path = write(tmp_path, "how far,x,y\n4,10,0.5\n")
    options = TableOptions(("range=how far", "dn=x", "reflectance=y"), wavelength_nm=785.0)
    assert read_panels(path, options).tables[0].distance.tolist() == [4.0]
    with pytest.raises(WrongUse, match="names no column"):
        parse_columns(["colour=x"])


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("range,rho\n4,0.5\n", NM, r"no column for the dn.*--column dn=NAME"),
        ("range,d,dn,rho\n4,4,9,0.5\n", NM, r"two columns for the range.*--column range=NAME"),
        ("range,dn,rho\n4,9,0.5\n", TableOptions(), r"wavelength of panels.csv is missing.*--wave"),
        ("d,dn,rho,nm\n4,9,0.5,700\n4,9,0.6,800\n", TableOptions(), "two wavelengths, 700 and 800"),
        ("d,dn,rho,nm\n4,9,0.5,700\n", NM, "says 700 nm, not 785"),
        ("d,dn,rho,nm\n4,9,0.5,1.5\n", TableOptions(), "1.5 nm is impossible"),
        ("d,dn,rho\n4,nine,0.5\n", NM, "row 2: 'nine' in column dn is not a number"),
        ("d,dn,rho,channel\n4,9,0.5,a\n4,9,0.5,b\n", NM, "one wavelength for all"),
        ("d,dn,rho,channel\n4,9,0.5,a\n", TableOptions(channel="z"), "no channel z"),
        ("d,dn,rho,channel\n4,9,.5,a\n4,9,.5,b\n", TableOptions(), "channel and give --wavelength"),
        ("d,dn,rho,nm\n4,9,0.5,700\n", NM, "^panels.csv says"),
        ("d,dn,rho\n4,9,0.5\n", TableOptions(panel_sigma=2.0), "σ of 2 of a panel"),
        ("", NM, "no column for the range; its columns: none"),
        ("d,dn,rho\n", NM, "no rows"),
    ],
)
def test_bad_tables_are_told(tmp_path: Path, text: str, options: TableOptions, words: str) -> None:
    with pytest.raises((BadInput, WrongUse), match=words):
        read_panels(write(tmp_path, text), options)


def test_a_panel_without_a_name_is_named_by_its_reflectance(tmp_path: Path) -> None:
    path = write(tmp_path, "d,dn,rho,panel\n4,9,0.5,white\n4,8,0.25, \n4,7,0.12,\n")
    assert read_panels(path, NM).tables[0].panels == ("white", "0.25", "0.12")


def test_a_missing_or_binary_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="cannot be read"):
        read_panels(tmp_path / "none.csv", NM)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00d,dn\n")
    with pytest.raises(BadInput, match="UTF-8"):
        read_panels(tmp_path / "binary.csv", NM)
