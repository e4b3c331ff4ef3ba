"""Energies as fields: listed where there are waveforms, computed for the points asked for."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np
import pytest

from app.core.arrays import AnyArray, Ints
from app.core.errors import WrongUse
from app.model.operations import AddScan, SetParameters
from app.model.project import Project
from app.model.scan import Scan
from app.model.waveforms import MOST_SAMPLES, Packets, Waveforms, split_points

KEY = "scan-00001"
LENGTH = 120
ENERGIES = {f"energy_{m}{e}" for m in ("sum", "peak", "gaussian") for e in ("", "_sigma")}


@dataclass(frozen=True, eq=False)
class Pulses:
    """Waveforms in memory: a pulse of some height in the middle of each; none where it is NaN."""

    height: AnyArray
    asked: list[int]

    def __len__(self) -> int:
        return len(self.height)

    def count_samples(self, points: Ints) -> Ints:
        return np.where(np.isfinite(self.height[points]), LENGTH, 0)

    def read(self, points: Ints) -> Packets:
        self.asked.extend(points.tolist())
        count = self.count_samples(points)
        x = np.arange(LENGTH) - LENGTH / 2
        rows = [
            20 + self.height[p] * np.exp(-0.5 * (x / 3.0) ** 2)
            + np.random.default_rng(p).standard_normal(LENGTH)
            for p in points[count > 0]
        ]  # fmt: skip
        one = np.ones(len(points))
        offsets = np.concatenate([[0], np.cumsum(count)])
        samples = np.concatenate([np.empty(0), *rows])
        return Packets(np.minimum(samples, 200.0), offsets, 0.5 * one, LENGTH / 2 * one,
                       0.01 * one, 200.0 * one)  # fmt: skip

    def take(self, points: AnyArray) -> Waveforms:
        return Pulses(self.height[points], self.asked)


def make_project(height: list[float]) -> tuple[Project, Pulses]:
    pulses = Pulses(np.array(height), [])
    project = Project()
    scan = Scan("pulses", np.zeros((len(height), 3)), waveforms=pulses)
    project.do(AddScan(project.shelve(scan), "pulses", None))
    return project, pulses


def test_listed_only_where_there_are_waveforms() -> None:
    project, _ = make_project([30.0])
    assert set(project.catalogue(KEY)) >= ENERGIES
    bare = Project()
    bare.do(AddScan(bare.shelve(Scan("bare", np.zeros((3, 3)))), "bare", None))
    assert not ENERGIES & set(bare.catalogue(KEY))
    with pytest.raises(WrongUse, match="no field energy_sum"):
        bare.field(KEY, "energy_sum")


def test_only_the_points_asked_for_are_read_and_once() -> None:
    project, pulses = make_project(np.linspace(20, 100, 50).tolist())
    few = np.array([40, 3, 17])
    found = project.field(KEY, "energy_gaussian", few)
    area = pulses.height[few] * 3.0 * np.sqrt(2 * np.pi) * 0.5
    assert found == pytest.approx(area, rel=0.1)
    for name in sorted(ENERGIES):
        assert np.all(project.field(KEY, name, few) > 0)
    assert pulses.asked == few.tolist()
    project.field(KEY, "energy_sum")
    assert sorted(pulses.asked) == list(range(50))


def test_notes_say_what_is_not_as_it_should_be() -> None:
    project, _ = make_project([50.0, np.nan, 0.0, 300.0, 60.0])
    energy = project.field(KEY, "energy_sum")
    assert np.array_equal(np.isfinite(energy), [True, False, False, True, True])
    notes = project.cache.known(KEY)["energy_sum"].notes
    assert notes["threshold_sigmas"] == 5.0
    assert notes["median_noise_v"] == pytest.approx(1.0, rel=0.1)
    assert (notes["without_waveform"], notes["saturated"], notes["merged"]) == (1, 1, 0)
    assert notes["without_signal"] == 1
    known = project.cache.known(KEY)["energy_sum"]
    assert known.beside["saturated"].tolist()[:3] == [0, 0, 0]
    assert known.beside["saturated"][3] > 3


def test_a_scan_without_any_packet_has_energies_that_are_nan() -> None:
    project, _ = make_project([np.nan, np.nan])
    assert np.isnan(project.field(KEY, "energy_sum")).all()
    assert project.cache.known(KEY)["energy_sum"].notes["median_noise_v"] is None
    empty, _ = make_project([])
    assert len(empty.field(KEY, "energy_peak")) == 0


def test_the_threshold_is_a_parameter() -> None:
    project, pulses = make_project([100.0] * 20)
    strict = project.field(KEY, "energy_sum").copy()
    old = project.state.scan(KEY).parameters
    project.do(SetParameters(KEY, msgspec.structs.replace(old, waveform_threshold=3.0)))
    more = project.field(KEY, "energy_sum") - strict
    assert np.all(more >= 0.0)  # samples of 3 to 5 σ, each over half a nanosecond
    assert more.mean() > 1.0
    assert len(pulses.asked) == 40
    project.undo()
    assert np.array_equal(project.field(KEY, "energy_sum"), strict)


def test_pieces_hold_every_point_once_and_few_samples() -> None:
    rng = np.random.default_rng(1)
    pulses = Pulses(np.where(rng.random(1000) < 0.2, np.nan, 1.0), [])
    points = rng.permutation(1000)
    pieces = split_points(pulses, points, 10 * LENGTH)
    assert np.array_equal(np.concatenate(pieces), points)
    sizes = [pulses.count_samples(piece).sum() for piece in pieces]
    assert max(sizes) <= 11 * LENGTH
    assert len(pieces) == pytest.approx(sum(sizes) / (10 * LENGTH), abs=1.5)
    assert len(split_points(pulses, points[:0])) == 1
    assert MOST_SAMPLES >= 100_000
