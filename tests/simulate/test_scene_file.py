"""Scene files: read strictly, refused in words."""

import tomllib

import pytest

from app.core.errors import BadInput, WrongUse
from app.simulate.instrument import get_instrument
from app.simulate.scene_file import decode_scene, get_scene, list_scenes, load_document, read_scene

READY = {
    "branch", "crown", "drying", "goniometer", "leaf", "leaf_frame", "leaf_row", "lobed_leaf",
    "needle_row", "panels", "pear_row", "pulsed_leaves", "scattered", "shoot", "wall_edge",
}  # fmt: skip
TEN_LINES = """name = "mine"

[[part]]
kind = "leaf"
range = 3

[[part]]
kind = "wall"
range = 5
"""


def test_ready_scenes_are_the_promised_ones():
    assert set(list_scenes()) == READY


@pytest.mark.parametrize("name", sorted(READY))
def test_every_ready_scene_says_what_it_is_and_names_an_instrument(name):
    scene = get_scene(name)
    assert 20 < len(scene.description) < 100
    assert "\n" not in scene.description
    assert get_instrument(scene.instrument).name == scene.instrument


def test_a_new_scene_is_ten_lines(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(TEN_LINES, "utf-8")
    scene = read_scene(path)
    assert [part.range for part in scene.part] == [3, 5]
    assert (scene.field, scene.position, scene.instrument) == ("fit", (0, 0, 1.6), "two_colour")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "missing key `part`. Keys of a scene: name"),
        ("part = 3", "part: expected a list"),
        ("[[part]]\nlength = 1", "part.0: missing key `kind`. Say its `kind`: branch"),
        ("[[part]]\nkind = 'leav'", "part.0.kind: unknown value 'leav'. Kinds: branch"),
        ("[[part]]\nkind = 'leaf'\nlenght = 1", "part.0: unknown key `lenght`. Keys of leaf"),
        ("[[part]]\nkind = 'leaf'\nlength = -1", "part.0.length: expected a number > 0.0"),
        ("[[part]]\nkind = 'leaf'\nlength = 'a'", "part.0.length: expected a number, got text"),
        ("[[part]]\nkind = 'leaf'\nlength = nan", "part.0.length is not a finite number"),
        ("[[part]]\nkind = 'leaf'\nlength = 1" + "0" * 400, "part.0.length: the number is out of"),
        ("[[part]]\nkind = 'leaf'\ntilt_deg = 90", "part.0.tilt_deg: expected a number < 90"),
        ("[[part]]\nkind = 'leaf'\ncentre = [1, 2, 3]\nrange = 2", "`centre` stands instead"),
        ("[[part]]\nkind = 'leaf'\nnormal = [0, 0, 0]", "`normal`"),
        ("[[part]]\nkind = 'leaf'\nname = 'hours'", "cannot be named 'hours'"),
        ("[[part]]\nkind = 'leaf'\nname = '0'", "cannot be named '0'"),
        ("[[part]]\nkind = 'scatter'\nranges = [3, 2]", "part.0: `ranges` is turned round"),
        ("[[part]]\nkind = 'scatter'\ncount = 200001", "200 001 surfaces"),
        ("[[part]]\nkind = 'stem'\nstart = [1, 2, 3]\nend = [1, 2, 3]", "the same place"),
        ("seed = -1\n[[part]]\nkind = 'leaf'", "seed: expected a whole number >= 0"),
        ("hours = -1\n[[part]]\nkind = 'leaf'", "hours: expected a number >= 0"),
        ("field = 'wide'\n[[part]]\nkind = 'leaf'", "field: unknown value 'wide'"),
        (
            "field = {azimuth_deg = [2, 1], elevation_deg = [0, 1]}\n[[part]]\nkind = 'leaf'",
            "field: `azimuth_deg` is turned round",
        ),
        ("[[part]]\nkind = 'leaf'\nname = 'a'\n" * 2, "2 parts are named 'a'"),
    ],
)
def test_errors_name_file_and_key(text, words):
    document = tomllib.loads("name = 'bad'\n" + text)
    with pytest.raises(BadInput) as caught:
        decode_scene(document, "bad.toml")
    message = str(caught.value)
    assert message.startswith("bad.toml")
    assert words in message.replace("\u202f", " ")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"name = ", "no TOML|not a TOML"),
        (b"name = '\xff\xfe'", "not a TOML"),
        (b"x = " + b"[" * 100_000, "not a TOML"),
        (b"#" * (1 << 20) + b"#", "larger than 1 MB"),
    ],
)
def test_files_that_are_no_scenes_are_refused(tmp_path, content, words):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=words):
        read_scene(path)


def test_missing_files_and_names_are_refused(tmp_path):
    with pytest.raises(BadInput, match="cannot be read"):
        read_scene(tmp_path / "none.toml")
    with pytest.raises(WrongUse, match="Scenes: branch"):
        load_document("../materials/leaf")
