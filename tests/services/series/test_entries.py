"""What scans of a series are: from tables, from names, typed; doubts are said."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.services.series.entries import Entry, read_entries, type_entries
from app.services.series.file_names import match_names, read_names
from app.services.series.order import SeriesOrder, list_scans, understand


def paths(*names: str) -> list[Path]:
    return [Path(f"{name}.laz") for name in names]


@pytest.mark.parametrize(
    ("names", "angles", "hours"),
    [
        (("leaf_angle_deg_-5", "leaf_angle_deg_0", "leaf_angle_deg_2.5"), (-5, 0, 2.5), None),
        (("a-05", "a-10"), (5, 10), None),  # this dash is no minus
        (("run1_30deg", "run1_35deg"), (30, 35), None),
        (("leaf 0h", "leaf 12h", "leaf 77h"), None, (0, 12, 77)),
        (("leaf_0_hours", "leaf_12_hours"), None, (0, 12)),
        (("dry_hours_0.5", "dry_hours_3"), None, (0.5, 3)),
        (("s1_deg0_t0", "s2_deg10_t5"), (0, 10), (0, 5)),
        (("x_2024-05-01T1030", "x_2024-05-01T1200"), None, (0, 1.5)),
        (("x_20240501_235900", "x_20240502_000000"), None, (0, 1 / 60)),
    ],
)
def test_names_tell(
    names: tuple[str, ...], angles: tuple[float, ...] | None, hours: tuple[float, ...] | None
) -> None:
    found = read_names(paths(*names)).entries
    assert [e.angle_deg for e in found] == list(angles or [None] * len(names))
    if hours is None:
        assert {e.hours for e in found} == {None}
    else:
        assert [e.hours for e in found] == pytest.approx(hours)


def test_what_was_understood_is_shown() -> None:
    assert read_names(paths("a_3deg_x", "a_4deg_x")).how == (
        "angle (deg) from names like a_{angle}deg_x"
    )
    assert "taken for degrees" in read_names(paths("a_3", "a_4")).how


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (("a_3", "b_4"), "not alike"),
        (("a_3", "a_3"), "No number changes"),
        (("a_3_4", "a_4_5"), "2 numbers change"),
        (("deg3_deg4", "deg4_deg5"), "2 numbers change"),
    ],
)
def test_doubtful_names(names: tuple[str, ...], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        read_names(paths(*names))


def test_patterns() -> None:
    found = match_names(paths("birch_a-10_x1", "oak_a5_x2"), "{treatment}_a{angle}_*")
    assert [(e.treatment, e.angle_deg) for e in found.entries] == [("birch", -10), ("oak", 5)]
    (one,) = match_names([Path("t_1,5.ptx")], "t_{hours}.ptx").entries
    assert one.hours == 1.5
    for pattern, says in (
        ("leaf", "no pattern"), ("{what}", "no pattern"), ("{angle}{angle}", "no pattern"),
        ("leaf_{angle}", "does not look like"),
    ):  # fmt: skip
        with pytest.raises(WrongUse, match=says):
            match_names(paths("birch_5"), pattern)


def test_a_table_tells(tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text(
        "Scan;Holder_angle;Time;Treatment;Comment\n"
        "run/A.laz;-2,5;2024-05-01T10:30;dry;first\n"
        "b.laz;;2024-05-01T12:00;;\n"
    )
    found = read_entries(paths("a", "b"), table)
    first, second = found.entries
    assert (first.angle_deg, first.hours, first.treatment, first.label) == (
        -2.5,
        0.0,
        "dry",
        "first",
    )
    assert (second.angle_deg, second.hours, second.treatment) == (None, 1.5, "")
    assert found.how == "angle, time, treatment, label from t.csv"


def test_the_table_of_a_simulated_series(tmp_path: Path) -> None:
    table = tmp_path / "series.csv"
    table.write_text("file,key,value,points\na.laz,stage.angle_deg,'-5,10\nb.laz,hours,3.0,10\n")
    first, second = read_entries(paths("a", "b"), table).entries
    assert (first.angle_deg, first.hours) == (-5.0, None)
    assert (second.angle_deg, second.hours) == (None, 3.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("angle\n5\n", "must have a column file"),
        ("file,x\na.laz,5\n", "must have a column file"),
        ("file,angle\nb.laz,5\n", "no row for a.laz"),
        ("file,angle\na.laz,5\nA.laz,6\n", "twice"),
        ("file,angle\na.laz,five\n", "row 2: 'five' in column angle is not a number"),
        ("file,time\na.laz,noon\n", "neither hours nor a time"),
        ("file,angle\na.laz,nan\n", "not a number"),
    ],
)
def test_tables_that_do_not_tell(tmp_path: Path, text: str, says: str) -> None:
    table = tmp_path / "t.csv"
    table.write_text(text)
    with pytest.raises(BadInput, match=says):
        read_entries(paths("a"), table)


def test_times_with_and_without_zone(tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("file,time\na.laz,2024-05-01T10:30\nb.laz,2024-05-01T10:30+02:00\n")
    with pytest.raises(BadInput, match="zone"):
        read_entries(paths("a", "b"), table)


def test_typed_values() -> None:
    found = type_entries(paths("a", "b"), "0, 7.5", "angle")
    assert [e.angle_deg for e in found.entries] == [0, 7.5]
    assert [e.hours for e in type_entries(paths("a"), "3", "hours").entries] == [3]
    for text in ("1", "1,x", ""):
        with pytest.raises(WrongUse):
            type_entries(paths("a", "b"), text, "angle")


def test_angles_and_times_from_two_places(tmp_path: Path) -> None:
    files = paths("a_5deg", "a_10deg")
    order = SeriesOrder(tuple(files), "find", angle_from="name", time_from="1,2")
    found = understand(files, order)
    assert [(e.angle_deg, e.hours) for e in found.entries] == [(5, 1), (10, 2)]
    assert found.turns
    alike = SeriesOrder(tuple(files), "find", same_pose=True)
    assert understand(paths("x", "y"), alike).entries[1] == Entry(Path("y.laz"), label="y")
    with pytest.raises(LeafscopeError):
        understand(paths("x", "y"), SeriesOrder(tuple(files), "find"))


def test_scans_of_a_folder(tmp_path: Path) -> None:
    for name in (
        "a_10.laz",
        "a_5.laz",
        "a_-5.laz",
        "series.csv",
        "a_5.laz.leafscope.json",
        "n.txt",
    ):
        (tmp_path / name).touch()
    assert [p.name for p in list_scans([tmp_path])] == ["a_-5.laz", "a_5.laz", "a_10.laz"]
    with pytest.raises(BadInput, match="does not exist"):
        list_scans([tmp_path / "x"])
    (tmp_path / "empty").mkdir()
    with pytest.raises(BadInput, match="no scan in the folder"):
        list_scans([tmp_path / "empty"])
