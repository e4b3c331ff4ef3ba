"""E57 against pye57's own reader, against hostile XML, and through our writer and back."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pye57
import pytest
from pye57 import libe57

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import e57
from app.formats.cloud import Cloud
from app.formats.e57_columns import find_quaternion
from app.formats.e57_preflight import quaternion_matrix
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.saving import save
from app.model.scan import Channel, Grid, Pose, Scan
from app.services.reading import read_file

PAGE, PAYLOAD = 1024, 1020
HEADER_FIELDS = {
    "major": (8, "I"), "minor": (12, "I"), "length": (16, "Q"), "xml start": (24, "Q"),
    "xml length": (32, "Q"), "page": (40, "Q"),
}  # fmt: skip
TURN = quaternion_matrix(list(np.array([0.3, -0.5, 0.7, 0.4]) / np.sqrt(0.99)))


def make_table() -> list[int]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
        table.append(value)
    return table


CRC_TABLE = make_table()


def checksum(page: bytes) -> bytes:
    """CRC-32C as E57 stores it."""
    crc = 0xFFFFFFFF
    for byte in page:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 255]
    return struct.pack(">I", crc ^ 0xFFFFFFFF)


def edit_xml(path: Path, edit: Callable[[str], str]) -> Path:
    """Change the XML section and rebuild pages, header and checksums."""
    raw = path.read_bytes()
    logical = b"".join(raw[i : i + PAYLOAD] for i in range(0, len(raw), PAGE))
    start, length = struct.unpack_from("<QQ", raw, 24)
    start = start // PAGE * PAYLOAD + start % PAGE
    xml = edit(logical[start : start + length].decode()).encode()
    logical = logical[:start] + xml
    logical += bytes(-len(logical) % PAYLOAD)
    size = len(logical) // PAYLOAD * PAGE
    logical = logical[:16] + struct.pack("<Q", size) + logical[24:32]
    logical += struct.pack("<Q", len(xml))
    rest = b"".join(raw[i : i + PAYLOAD] for i in range(0, len(raw), PAGE))[40:start]
    logical += rest + xml + bytes(-(start + len(xml)) % PAYLOAD)
    pages = [logical[i : i + PAYLOAD] for i in range(0, len(logical), PAYLOAD)]
    path.write_bytes(b"".join(page + checksum(page) for page in pages))
    return path


def make_cloud(pose: Pose | None, n: int = 60) -> Cloud:
    rng = np.random.default_rng(5)
    row, column = np.divmod(np.arange(n, dtype=np.int32), 10)
    xyz = rng.normal(size=(n, 3)) * 5 + 20
    xyz[4] = np.nan
    attributes = {
        "intensity": rng.integers(0, 65536, n).astype(np.uint16),
        "red": rng.integers(0, 256, n).astype(np.uint8),
        "green": rng.integers(0, 256, n).astype(np.uint8),
        "blue": rng.integers(0, 256, n).astype(np.uint8),
        "nor:normalX": rng.normal(size=n).astype(np.float32),
        "Winkel ω": rng.normal(size=n),
    }
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "i8"):
        limits = np.iinfo(kind)
        values = rng.integers(limits.min, limits.max, n, dtype=kind, endpoint=True)
        values[:2] = limits.min, limits.max
        attributes[kind] = values
    scan = Scan(
        "Scan ω",
        xyz,
        attributes,
        (Channel("intensity", "intensity", 1545.0, "DN"),),
        pose,
        Grid(9, 10, row + 1, column, np.array([0, 5, 85, 89])),
    )
    fields = {"incidence": rng.uniform(0, 90, n), "ghost": rng.random(n) < 0.5}
    return Cloud(scan, fields, {"incidence": "degrees"}, {"versions": {"app": "1"}, "text": "]]>"})


def write(path: Path, cloud: Cloud) -> Path:
    save(path, cloud, e57.write, sidecar=False)
    return path


def read(path: Path, **options: int) -> Scan:
    (scan,) = e57.read(path, ReadOptions(**options), QUIET)
    return scan


POSES = [
    None,
    Pose((0.0, 0.0, 0.0)),
    Pose((4.5e5, 5.1e6, 300.0), tuple(map(tuple, TURN.tolist())), "given"),
]


@pytest.mark.parametrize("pose", POSES)
def test_round_trip(tmp_path: Path, pose: Pose | None) -> None:
    cloud = make_cloud(pose)
    back = read(write(tmp_path / "ä 点.e57", cloud))
    tolerance = 0.0 if pose is None or pose.rotation[0][0] == 1 else 5e-9
    assert np.allclose(back.xyz, cloud.scan.xyz, rtol=0, atol=tolerance, equal_nan=True)
    expected = {k: v for k, v in cloud.columns.items() if k not in ("row", "column")}
    assert set(back.attributes) == set(expected)
    for name, values in expected.items():
        assert back.attributes[name].dtype == values.dtype, name
        assert np.array_equal(back.attributes[name], values), name
    grid, truth = back.grid, cloud.scan.grid
    assert grid is not None
    assert truth is not None
    assert (grid.rows, grid.columns) == (9, 10)
    for part in ("row", "column", "no_return"):
        assert np.array_equal(getattr(grid, part), getattr(truth, part))
    assert back.channels == cloud.scan.channels
    assert back.name == "Scan ω"
    if pose is None:
        assert back.pose is None
    else:
        assert back.pose is not None
        assert back.pose.known_by == pose.known_by
        assert back.pose.position == pose.position
        assert np.allclose(back.pose.rotation, pose.rotation, atol=1e-12)


def test_pye57_reads_the_same_world(tmp_path: Path) -> None:
    cloud = make_cloud(POSES[2])
    path = write(tmp_path / "a.e57", cloud)
    file = pye57.E57(str(path))
    other = file.read_scan(
        0, intensity=True, colors=True, row_column=True, ignore_missing_fields=True
    )
    assert np.allclose(file.scan_position(0), POSES[2].position)
    file.close()
    xyz = np.column_stack([other[f"cartesian{axis}"] for axis in "XYZ"])
    assert np.allclose(xyz, cloud.scan.xyz, atol=1e-8, equal_nan=True)
    assert np.array_equal(other["intensity"], cloud.scan.attributes["intensity"])
    assert np.array_equal(other["colorRed"], cloud.scan.attributes["red"])
    assert np.array_equal(other["rowIndex"], cloud.scan.grid.row)


def test_an_empty_cloud_can_be_written(tmp_path: Path) -> None:
    scan = Scan("none", np.empty((0, 3)), {"intensity": np.empty(0, np.uint16)})
    assert len(read(write(tmp_path / "a.e57", Cloud(scan)))) == 0


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.5, np.pi / 2, np.pi, 3.5])
def test_quaternions_of_any_angle(angle: float) -> None:
    c, s = np.cos(angle), np.sin(angle)
    for matrix in ([[c, -s, 0], [s, c, 0], [0, 0, 1]], [[1, 0, 0], [0, c, -s], [0, s, c]]):
        pose = Pose((0, 0, 0), tuple(map(tuple, matrix)))
        assert np.allclose(quaternion_matrix(find_quaternion(pose)), matrix, atol=1e-12)


def test_a_mirror_is_no_rotation() -> None:
    mirror = Pose((0, 0, 0), ((-1, 0, 0), (0, 1, 0), (0, 0, 1)))
    assert find_quaternion(mirror) == [1.0, 0.0, 0.0, 0.0]


def write_raw(path: Path, columns: dict[str, np.ndarray], scans: int = 1) -> Path:
    """A file by libE57 itself: doubles, and 8-bit integers for the rest."""
    image = libe57.ImageFile(str(path), "w")
    image.extensionsAdd("", libe57.E57_V1_0_URI)
    root = image.root()
    root.set("formatName", libe57.StringNode(image, "ASTM E57 3D Imaging Data File"))
    root.set("guid", libe57.StringNode(image, "{1}"))
    root.set("versionMajor", libe57.IntegerNode(image, 1))
    root.set("versionMinor", libe57.IntegerNode(image, 0))
    data = libe57.VectorNode(image, True)
    root.set("data3D", data)
    for _ in range(scans):
        prototype = libe57.StructureNode(image)
        for name, values in columns.items():
            whole = values.dtype == np.uint8
            node = libe57.IntegerNode(image, 0, 0, 255) if whole else libe57.FloatNode(image, 0.0)
            prototype.set(name, node)
        points = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
        scan = libe57.StructureNode(image)
        scan.set("points", points)
        data.append(scan)
        buffers = libe57.VectorSourceDestBuffer()
        for name, values in columns.items():
            buffers.append(libe57.SourceDestBuffer(image, name, values, len(values), True, True))
        writer = points.writer(buffers)
        writer.write(len(next(iter(columns.values()))))
        writer.close()
    image.close()
    return path


def test_spherical_coordinates_and_zero_ranges(tmp_path: Path) -> None:
    columns = {
        "sphericalRange": np.array([2.0, 0.0, 1.0, 3.0]),
        "sphericalAzimuth": np.array([0.0, 1.0, np.pi / 2, np.pi]),
        "sphericalElevation": np.array([0.0, 1.0, 0.0, np.pi / 6]),
        "sphericalInvalidState": np.array([0, 0, 0, 0], np.uint8),
        "intensity": np.array([1, 2, 3, 4], np.uint8),
    }
    scan = read(write_raw(tmp_path / "a.e57", columns))
    expected = [[2, 0, 0], [0, 1, 0], [-3 * np.sqrt(0.75), 0, 1.5]]
    assert np.allclose(scan.xyz, expected, atol=1e-12)
    assert scan.attributes["intensity"].tolist() == [1, 3, 4]
    assert any("1 records without a point" in warning for warning in scan.warnings)


def test_grid_takes_the_cells_without_echo(tmp_path: Path) -> None:
    columns = {
        "cartesianX": np.array([1.0, 0.0, 2.0, 5.0]),
        "cartesianY": np.array([1.0, 0.0, 2.0, 5.0]),
        "cartesianZ": np.array([1.0, 0.0, 2.0, 5.0]),
        "rowIndex": np.array([3, 3, 4, 4], np.uint8),
        "columnIndex": np.array([7, 8, 7, 9], np.uint8),
        "cartesianInvalidState": np.array([0, 0, 0, 2], np.uint8),
    }
    scan = read(write_raw(tmp_path / "a.e57", columns))
    assert scan.grid is not None
    assert (scan.grid.rows, scan.grid.columns) == (2, 3)
    assert scan.grid.row.tolist() == [0, 1]
    assert scan.grid.column.tolist() == [0, 0]
    assert scan.grid.no_return.tolist() == [1, 5]
    assert scan.pose is None


def test_a_point_at_the_origin_of_a_scan_without_grid_stays(tmp_path: Path) -> None:
    columns = {f"cartesian{axis}": np.array([0.0, 1.0]) for axis in "XYZ"}
    assert len(read(write_raw(tmp_path / "a.e57", columns))) == 2


def test_several_scans_and_every_nth(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(e57, "_CHUNK", 4)
    columns = {f"cartesian{axis}": np.arange(11.0) + 1 for axis in "XYZ"}
    path = write_raw(tmp_path / "a.e57", columns, scans=3)
    scans = e57.read(path, ReadOptions(every_nth=3), QUIET)
    assert [scan.xyz[:, 0].tolist() for scan in scans] == [[1.0, 4.0, 7.0, 10.0]] * 3
    header = e57.preflight(path)
    assert (header.points, header.scans) == (33, 3)


BOMB = '<!DOCTYPE e [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]>'
XXE = '<!DOCTYPE e [<!ENTITY x SYSTEM "file:///etc/hostname">]>'


def insert_doctype(doctype: str) -> Callable[[str], str]:
    return lambda xml: xml.replace("<e57Root", doctype + "<e57Root", 1)


HOSTILE: dict[str, tuple[Callable[[str], str], str]] = {
    "entities": (insert_doctype(BOMB), "document type"),
    "outer entity": (insert_doctype(XXE), "document type"),
    "depth": (lambda x: x.replace("<guid", "<a>" * 65 + "</a>" * 65 + "<guid", 1), "deeper than"),
    "count": (lambda x: re.sub('recordCount="[0-9]+"', 'recordCount="900000000000"', x), "claims"),
    "negative": (lambda x: re.sub('recordCount="[0-9]+"', 'recordCount="-1"', x), "claims"),
    "no number": (lambda x: re.sub('recordCount="[0-9]+"', 'recordCount="ten"', x), "no whole"),
    "offset": (lambda x: re.sub('fileOffset="[0-9]+"', 'fileOffset="99999999"', x), "claims"),
    "no prototype": (lambda x: re.sub("<prototype.*</prototype>", "", x, flags=re.S), "prototype"),
    "no points": (lambda x: re.sub("<points.*</points>", "", x, flags=re.S), "no points"),
    "no x": (lambda x: x.replace("cartesianX", "somethingX"), "neither"),
    "broken": (lambda x: x.replace("</data3D>", ""), "malformed"),
    "encoding": (lambda x: x.replace("UTF-8", "UTF-16"), "malformed|not in UTF-8"),
    "limits": (lambda x: x.replace('maximum="255"', 'maximum="-1"'), "limits"),
    "pose": (lambda x: re.sub("<w type[^/]*/w>", '<w type="Float">nan</w>', x), "pose"),
}  # fmt: skip


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_xml_is_refused_before_the_library(tmp_path: Path, case: str) -> None:
    edit, sentence = HOSTILE[case]
    path = edit_xml(write(tmp_path / "a.e57", make_cloud(POSES[2])), edit)
    with pytest.raises(BadInput, match=sentence):
        e57.preflight(path)


def test_the_editor_of_these_tests_keeps_files_whole(tmp_path: Path) -> None:
    path = edit_xml(write(tmp_path / "a.e57", make_cloud(None)), lambda xml: xml + "\n\n")
    assert len(read(path)) == 60


@pytest.mark.parametrize("field", HEADER_FIELDS)
def test_any_header_value_gives_a_scan_or_a_sentence(tmp_path: Path, field: str) -> None:
    place, kind = HEADER_FIELDS[field]
    whole = write(tmp_path / "a.e57", make_cloud(None)).read_bytes()
    now = struct.unpack_from(f"<{kind}", whole, place)[0]
    most = 2 ** (8 * struct.calcsize(kind)) - 1
    for value in (0, 1, 2, most, most // 2, now - 1, now + 1, now + 4):
        raw = bytearray(whole)
        struct.pack_into(f"<{kind}", raw, place, value % (most + 1))
        path = tmp_path / "b.e57"
        path.write_bytes(raw)
        with suppress(BadInput):
            e57.preflight(path)


VALUES = ("0", "1", "-1", "9223372036854775807", "nan")


@pytest.mark.parametrize(
    "attribute", ["recordCount", "fileOffset", "minimum", "maximum", "type", "precision"]
)
def test_any_xml_value_gives_a_scan_or_a_sentence(tmp_path: Path, attribute: str) -> None:
    """Values that pass the check reach libE57, in the process that may crash."""
    cloud = make_cloud(POSES[1])
    for value in VALUES:
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.e57"
        edit_xml(
            write(path, cloud),
            lambda x, v=value: re.sub(f'{attribute}="[^"]*"', f'{attribute}="{v}"', x),
        )
        with suppress(BadInput):
            assert len(read_file(path)) == 1


def test_cut_files_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.e57", make_cloud(None))
    raw = path.read_bytes()
    for length in (8, 47, 48, 1023, 1024, len(raw) - 1024, len(raw) - 1):
        path.write_bytes(raw[:length])
        with pytest.raises(BadInput, match=r"cut off|cannot begin"):
            e57.preflight(path)


def test_a_wrong_checksum_is_a_sentence(tmp_path: Path) -> None:
    path = write(tmp_path / "a.e57", make_cloud(None))
    raw = bytearray(path.read_bytes())
    raw[200] ^= 1
    path.write_bytes(raw)
    with pytest.raises(BadInput, match="checksum"):
        e57.read(path, DEFAULTS, QUIET)


@pytest.mark.data
def test_the_pump_has_a_grid_and_no_pose(shared_data: Path) -> None:
    scan = read(shared_data / "pump_e57_gridded" / "pumpAVisualReferenceImage.e57")
    assert len(scan) == 155_201
    assert scan.pose is None
    assert scan.grid is not None
    assert (scan.grid.rows, scan.grid.columns) == (1074, 345)
    raw = pye57.E57(str(shared_data / "pump_e57_gridded" / "pumpAVisualReferenceImage.e57"))
    other = raw.read_scan_raw(0)
    raw.close()
    assert np.allclose(scan.attributes["intensity"], other["intensity"], rtol=1e-6)
    assert np.array_equal(scan.xyz[:, 1], other["cartesianY"])
    assert np.array_equal(scan.grid.column, other["columnIndex"])


@pytest.mark.data
def test_translation_without_rotation(shared_data: Path) -> None:
    scan = read(shared_data / "e57_pose" / "translationWithoutRotation.e57")
    assert scan.pose == Pose((4.0, 5.0, 6.0))
    assert np.allclose(scan.xyz.min(axis=0), (4, 5, 6))
