"""What the window asks of a table of panels, and the report that it writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput
from app.services.calibrate import calibrate_table
from app.services.panel_columns import TableOptions
from app.services.panel_files import look_at_table, write_report

RHOS = (0.12, 0.25, 0.5, 0.99)


def write_table(path: Path, head: str = "", tail: str = "", scale: float = 1.0) -> Path:
    rows = [f"range,dn,reflectance,panel{head}"]
    chance = np.random.default_rng(2)
    for rho in RHOS:
        dn = 2000 + 1200 * np.log10(rho) + chance.normal(0, 2)
        rows.append(f"4.4,{dn:.2f},{scale * rho:g},{100 * rho:g}%{tail}")
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def test_a_look_tells_what_is_there(tmp_path: Path) -> None:
    look = look_at_table(write_table(tmp_path / "a.csv", ",wavelength_nm", ",1550"))
    assert (look.rows, look.panels, look.scans) == (4, 4, 1)
    assert not look.wavelength_missing
    assert not look.looks_percent


def test_a_look_tells_what_has_to_be_asked(tmp_path: Path) -> None:
    look = look_at_table(write_table(tmp_path / "a.csv", scale=100.0))
    assert look.wavelength_missing
    assert look.looks_percent
    assert look.brightest == 99.0


def test_no_table_is_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x,y\n1,2\n", encoding="utf-8")
    with pytest.raises(BadInput, match="has no column for the range"):
        look_at_table(path)


def test_a_report_comes_with_its_picture_and_spares_other_pictures(tmp_path: Path) -> None:
    options = TableOptions(wavelength_nm=1550.0)
    found = calibrate_table(write_table(tmp_path / "a.csv"), "log", options)
    report, picture = tmp_path / "report.md", tmp_path / "report.png"
    picture.write_bytes(b"somebody's own")
    with pytest.raises(BadInput, match="exists already"):
        write_report(found, report, overwrite=True)
    assert not report.exists()
    assert picture.read_bytes() == b"somebody's own"
    picture.unlink()
    write_report(found, report)
    assert "reflectance_1550" in report.read_text(encoding="utf-8")
    assert picture.read_bytes().startswith(b"\x89PNG")
    write_report(found, report, overwrite=True)
