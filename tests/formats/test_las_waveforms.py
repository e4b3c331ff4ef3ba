"""Waveform packets of LAS: files by laspy with packets of our own, and hostile ones."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.special import erf

from app.cli import run
from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import las
from app.formats.cloud import Cloud, take_points
from app.formats.handover import load_scans, save_scans
from app.formats.options import ReadOptions
from app.model.scan import Pose, Scan
from app.services.export import export
from app.services.opening import Opening, open_file
from app.simulate.simulation import Simulation
from app.simulate.virtual_scan import simulate

EVLR_BYTES = 60
RECORD = {4: 28, 5: 34, 9: 30, 10: 38}  # byte of a point record where its packet is described


@dataclass(frozen=True)
class Kind:
    """A descriptor as a file holds it."""

    bits: int = 16
    samples: int = 40
    step_ps: int = 500
    gain: float = 0.01
    offset: float = -1.0
    compression: int = 0

    def pack(self) -> bytes:
        numbers = (self.bits, self.compression, self.samples, self.step_ps)
        return struct.pack("<BBIIdd", *numbers, self.gain, self.offset)


@dataclass(frozen=True)
class Packed:
    """Raw numbers of each packet, their kinds, and of each point its packet and place."""

    packets: Sequence[np.ndarray]
    kind_of: np.ndarray
    packet_of: np.ndarray
    place_ps: np.ndarray
    kinds: dict[int, Kind]


def make_packed(count: int = 50, bits: int = 16) -> Packed:
    """Packets of two kinds; some shared by two points, in no order, one point without any."""
    rng = np.random.default_rng(5)
    kinds = {1: Kind(bits), 7: Kind(bits, 64, 1000, 0.5, 3.0)}
    kind_of = rng.choice([1, 7], count)
    packets = [rng.integers(0, 2**bits, kinds[k].samples) for k in kind_of]
    packet_of = rng.permutation(np.repeat(np.arange(count), 2))[: count + 20]
    packet_of[3] = -1
    return Packed(packets, kind_of, packet_of, rng.uniform(0, 2e4, len(packet_of)), kinds)


def write_las(
    path: Path, packed: Packed, point_format: int = 9, internal: bool = True, xyz: Any = None
) -> Path:
    """A file by laspy, with its packets behind the points or in a .wdp."""
    header = laspy.LasHeader(
        point_format=point_format, version="1.3" if point_format < 6 else "1.4"
    )
    header.scales = np.full(3, 1e-5)
    for number, kind in packed.kinds.items():
        header.vlrs.append(laspy.VLR("LASF_Spec", 99 + number, "", kind.pack()))
    data = laspy.LasData(header)
    points = len(packed.packet_of)
    data.xyz = np.arange(3 * points).reshape(-1, 3) * 0.01 if xyz is None else xyz
    raw = [p.astype(f"<u{packed.kinds[k].bits // 8 or 1}").tobytes()
           for p, k in zip(packed.packets, packed.kind_of, strict=True)]  # fmt: skip
    sizes = np.array([len(r) for r in raw])
    starts = EVLR_BYTES + np.cumsum(sizes) - sizes
    has = packed.packet_of >= 0
    data.wavepacket_index = np.where(has, packed.kind_of[packed.packet_of], 0)
    data.wavepacket_offset = np.where(has, starts[packed.packet_of], 0)
    data.wavepacket_size = np.where(has, sizes[packed.packet_of], 0)
    data.return_point_wave_location = packed.place_ps
    data.write(path)
    block = struct.pack("<H16sHQ32s", 0, b"LASF_Spec", 65535, sizes.sum(), b"") + b"".join(raw)
    with path.open("r+b") as file:
        end = file.seek(0, os.SEEK_END)
        if internal:
            file.write(block)
        else:
            path.with_suffix(".wdp").write_bytes(block)
        file.seek(6)
        file.write(struct.pack("<H", 2 if internal else 4))
        file.seek(227)
        file.write(struct.pack("<Q", end if internal else 0))
    return path


def read(path: Path, **options: Any) -> Scan:
    (scan,) = las.read(path, ReadOptions(**options), QUIET)
    return scan


def patch_points(path: Path, fields: str, *values: Any, point_format: int = 9) -> Path:
    """Overwrite the packet of the first point: index B, offset Q, size I."""
    raw = bytearray(path.read_bytes())
    (first,) = struct.unpack_from("<I", raw, 96)
    place = first + RECORD[point_format] + {"B": 0, "Q": 1, "I": 9}[fields[0]]
    struct.pack_into(f"<{fields}", raw, place, *values)
    path.write_bytes(raw)
    return path


@pytest.mark.parametrize("internal", [True, False])
@pytest.mark.parametrize("bits", [8, 16, 32])
@pytest.mark.parametrize("point_format", [4, 5, 9, 10])
def test_samples_are_those_written(
    tmp_path: Path, point_format: int, bits: int, internal: bool
) -> None:
    packed = make_packed(bits=bits)
    scan = read(write_las(tmp_path / "w.las", packed, point_format, internal))
    assert scan.warnings == ()
    assert scan.waveforms is not None
    asked = np.random.default_rng(1).permutation(len(scan))[:40]
    asked[0] = 3
    found = scan.waveforms.read(asked)
    assert np.array_equal(np.diff(found.offsets), scan.waveforms.count_samples(asked))
    for i, point in enumerate(asked):
        volts = found.samples[found.offsets[i] : found.offsets[i + 1]]
        packet = packed.packet_of[point]
        if packet < 0:
            assert len(volts) == 0
            continue
        kind = packed.kinds[int(packed.kind_of[packet])]
        assert np.array_equal(volts, packed.packets[packet] * kind.gain + kind.offset)
        assert found.step_ns[i] == kind.step_ps / 1000
        assert found.place[i] == pytest.approx(packed.place_ps[point] / kind.step_ps, rel=1e-6)
        assert found.quantum[i] == kind.gain
        full = kind.offset + kind.gain * (2**bits - 1)
        assert full - kind.gain < found.ceiling[i] <= full


def same(one: Any, two: Any) -> bool:
    names = ("samples", "offsets", "step_ns", "place", "quantum", "ceiling")
    return all(np.array_equal(getattr(one, n), getattr(two, n)) for n in names)


def test_waveforms_follow_their_points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_las(tmp_path / "w.las", make_packed())
    monkeypatch.setattr(las, "_CHUNK", 16)
    scan = read(path)
    rows = np.arange(0, len(scan), 7)
    whole = scan.waveforms.read(rows)
    moved = scan.with_pose(Pose((0, 0, 0))).with_channels(()).with_xyz(scan.xyz + 1)
    assert moved.waveforms is scan.waveforms
    mask = np.isin(np.arange(len(scan)), rows)
    for part in (read(path, every_nth=7), take_points(scan, rows), take_points(scan, mask)):
        assert len(part.waveforms) == len(rows) == len(part)
        assert same(part.waveforms.read(np.arange(len(rows))), whole)
    with pytest.raises(BadInput, match="other points"):
        replace(scan, waveforms=part.waveforms)


def test_waveforms_survive_the_handover(tmp_path: Path) -> None:
    scan = read(write_las(tmp_path / "w.las", make_packed()))
    (folder := tmp_path / "folder").mkdir()
    columns = {**scan.waveforms.columns, "wavepacket_size": scan.waveforms.columns[
        "wavepacket_size"].copy()}  # fmt: skip
    save_scans([replace(scan, waveforms=replace(scan.waveforms, columns=columns))], folder)
    (back,) = load_scans(folder)
    assert same(
        back.waveforms.read(np.arange(len(scan))), scan.waveforms.read(np.arange(len(scan)))
    )
    shared = [n for n, a in back.waveforms.columns.items() if a is back.attributes[n]]
    assert len(shared) == 3  # held once, but for the copy
    assert (folder / "0-wavepacket_size.npy").exists()


@pytest.mark.parametrize("name", ["out.laz", "out.npz", "out.e57", "out.ply"])
def test_exports_are_as_before(tmp_path: Path, name: str) -> None:
    scan = read(write_las(tmp_path / "w.las", make_packed()))
    export(Cloud(scan).subset(np.arange(10)), tmp_path / name)
    if name.endswith(".laz"):
        back = read(tmp_path / name)
        assert back.waveforms is None
        assert np.array_equal(
            back.attributes["wavepacket_offset"], scan.attributes["wavepacket_offset"][:10]
        )


def refusal(path: Path) -> str:
    """What is said on reading all waveforms of a file whose points open all the same."""
    scan = read(path)
    assert len(scan) > 0
    with pytest.raises(BadInput) as error:
        scan.waveforms.read(np.arange(len(scan)))
    assert any(error.value.what in warning for warning in scan.warnings)
    return error.value.what


def test_a_missing_wdp_is_a_warning(tmp_path: Path) -> None:
    path = write_las(tmp_path / "w.las", make_packed(), internal=False)
    path.with_suffix(".wdp").unlink()
    assert refusal(path) == "w.wdp, which holds the waveforms of w.las, is missing."


def test_a_changed_or_cut_wdp_is_an_error(tmp_path: Path) -> None:
    path = write_las(tmp_path / "w.las", make_packed(), internal=False)
    scan, wdp = read(path), path.with_suffix(".wdp")
    wdp.write_bytes(wdp.read_bytes()[:-1000])
    with pytest.raises(BadInput, match=r"w\.wdp changed since it was opened"):
        scan.waveforms.read(np.arange(len(scan)))
    assert "waveforms lie outside w.wdp" in refusal(path)
    scan = read(path)
    inside = np.flatnonzero(scan.attributes["wavepacket_offset"] < 1000)
    assert len(scan.waveforms.read(inside).samples) > 0


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (Kind(bits=12), "12 bits per sample; 8, 16 and 32 can be read"),
        (Kind(bits=0), "0 bits per sample"),
        (Kind(compression=1), "compressed"),
        (Kind(samples=2**32 - 1), "4294967295 samples are impossible"),
        (Kind(samples=0), "0 samples are impossible"),
        (Kind(step_ps=0), "time between the samples"),
        (Kind(gain=0.0), "gain of 0"),
        (Kind(gain=np.nan), "gain of nan"),
        (Kind(offset=np.inf), "offset of inf"),
        (Kind(gain=1e300), "gain of 1e+300"),
    ],
)
def test_descriptors_that_cannot_be_read(tmp_path: Path, kind: Kind, said: str) -> None:
    packed = make_packed()
    path = write_las(tmp_path / "w.las", replace(packed, kinds={1: kind, 7: kind}))
    assert said in refusal(path)


@pytest.mark.parametrize(
    ("fields", "values", "said"),
    [
        ("B", (200,), "descriptor 200 is not in the file"),
        ("Q", (2**64 - 1,), "1 or more waveforms lie outside w.las"),
        ("Q", (10**6,), "1 or more waveforms lie outside w.las"),
        ("I", (2**32 - 1,), "1 or more waveforms lie outside w.las"),
    ],
)
@pytest.mark.parametrize("point_format", [4, 9])
def test_packets_that_lie_outside(
    tmp_path: Path, fields: str, values: tuple[int, ...], said: str, point_format: int
) -> None:
    path = write_las(tmp_path / "w.las", make_packed(), point_format)
    patch_points(path, "B", 1, point_format=point_format)
    assert said in refusal(patch_points(path, fields, *values, point_format=point_format))
    scan = read(path)
    assert len(scan.waveforms.read(np.arange(5, 10)).samples) > 0  # the others are as they were


def test_a_short_packet_has_fewer_samples(tmp_path: Path) -> None:
    path = write_las(tmp_path / "w.las", make_packed())
    patch_points(patch_points(path, "B", 1), "I", 11)
    assert read(path).waveforms.count_samples(np.arange(1)).tolist() == [5]


def test_a_file_without_any_packet_has_no_waveforms(tmp_path: Path) -> None:
    packed = make_packed()
    none = replace(packed, packet_of=np.full_like(packed.packet_of, -1))
    scan = read(write_las(tmp_path / "w.las", none))
    assert (scan.waveforms, scan.warnings) == (None, ())


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("fuzz") / "w.las"
    return write_las(path, make_packed(8)).read_bytes()


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage_never_ends_in_another_error(small: bytes, tmp_path: Path, data: Any) -> None:
    raw = bytearray(small)
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.one_of(st.just(6), st.integers(227, 234), st.integers(375, 900)))
        raw[place] = data.draw(st.sampled_from([0, 1, 8, 127, 128, 254, 255]))
    cut = data.draw(st.one_of(st.none(), st.integers(600, len(raw))))
    path = tmp_path / "w.las"
    path.write_bytes(raw[:cut])
    try:
        scan = read(path, recover=True)
        if scan.waveforms is not None:
            packets = scan.waveforms.read(np.arange(len(scan)))
            assert np.isfinite(packets.samples).all()
    except BadInput:
        pass


@pytest.mark.data
def test_a_real_file_without_its_wdp(shared_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = shared_data / "las_oddities" / "fullwave.laz"
    assert run(["info", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (
        found["details"]["waveforms"]
        == "10750 points, 2484 × 16 bit, 0.4 ns apart, in fullwave.wdp"
    )
    assert any("fullwave.wdp" in w and "missing" in w for w in found["warnings"])
    project, (key,) = open_file(Opening(path))
    with pytest.raises(BadInput, match=r"fullwave\.wdp.* is missing.*Put it beside"):
        project.field(key, "energy_sum", np.arange(5))


# A simulated SALCA scan, as a file with packets, through the command.


def pack_simulation(simulation: Simulation, channel: int) -> Packed:
    waves, scan = simulation.waveforms, simulation.scan
    assert waves is not None
    kind = Kind(16, waves.samples.shape[2], 500, 2e-5, -0.05)
    raw = np.round((waves.samples[:, channel] - kind.offset) / kind.gain)
    assert raw.min() >= 0
    raw = np.minimum(raw, 2**16 - 1).astype(np.int64)
    distance = np.linalg.norm(scan.xyz - scan.scanner("a test"), axis=1)
    place = (distance - waves.start[waves.of_return]) / waves.step * kind.step_ps
    return Packed(list(raw), np.ones(len(raw), int), waves.of_return, place, {1: kind})


@pytest.mark.parametrize("internal", [True, False])
def test_energies_of_a_simulated_salca_scan(
    tmp_path: Path, internal: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """Points that are one whole surface: energies against the truth, in units of their σ."""
    simulation = simulate("panels", "salca", step_deg=0.15, keep_waveforms=True)
    packed, scan = pack_simulation(simulation, 0), simulation.scan
    path = write_las(tmp_path / "w.las", packed, 4, internal, scan.xyz)
    words = [w for m in ("sum", "peak", "gaussian") for e in ("", "_sigma") for w in
             ("--field", f"energy_{m}{e}")]  # fmt: skip
    report = tmp_path / "r.json"
    assert run(["compute", str(path), *words, "--out", str(tmp_path / "e.npz"),
                "--report", str(report)]) == 0  # fmt: skip
    capsys.readouterr()
    notes = json.loads(report.read_text())["notes"]["energy_sum"]
    assert notes["threshold_sigmas"] == 5.0
    assert notes["median_noise_v"] == pytest.approx(0.001, rel=0.03)
    assert notes["without_waveform"] == 0
    with np.load(tmp_path / "e.npz") as found:
        energies = {n: found[n] for n in found.files if n.startswith("energy")}
    assert len(energies["energy_sum"]) == len(scan)
    check_energies(simulation, energies)


def check_energies(simulation: Simulation, energies: dict[str, np.ndarray]) -> None:
    """The simulator's pulse has the height of the reflectance: 1 ns long, two samples in it."""
    truth = simulation.scan.attributes
    whole = (truth["truth_components"] == 1) & (truth["truth_hit_fraction"] > 0.999)
    assert whole.sum() > 1000
    height = truth["truth_reflectance_1063"].astype(float)
    area = height * np.sqrt(np.pi / (4 * np.log(2))) * (0.299792458 / 2 / 0.075) * 0.5
    share = erf(np.sqrt(np.log(height / 0.005)))  # the sum misses the feet of the pulse
    for name, wanted in (("sum", area * share), ("peak", height), ("gaussian", area)):
        error = energies[f"energy_{name}"] - wanted
        z = (error / energies[f"energy_{name}_sigma"])[whole]
        assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.1), name
        assert np.mean(np.abs(z) < 2) > 0.94, name
        assert abs(np.mean((error / wanted)[whole])) < 0.003, name
