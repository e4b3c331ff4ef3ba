"""What a surface may be."""

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.simulate.branch import LEAF
from app.simulate.surfaces import Leaf, Stem

EGG = Leaf((2.0, 0.0, 0.0), (0, 0, -1), (-1, 0, 0), 0.075, 0.05, LEAF, 0.3)


def test_a_bend_is_refused_with_the_bound_that_is_tested():
    radius = np.hypot(0.0375, 0.025 * 1.3)
    with pytest.raises(WrongUse, match=rf"{radius:.3g} m.* {0.95 / radius:.3g} per metre") as error:
        replace(EGG, curvature=-20.0)
    assert "half length" not in str(error.value)
    assert replace(EGG, curvature=-19.1).slab()[0] < -0.03


def test_wrinkles_shorter_or_steeper_than_the_tracer_can_follow_are_refused():
    with pytest.raises(WrongUse, match=r"wrinkles 0\.004 m long.*0\.005 m"):
        replace(EGG, wrinkle_height=1e-5, wrinkle_lengths=(0.03, 0.004))
    with pytest.raises(WrongUse, match=r"too steep.* 3 is the most"):
        replace(EGG, wrinkle_height=0.003, wrinkle_lengths=(0.005, 0.03))
    assert replace(EGG, wrinkle_height=0.002, wrinkle_lengths=(0.005, 0.03)).wave_slope() < 3


def test_a_stem_of_no_length_is_refused():
    with pytest.raises(WrongUse, match="same place"):
        Stem((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.1, LEAF)
