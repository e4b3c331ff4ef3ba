"""Tables filled row by row, the pattern that names follow, and what scans need of the memory."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import psutil
import pytest

from app.core.errors import BadInput, WrongUse
from app.services.series import memory
from app.services.series.entries import Understood, read_entries
from app.services.series.file_names import guess_pattern, match_names, read_names
from app.services.series.filling import fill_entries
from app.services.series.memory import estimate_need, refuse_too_much, show_size
from app.services.series.opening import read_all


def paths(*names: str) -> list[Path]:
    return [Path(f"{name}.laz") for name in names]


def by_pattern(pattern: str, files: Sequence[Path]) -> Understood:
    return match_names(files, pattern)


@pytest.mark.parametrize(
    ("names", "pattern"),
    [
        (("leaf_angle_deg_-5", "leaf_angle_deg_0"), "leaf_angle_deg_{angle}"),
        (("run1_30deg", "run1_35deg"), "run*_{angle}deg"),
        (("s1_deg0_t0", "s2_deg10_t5"), "s*_deg{angle}_t{hours}"),
        (("x_20240501_235900", "x_20240502_000000"), "x_{time}"),
        (("a-05", "a-10"), "a-{angle}"),
    ],
)
def test_the_pattern_that_is_guessed_reads_the_same(names: tuple[str, ...], pattern: str) -> None:
    files = paths(*names)
    assert guess_pattern(files) == pattern
    assert match_names(files, pattern).entries == read_names(files).entries


def test_names_that_do_not_fit_are_told_and_the_others_read() -> None:
    files = paths("leaf_0", "leaf_30", "panel", "leaf_60")
    filled = fill_entries(files, partial(by_pattern, "leaf_{angle}"))
    assert [e and e.angle_deg for e in filled.entries] == [0, 30, None, 60]
    assert filled.bad == 1
    assert "panel.laz does not look like" in filled.problems[2]
    with pytest.raises(WrongUse, match="does not look like"):
        fill_entries(files, partial(by_pattern, "wrong_{angle}"))


def test_hours_are_counted_from_the_first_of_those_that_fit() -> None:
    files = paths("x_20240501_1000", "other", "x_20240501_1130")
    filled = fill_entries(files, partial(by_pattern, "x_{time}"))
    assert [e and e.hours for e in filled.entries] == [0, None, 1.5]


def test_a_table_that_lacks_a_file_fills_the_others(tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("file,angle,treatment\na.laz,'-30,wet\nb.laz,-10,dry\nc.laz,x,\n")
    filled = fill_entries(paths("a", "b", "c", "d"), lambda files: read_entries(files, table))
    assert [e and e.angle_deg for e in filled.entries] == [-30, -10, None, None]
    assert "row 4" in filled.problems[2]
    assert "no row for d.laz" in filled.problems[3]


def test_what_scans_need_is_known_before_they_are_read(
    stage: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = sorted(stage.glob("*.laz"))
    need = estimate_need(files)
    scans = read_all(files[:2])
    assert need.scans == 6
    assert need.points > sum(map(len, scans))
    assert need.fits
    assert need.memory > sum(scan.xyz.nbytes for scan in scans)
    refuse_too_much(need)
    tiny = psutil.virtual_memory()._replace(available=10 * 2**20)
    monkeypatch.setattr(memory.psutil, "virtual_memory", lambda: tiny)
    with pytest.raises(BadInput, match=r"6 scans with .* need up to .* MiB") as told:
        read_all(files)
    assert "two scans at a time" in str(told.value)
    assert show_size(3 * 2**30) == "3.0 GiB"
