"""One value of a scene varied."""

import copy

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput, WrongUse
from app.simulate.scene_file import decode_scene, get_scene, list_scenes, load_document
from app.simulate.series import parse_series, parse_settings, series_of, vary

DOCUMENT = {
    "name": "two",
    "part": [
        {"kind": "wall", "range": 5},
        {"kind": "goniometer", "name": "stage", "range": 2},
    ],
}


@pytest.mark.parametrize("path", ["part.1.angle_deg", "stage.angle_deg"])
def test_a_part_is_found_by_number_and_by_name(path):
    before = copy.deepcopy(DOCUMENT)
    varied = vary(DOCUMENT, path, 40)
    assert varied["part"][1] == {"kind": "goniometer", "name": "stage", "range": 2, "angle_deg": 40}
    assert varied["part"][0] is DOCUMENT["part"][0]
    assert before == DOCUMENT
    assert decode_scene(varied, "two").part[1].angle_deg == 40


def test_top_level_and_nested_values():
    assert vary(DOCUMENT, "hours", 12)["hours"] == 12
    assert vary(DOCUMENT, "wind.amplitude", 0.01)["wind"] == {"amplitude": 0.01}
    frame = get_scene("drying").part[0]
    document = vary(load_document("drying"), "frame.leaves.drying.hours", 5.0)
    assert decode_scene(document, "x").part[0].leaves.drying.hours == 5.0
    assert frame.leaves.drying.hours == 24.0


@pytest.mark.parametrize(
    "path", ["part.2.range", "part.x.range", "leaf.range", "name.x", "part.-1.range", "", "part."]
)
def test_paths_that_lead_nowhere_are_refused(path):
    with pytest.raises(WrongUse, match="leads nowhere"):
        vary(DOCUMENT, path, 1)


def test_keys_that_do_not_exist_are_refused_when_decoded():
    for path in ("angle", "stage.angle"):
        with pytest.raises(BadInput, match="unknown key `angle`"):
            decode_scene(vary(DOCUMENT, path, 1), "two")


def test_settings_are_read_as_toml_values():
    texts = ["stage.angle_deg = 30", "instrument=salca", "field={azimuth_deg=[1, 2]}", "a=-2.5e-1"]
    assert parse_settings(texts) == (
        ("stage.angle_deg", 30),
        ("instrument", "salca"),
        ("field", {"azimuth_deg": [1, 2]}),
        ("a", -0.25),
    )


@pytest.mark.parametrize("text", ["hours", "=3", "hours=", "hours=1 2", "a=1\nb=2", "a=[", "a='"])
def test_unreadable_settings_are_refused(text):
    with pytest.raises(WrongUse):
        parse_settings([text])


def test_series_of_steps_reaches_both_ends():
    series = parse_series("stage.angle_deg=0:85:5")
    assert series.path == "stage.angle_deg"
    assert series.values == tuple(range(0, 86, 5))
    assert parse_series("a=0:0.3:0.1").values == (0, 0.1, 0.2, 0.3)
    assert parse_series("a=50:-50:-50").values == (50, 0, -50)
    assert parse_series("a=2:2:1").values == (2,)
    assert parse_series("hours=0,3, 6.5").values == (0, 3, 6.5)


@given(st.integers(-50, 50), st.integers(0, 60), st.sampled_from([1, 5, 0.5, 0.1, 0.25]))
def test_steps_are_counted_exactly(start, count, step):
    values = parse_series(f"x={start}:{start + count * step}:{step}").values
    assert values == pytest.approx([start + k * step for k in range(count + 1)], abs=1e-9)


@pytest.mark.parametrize(
    "text", ["a=0:1:0", "a=0:1:-1", "a=0:1", "a=0:1e9:0.1", "a=x:y:z", "a=0:nan:1", "a=,", "a"]
)
def test_impossible_series_are_refused(text):
    with pytest.raises(WrongUse):
        parse_series(text)


def test_every_ready_series_fits_its_scene():
    carried = [name for name in list_scenes() if get_scene(name).series is not None]
    assert {"goniometer", "leaf_frame", "drying", "panels"} <= set(carried)
    assert series_of(get_scene("goniometer").series).values == tuple(range(0, 86, 5))
    for name in carried:
        series = series_of(get_scene(name).series)
        for value in series.values:
            decode_scene(vary(load_document(name), series.path, value), name)
