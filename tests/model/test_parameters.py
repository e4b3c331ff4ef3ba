"""Parameters refuse what cannot be, and read what older sessions hold."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from app.core.errors import WrongUse
from app.model.codec import decode, encode
from app.model.operations import SetParameters
from app.model.parameters import Beam, Parameters


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"estimator": "octree"}, "no estimator 'octree'.*adaptive, robust, window, ball"),
        ({"radius": 0.0}, "positive"),
        ({"radius": 3.0}, "larger than any leaf"),
        ({"ghost_threshold": 2.0}, "above 0 and up to 1, not at 2"),
        ({"ghost_threshold": 0.0}, "0 would call all so"),
        ({"ghost_threshold": float("nan")}, "above 0"),
    ],
)
def test_bad_values_are_refused_in_words(values: dict[str, object], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        Parameters(**values)


@pytest.mark.parametrize("numbers", [(-0.001, 0.0), (0.001, 1.0), (float("nan"), 0.0)])
def test_a_beam_that_cannot_be_is_refused(numbers: tuple[float, float]) -> None:
    with pytest.raises(WrongUse, match="half divergence"):
        Beam(*numbers)


def test_a_step_of_an_older_session_opens_with_the_usual_estimator() -> None:
    old = b'{"op":"SetParameters","scan":"scan-00001","parameters":{"radius":0.006}}'
    step = decode(old, {})
    assert isinstance(step, SetParameters)
    assert step.parameters == Parameters(radius=0.006)
    assert (step.parameters.estimator, step.parameters.beam) == ("adaptive", None)


def test_estimator_and_beam_are_stored() -> None:
    wanted = Parameters(estimator="ball", beam=Beam(0.0015, 0.00024, "instrument ls880"))
    step = SetParameters("scan-00001", wanted)
    assert decode(encode(step, {}, "a"), {}) == step
    assert b'"estimator":"ball"' in msgspec.json.encode(wanted)


def test_a_beam_of_numpy_numbers_is_stored_as_well() -> None:
    beam = Beam(np.float64(0.0015), np.float32(0.00025), "measured")
    assert (type(beam.radius), type(beam.half_divergence)) == (float, float)
    step = SetParameters("scan-00001", Parameters(beam=beam))
    assert decode(encode(step, {}, "a"), {}) == step
