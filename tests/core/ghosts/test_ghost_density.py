from __future__ import annotations

import numpy as np
import pytest

from app.core.ghosts import score_ghosts

SCANNER = np.zeros(3)


def make_wall(distance: float, step: float = 0.0015, side: int = 60) -> np.ndarray:
    """Beams of equal steps on a wall, in random order."""
    angle = (np.arange(side) - side / 2) * step
    y, z = (a.ravel() for a in np.meshgrid(np.tan(angle), np.tan(angle)))
    wall = distance * np.stack([np.ones(side**2), y, z], axis=1)
    return np.random.default_rng(1).permutation(wall)


def test_where_beams_lie_too_far_apart_there_is_no_score() -> None:
    """The largest ball has a radius of 40 mm: at 24 m the beams are 36 mm apart."""
    near, far = make_wall(2.0), make_wall(24.0)
    found = score_ghosts(np.concatenate([near, far]), SCANNER)
    assert found.method == "density"
    assert np.isfinite(found.score[: len(near)]).all()
    assert (found.score[: len(near)] >= 0.5).mean() < 0.05
    assert np.isnan(found.score[len(near) :]).mean() > 0.9


def test_the_score_does_not_depend_on_who_is_asked_for() -> None:
    xyz = np.concatenate([make_wall(2.0), make_wall(12.0), [[1.0, 0.0, 0.0]]])
    whole = score_ghosts(xyz, SCANNER).score
    some = np.array([len(xyz) - 1, 5, 4000, 5])
    np.testing.assert_array_equal(score_ghosts(xyz, SCANNER, some).score, whole[some])
    assert whole[-1] == pytest.approx(1.0, abs=0.1), "nothing lies around it"
