"""The programs of others, as anyone would call them; each gives normals only."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from os import environ
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput
from app.services.bench.incidence.rivals import Estimate, Load, Rival

OPEN3D, CLOUDCOMPARE, SCIPY = "Open3D", "CloudCompare", "SciPy"
RADIUS_SEARCH = "radius search"
SAMPLE = 20_000
"""Points of which the simple way is asked; its time is scaled up to all of them."""
BATCH = 2_000
TIMING = re.compile(r"\[ComputeCloudNormals\] Timing: ([0-9.]+) s")
NO_DISPLAY = {"QT_QPA_PLATFORM": "offscreen"}
LONGEST = 600.0

Search = Literal["radius", "knn", "hybrid"]


@dataclass(frozen=True, slots=True)
class Peer:
    """A program of others, and where it was found; empty where it is missing."""

    program: str
    found: str


def find_peers() -> tuple[Peer, ...]:
    """All peers that this bench knows, found or not."""
    return (
        Peer(OPEN3D, "installed" if find_spec("open3d") else ""),
        Peer(CLOUDCOMPARE, find_cloudcompare()),
        Peer(SCIPY, "installed"),
    )


def find_cloudcompare() -> str:
    """Path of the program, empty where there is none."""
    return shutil.which("CloudCompare") or shutil.which("cloudcompare") or ""


def open3d_rival(load: Load, radius: float, search: Search = "radius", most: int = 0) -> Rival:
    """Open3D's normals by a ball, by `most` neighbours, or by both (hybrid)."""
    method = {
        "radius": RADIUS_SEARCH,
        "knn": f"neighbours: {most}",
        "hybrid": f"radius and neighbours: {most}",
    }[search]
    estimate = partial(_estimate_open3d, radius=radius, search=search, most=most)
    return Rival(method, OPEN3D, radius, estimate, load)


def _estimate_open3d(load: Load, radius: float, search: Search, most: int) -> Estimate:
    open3d = import_module("open3d")
    kinds: dict[Search, Any] = {
        "radius": lambda: open3d.geometry.KDTreeSearchParamRadius(radius),
        "knn": lambda: open3d.geometry.KDTreeSearchParamKNN(most),
        "hybrid": lambda: open3d.geometry.KDTreeSearchParamHybrid(radius, most),
    }
    begun = perf_counter()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(load.xyz - load.truth.scanner))
    preparing = perf_counter() - begun
    cloud.estimate_normals(kinds[search]())
    normals = np.asarray(cloud.normals)
    width = float("nan") if search == "knn" else radius
    return Estimate(normals, width, preparing)


def scipy_rival(load: Load, radius: float) -> Rival:
    """k-d tree and eigenvectors in batches, as one would write it in an afternoon.

    Asked for `SAMPLE` of the judged points, around which all points are neighbours; the time of
    the search and the fits is scaled up to all points, that of the tree is taken as it is.
    """
    total = len(load.xyz)
    random = np.random.default_rng(0)
    judged = np.flatnonzero(load.truth.judged)
    asked = np.sort(random.choice(judged, min(SAMPLE, len(judged)), replace=False))
    sample = np.zeros(total, bool)
    sample[asked] = True
    estimate = partial(_estimate_by_tree, radius=radius, asked=asked)
    method = f"k-d tree, eigh ({len(asked)} points, time scaled up)"
    return Rival(method, SCIPY, radius, estimate, load, sample)


def _estimate_by_tree(load: Load, radius: float, asked: Ints) -> Estimate:
    from scipy.spatial import cKDTree

    xyz = load.xyz
    begun = perf_counter()
    tree = cKDTree(xyz)
    planting = perf_counter() - begun
    begun = perf_counter()
    normals = np.full(xyz.shape, np.nan)
    for first in range(0, len(asked), BATCH):
        batch = asked[first : first + BATCH]
        near = tree.query_ball_point(xyz[batch], radius, workers=-1)
        normals[batch] = fit_lists(xyz, batch, near)
    spent = perf_counter() - begun
    return Estimate(normals, radius, 0.0, planting + spent * len(xyz) / len(asked))


def fit_lists(xyz: Floats, centres: Ints, near: Any) -> Floats:
    """Normals of the least eigenvalue of lists of neighbours, (k, 3); NaN below three."""
    sizes = np.array([len(members) for members in near])
    member = np.concatenate([np.asarray(members, np.int64) for members in near])
    owner = np.repeat(np.arange(len(centres)), sizes)
    offsets = xyz[member] - xyz[centres][owner]
    mean = _sum_by(owner, offsets, len(centres)) / sizes[:, None]
    offsets -= mean[owner]
    products = (offsets[:, :, None] * offsets[:, None, :]).reshape(-1, 9)
    moments = _sum_by(owner, products, len(centres)).reshape(-1, 3, 3)
    normals = np.linalg.eigh(moments)[1][:, :, 0]
    normals[sizes < 3] = np.nan
    return np.asarray(normals)


def _sum_by(owner: Ints, values: Floats, total: int) -> Floats:
    return np.stack([np.bincount(owner, column, total) for column in values.T], axis=1)


def cloudcompare_rival(load: Load, radius: float, program: str) -> Rival:
    """CloudCompare's octree normals with local planes, by the time that it tells itself.

    It reads and writes files of float32 coordinates; that is not counted.
    """
    estimate = partial(_estimate_cloudcompare, radius=radius, program=program)
    return Rival("octree normals, LS", CLOUDCOMPARE, radius, estimate, load)


def _estimate_cloudcompare(load: Load, radius: float, program: str) -> Estimate:
    begun = perf_counter()
    with tempfile.TemporaryDirectory(prefix="leafscope-") as folder:
        source, target, log = (Path(folder) / name for name in ("in.ply", "out.ply", "log.txt"))
        _write_ply(source, load.xyz - load.truth.scanner)
        command = [
            *(program, "-SILENT", "-LOG_FILE", str(log), "-AUTO_SAVE", "OFF", "-O", str(source)),
            *("-OCTREE_NORMALS", f"{radius:g}", "-MODEL", "LS", "-C_EXPORT_FMT", "PLY"),
            *("-PLY_EXPORT_FMT", "BINARY_LE", "-SAVE_CLOUDS", "FILE", str(target)),
        ]
        done = subprocess.run(
            command, env={**environ, **NO_DISPLAY}, cwd=folder, capture_output=True,
            timeout=LONGEST, check=False,
        )  # fmt: skip
        told = TIMING.search(log.read_text(errors="replace")) if log.is_file() else None
        if told is None or not target.is_file():
            raise BadInput(f"CloudCompare gave no normals (exit code {done.returncode}).")
        normals = _read_ply_normals(target, len(load.xyz))
    seconds = float(told.group(1))
    return Estimate(normals, radius, perf_counter() - begun - seconds, seconds)


def _write_ply(path: Path, xyz: Floats) -> None:
    names = "".join(f"property float {name}\n" for name in "xyz")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(xyz)}\n{names}end_header\n"
    path.write_bytes(head.encode() + xyz.astype("<f4").tobytes())


def _read_ply_normals(path: Path, count: int) -> Floats:
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    names = re.findall(rb"property float (\w+)", data[:end])
    if names[:6] != [b"x", b"y", b"z", b"nx", b"ny", b"nz"]:
        raise BadInput("CloudCompare's file holds other columns than points and normals.")
    values = np.frombuffer(data, "<f4", count * len(names), end).reshape(count, len(names))
    normals = values[:, 3:6].astype(np.float64)
    normals[~normals.any(axis=1)] = np.nan
    return normals
