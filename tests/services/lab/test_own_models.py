"""Formula models of one's own: kept, found, changed, and hostile files told and left."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.phase import MODELS, get_model
from app.core.phase.formula_model import FormulaDefinition, FormulaParameter
from app.services.lab.own_models import (
    LARGEST,
    delete_own,
    find_model,
    list_own,
    models_at_hand,
    names_in,
    own_folder,
    read_model,
    save_own,
    write_model,
)

OWN = FormulaDefinition(
    "Power of the cosine", "a*cos(omega)**p",
    (FormulaParameter("a", (0.1, 2.0), 0.0, None, "value", "value at face-on incidence", True),
     FormulaParameter("p", (0.2, 3.0))),
)  # fmt: skip
TEXT = """
name = "line"
expression = "a*(1 - s*omega)"
[[parameters]]
name = "a"
typical = [0, 2]
[[parameters]]
name = "s"
typical = [0.0, 1.0]
upper = 5
"""


def test_a_model_is_kept_and_found_by_name(own_models: Path) -> None:
    assert own_folder() == own_models
    assert list_own().models == {}
    path = save_own(OWN)
    assert path == own_models / "Power-of-the-cosine.toml"
    assert read_model(path) == OWN
    assert list_own().models == {OWN.name: OWN}
    assert find_model(OWN.name).formula == "a*cos(omega)**p"
    assert list(models_at_hand()) == [*MODELS, OWN.name]
    assert find_model("lambert") is get_model("lambert")


def test_one_of_the_same_name_is_changed_only_when_asked(own_models: Path) -> None:
    first = save_own(OWN)
    other = msgspec.structs.replace(OWN, expression="a*cos(omega)**(2*p)")
    with pytest.raises(BadInput, match="already"):
        save_own(other)
    assert save_own(other, overwrite=True) == first
    assert list_own().models[OWN.name] == other
    alike = msgspec.structs.replace(OWN, name="Power of the cosine!")
    assert save_own(alike).name == "Power-of-the-cosine-2.toml"
    delete_own(OWN.name)
    assert list(list_own().models) == [alike.name]
    with pytest.raises(WrongUse, match="no model"):
        delete_own(OWN.name)
    assert len(list(own_models.iterdir())) == 1


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"name": "lambert"}, "cannot be named"),
        ({"name": "a" * 61}, "1 to 60 characters"),
        ({"name": "two\nlines"}, "1 to 60 characters"),
        ({"name": ""}, "cannot be named"),
        ({"expression": "a*cos(omega)**p + q"}, "q"),
        ({"expression": "a*__import__('os').system('ls')**p*omega"}, "not allowed"),
        ({"expression": "a*omega.real**p"}, "dot"),
        ({"expression": "a*cos("}, "cannot be read"),
        ({"expression": "a + p"}, "does not depend on omega"),
        ({"parameters": ()}, "1 to 8 parameters"),
    ],
)
def test_what_cannot_be_a_model_is_refused_and_not_kept(
    own_models: Path, change: dict[str, object], says: str
) -> None:
    with pytest.raises(WrongUse, match=says):
        save_own(msgspec.structs.replace(OWN, **change))  # type: ignore[arg-type]
    assert not own_models.exists()


def test_files_are_read_as_people_write_them(tmp_path: Path) -> None:
    path = tmp_path / "line.toml"
    path.write_text(TEXT)
    found = read_model(path)
    assert found.parameters[1].upper == 5.0
    copy = tmp_path / "copy.toml"
    write_model(found, copy)
    assert read_model(copy) == found
    with pytest.raises(BadInput, match="exists"):
        write_model(found, copy)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "holds no formula model"),
        (b"\xff\xfe", "holds no formula model"),
        (b"name = 3", "holds no formula model"),
        (TEXT.replace("expression", "code").encode(), "holds no formula model"),
        (TEXT.replace("a*(1", "open('x')*(1").encode(), "not allowed"),
        (TEXT.replace("typical = [0, 2]", "typical = [nan, 2]").encode(), "usual range"),
        (TEXT.replace("typical = [0, 2]", "typical = [0, inf]").encode(), "usual range"),
        (TEXT.replace("a*(1", "+".join("a" for _ in range(400)) + "*(1").encode(), "characters"),
        (b"#" * (LARGEST + 1), "too large"),
    ],
)
def test_hostile_files_are_told_and_left(own_models: Path, content: bytes, says: str) -> None:
    save_own(OWN)
    (own_models / "bad.toml").write_bytes(content)
    with pytest.raises(BadInput, match=says):
        read_model(own_models / "bad.toml")
    found = list_own()
    assert list(found.models) == [OWN.name]
    assert len(found.faults) == 1
    assert "bad.toml" in found.faults[0]


def test_two_files_of_one_name_are_told(own_models: Path) -> None:
    save_own(OWN)
    write_model(OWN, own_models / "z.toml")
    assert "z.toml holds Power of the cosine, which another" in list_own().faults[0]


def test_names_of_an_expression() -> None:
    assert names_in("b*cos(omega)**a + b*where(omega < 1, c, 0)") == ("b", "a", "c")
    with pytest.raises(WrongUse, match="cannot be read"):
        names_in("b*(")
