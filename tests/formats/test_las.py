"""LAS and LAZ against laspy as the independent reader, and against hostile headers."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import las
from app.formats.channels import name_constants
from app.formats.cloud import Cloud
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.saving import save
from app.model.scan import Channel, Grid, Pose, Scan

POINTS = 1000
# Byte, struct format of fields of the public header (LAS 1.4).
FIELDS = {
    "major": (24, "B"), "minor": (25, "B"), "header size": (94, "H"), "offset": (96, "I"),
    "vlrs": (100, "I"), "format": (104, "B"), "record": (105, "H"), "legacy count": (107, "I"),
    "scale x": (131, "d"), "scale z": (147, "d"), "offset x": (155, "d"), "max x": (179, "d"),
    "waveform": (227, "Q"), "evlr start": (235, "Q"), "evlrs": (243, "I"), "count": (247, "Q"),
}  # fmt: skip
FLOATS = (0.0, 1.0, np.nan, np.inf, -1.0, 1.7e308, 5e-324)


def read(path: Path, **options: Any) -> Scan:
    (scan,) = las.read(path, ReadOptions(**options), QUIET)
    return scan


def make_file(path: Path, point_format: int = 7, version: str = "1.4") -> Path:
    """A file by laspy, with a plain, a scaled and a triple extra field."""
    rng = np.random.default_rng(7)
    header = laspy.LasHeader(point_format=point_format, version=version)
    header.scales, header.offsets = np.array([1e-4, 1e-4, 1e-3]), np.array([5e5, 4e6, 0.0])
    header.add_extra_dims(
        [
            laspy.ExtraBytesParams("Reflectance", "f4", "dB"),
            laspy.ExtraBytesParams("Amplitude", "u2", scales=[0.01], offsets=[-5.0]),
            laspy.ExtraBytesParams("normal", "3f4"),
        ]
    )
    data = laspy.LasData(header)
    for key in ("X", "Y", "Z"):
        data[key] = rng.integers(-(2**31), 2**31, POINTS)
    data.intensity = rng.integers(0, 65536, POINTS)
    data.return_number[:] = rng.integers(1, 6, POINTS)
    data.classification[:] = rng.integers(0, 32, POINTS)
    data["Reflectance"] = rng.normal(size=POINTS)
    data.points.array["Amplitude"] = rng.integers(0, 65536, POINTS)
    data["normal"] = rng.normal(size=(POINTS, 3))
    data.write(path)
    return path


def patch(path: Path, place: int, kind: str, value: Any) -> Path:
    raw = bytearray(path.read_bytes())
    struct.pack_into(f"<{kind}", raw, place, value)
    path.write_bytes(raw)
    return path


def largest(kind: str) -> int:
    return int(2 ** (8 * struct.calcsize(kind)) - 1)


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize(
    ("point_format", "version"), [(0, "1.2"), (3, "1.2"), (6, "1.4"), (7, "1.4")]
)
def test_values_are_those_of_laspy(
    tmp_path: Path, suffix: str, point_format: int, version: str
) -> None:
    path = make_file(tmp_path / f"a{suffix}", point_format, version)
    scan, truth = read(path), laspy.read(path)
    assert las.preflight(path).points == len(scan) == POINTS
    assert np.array_equal(scan.xyz, truth.xyz)
    for name in truth.point_format.dimension_names:
        if name in ("X", "Y", "Z", "normal"):
            continue
        assert np.array_equal(scan.attributes[name], np.asarray(truth[name])), name
    assert np.array_equal(scan.attributes["normal_2"], truth["normal"][:, 2])
    assert scan.attributes["intensity"].dtype == np.uint16
    assert scan.attributes["Reflectance"].dtype == np.float32
    assert scan.attributes["Amplitude"].dtype == np.float64
    assert scan.pose is None
    assert {c.name for c in scan.channels} == {"intensity", "Reflectance", "Amplitude"}


def test_every_nth_takes_the_first_of_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make_file(tmp_path / "a.las")
    monkeypatch.setattr(las, "_CHUNK", 64)  # no multiple of 7: the phase must carry over
    whole, part = read(path), read(path, every_nth=7)
    assert np.array_equal(part.xyz, whole.xyz[::7])
    assert np.array_equal(part.attributes["intensity"], whole.attributes["intensity"][::7])


def test_intensity_of_zeros_is_no_channel(tmp_path: Path) -> None:
    data = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    data.X = np.arange(5)
    data.write(tmp_path / "a.las")
    scan = read(tmp_path / "a.las")
    assert scan.channels == ()
    (said,) = name_constants(scan.attributes)
    assert said == "Intensity is 0 throughout: it holds no measurement."


def test_a_file_without_points_is_a_scan(tmp_path: Path) -> None:
    laspy.LasData(laspy.LasHeader(point_format=3, version="1.2")).write(tmp_path / "a.las")
    scan = read(tmp_path / "a.las")
    assert len(scan) == 0
    assert any("no points" in warning for warning in scan.warnings)


def test_cut_las_names_what_can_be_recovered(tmp_path: Path) -> None:
    path = make_file(tmp_path / "a.las")
    whole = read(path)
    layout = struct.unpack("<H", path.read_bytes()[105:107])[0]
    path.write_bytes(path.read_bytes()[: -layout * 300 - 5])
    with pytest.raises(BadInput, match=r"only 699 complete records.*--recover"):
        las.preflight(path)
    part = read(path, recover=True)
    assert np.array_equal(part.xyz, whole.xyz[:699])
    assert any("699" in warning for warning in part.warnings)


def test_cut_laz_is_recovered_up_to_the_damage(tmp_path: Path) -> None:
    path = make_file(tmp_path / "a.laz", 3, "1.2")
    whole, raw = read(path), path.read_bytes()
    path.write_bytes(raw[: len(raw) * 2 // 3])
    with pytest.raises(BadInput, match="chunk table"):
        las.preflight(path)
    part = read(path, recover=True)
    assert 100 < len(part) < POINTS
    assert np.array_equal(part.xyz, whole.xyz[: len(part)])


@pytest.mark.parametrize("field", FIELDS)
def test_any_header_value_gives_a_scan_or_a_sentence(tmp_path: Path, field: str) -> None:
    place, kind = FIELDS[field]
    if kind == "d":
        values: tuple[Any, ...] = FLOATS
    else:
        now = struct.unpack_from(f"<{kind}", make_file(tmp_path / "a.las").read_bytes(), place)[0]
        most = largest(kind)
        values = (0, 1, most, most // 2, most // 2 + 1, min(now + 1, most), max(now - 1, 0))
    for value in values:
        path = patch(make_file(tmp_path / "a.las"), place, kind, value)
        for recover in (False, True):
            with suppress(BadInput):
                header = las.preflight(path, ReadOptions(recover=recover))
                assert header.points * 20 <= path.stat().st_size
                assert len(read(path, recover=recover)) == header.points


@settings(
    deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_random_damage_gives_a_scan_or_a_sentence(tmp_path: Path, data: st.DataObject) -> None:
    path = tmp_path / "a.las"
    raw = bytearray((make_file(path) if not path.exists() else path).read_bytes())
    end = struct.unpack_from("<I", raw, 96)[0]
    for _ in range(data.draw(st.integers(1, 4))):
        raw[data.draw(st.integers(4, end - 1))] = data.draw(st.integers(0, 255))
    damaged = tmp_path / "b.las"
    damaged.write_bytes(raw[: data.draw(st.integers(0, len(raw)))])
    with suppress(BadInput):
        assert len(las.read(damaged, DEFAULTS, QUIET)) == 1


@pytest.mark.parametrize("count", [0xFFFFFFFF, 0x7FFFFFFF, 1000])
def test_laz_chunk_count_never_reaches_the_decoder(tmp_path: Path, count: int) -> None:
    path = make_file(tmp_path / "a.laz")
    raw = path.read_bytes()
    offset = struct.unpack_from("<I", raw, 96)[0]
    table = struct.unpack_from("<q", raw, offset)[0]
    patch(path, table + 4, "I", count)
    with pytest.raises(BadInput, match="chunks"):
        las.preflight(path)


@pytest.mark.parametrize("place", [0, 1, -2, 2**62, 400])
def test_laz_chunk_table_outside_the_file(tmp_path: Path, place: int) -> None:
    path = make_file(tmp_path / "a.laz")
    patch(path, struct.unpack_from("<I", path.read_bytes(), 96)[0], "q", place)
    with pytest.raises(BadInput, match="chunk table"):
        las.preflight(path)


def test_vlr_count_of_billions_costs_nothing(tmp_path: Path) -> None:
    path = patch(make_file(tmp_path / "a.las"), 100, "I", 2**31)
    assert any("header records" in warning for warning in las.preflight(path).warnings)
    assert len(read(path)) == POINTS


def make_cloud(n: int = 200) -> Cloud:
    rng = np.random.default_rng(3)
    row, column = np.divmod(np.arange(n, dtype=np.int32), 20)
    attributes = {
        "intensity": rng.integers(0, 65536, n).astype(np.uint16),
        "gps_time": rng.normal(size=n),
        "return_number": rng.integers(16, 200, n).astype(np.uint8),  # does not fit its four bits
        "red": rng.integers(0, 255, n).astype(np.uint8),  # LAS colours have 16 bits
        "reflectance_1063": rng.normal(size=n).astype(np.float32),
        "X": np.arange(n, dtype=np.int64),
        "a name that is far too long for the 32 bytes of LAS": np.arange(n, dtype=np.int8),
        "a name that is far too long for the 32 bytes of LAZ": np.arange(n, dtype=np.uint32),
        "Winkel ω": rng.normal(size=n),
    }
    scan = Scan(
        "s",
        rng.normal(size=(n, 3)) * 10 + (4.1e5, 5.2e6, 100),
        attributes,
        (Channel("reflectance_1063", "reflectance_1063", 1063.0, "reflectance"),),
        Pose((4.1e5, 5.2e6, 101.5), known_by="given"),
        Grid(30, 20, row, column, np.arange(400, 450)),
    )
    fields = {"incidence": rng.uniform(0, 90, n), "ghost": rng.random(n) < 0.5}
    fields["incidence"][3] = np.nan
    return Cloud(scan, fields, {"incidence": "degrees"}, {"version": "1"})


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_round_trip(tmp_path: Path, suffix: str) -> None:
    cloud, path = make_cloud(), tmp_path / f"out{suffix}"
    save(path, cloud, las.write)
    back = read(path)
    with laspy.open(path) as file:
        assert file.header.are_points_compressed == (suffix == ".laz")
        assert np.all(file.header.scales <= 1e-4)
        descriptions = {d.name: d.description for d in file.header.point_format.extra_dimensions}
    assert descriptions["incidence"] == "degrees"
    assert np.abs(back.xyz - cloud.scan.xyz).max() <= 0.5e-5 + 1e-9
    expected = {k: v for k, v in cloud.columns.items() if k not in ("row", "column")}
    assert set(back.attributes) == set(expected)
    for name, values in expected.items():
        assert back.attributes[name].dtype == values.dtype, name
        equal_nan = values.dtype.kind == "f"
        assert np.array_equal(back.attributes[name], values, equal_nan=equal_nan), name
    assert back.pose == cloud.scan.pose
    assert back.channels == cloud.scan.channels
    assert back.grid is not None
    assert cloud.scan.grid is not None
    assert np.array_equal(back.grid.row, cloud.scan.grid.row)
    assert np.array_equal(back.grid.no_return, cloud.scan.grid.no_return)


def test_without_its_sidecar_a_file_keeps_values_and_names(tmp_path: Path) -> None:
    cloud, path = make_cloud(), tmp_path / "out.laz"
    save(path, cloud, las.write, sidecar=False)
    back = read(path)
    assert back.pose is None
    assert back.attributes["ghost"].dtype == bool
    assert set(back.attributes) == set(cloud.columns)


def test_points_of_a_fine_lattice_come_back_bit_for_bit(tmp_path: Path) -> None:
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = np.full(3, 2.5e-5), np.array([431234.567, 5.2e6, 0.1])
    data = laspy.LasData(header)
    for key in ("X", "Y", "Z"):
        data[key] = np.random.default_rng(2).integers(-(2**31), 2**31, POINTS)
    data.write(tmp_path / "a.las")
    scan = read(tmp_path / "a.las")
    save(tmp_path / "b.laz", Cloud(scan), las.write)
    back = laspy.read(tmp_path / "b.laz")
    assert np.array_equal(read(tmp_path / "b.laz").xyz, scan.xyz)
    for key in ("X", "Y", "Z"):
        assert np.array_equal(back[key], data[key])


def test_a_wide_extent_takes_the_coarser_scale_or_refuses(tmp_path: Path) -> None:
    for width, scale in ((2e4, 1e-5), (1e5, 1e-4)):
        xyz = np.array([[0.0, 0, 0], [width, 0, 0]])
        save(tmp_path / "a.las", Cloud(Scan("s", xyz)), las.write, overwrite=True)
        with laspy.open(tmp_path / "a.las") as file:
            assert file.header.scales[0] == scale
    far = Scan("s", np.array([[0.0, 0, 0], [3e5, 0, 0]]))
    with pytest.raises(BadInput, match="214 km"):
        save(tmp_path / "b.las", Cloud(far), las.write)
    assert not (tmp_path / "b.las").exists()


def test_points_without_coordinates_are_refused_by_the_writer(tmp_path: Path) -> None:
    scan = Scan("s", np.array([[0.0, 0, np.nan]]))
    with pytest.raises(BadInput, match="not finite"):
        save(tmp_path / "a.las", Cloud(scan), las.write)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.data
def test_old_laz_without_chunks(shared_data: Path) -> None:
    old = shared_data / "edge_cases" / "laz__simple-laszip-compressor-version-1.2r0.laz"
    assert np.array_equal(read(old).xyz, read(shared_data / "las_oddities" / "simple.las").xyz)
