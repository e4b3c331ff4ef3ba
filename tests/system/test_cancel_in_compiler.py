"""A cancel that comes while kernels are compiled, where faults of the compiler hide it."""

import pytest

from app import cli
from app.cli import commands
from app.cli.console import STOP


@pytest.mark.parametrize(("asked", "code", "said"), [(True, 4, "Cancelled."), (False, 1, "failed")])
def test_a_fault_after_a_wish_to_stop_is_the_cancel(monkeypatch, capsys, asked, code, said):
    def break_down(*_words, **_options):
        raise RuntimeError("no compiled object yet")

    monkeypatch.setattr(commands, "leafscope", break_down)
    monkeypatch.setattr(STOP, "_asked", asked)
    assert cli.run(["info", "x.laz"]) == code
    assert said in capsys.readouterr().err
