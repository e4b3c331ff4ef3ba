"""The ten header lines of a scan in a PTX file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.formats.line_blocks import LineReader
from app.formats.number_lines import split_cells, to_number
from app.model.scan import Grid, Pose

FARTHEST = 10_000.0  # metres: no terrestrial scanner measures farther


@dataclass(frozen=True, slots=True, eq=False)
class ScanHeader:
    """Size of the grid and the way from file to world coordinates.

    Attributes
    ----------
    columns, rows : int
    axes : (3, 3) array
        Images of the scanner's x, y and z axis, one per row (row-vector convention).
    origin : (3,) array
        Position of the scanner in world metres, line four of the matrix.
    """

    columns: int
    rows: int
    axes: Floats
    origin: Floats

    @classmethod
    def of(cls, grid: Grid, pose: Pose | None) -> ScanHeader:
        """The header of a scan; the file's system is the world's where no pose is known.

        A pose whose axes are no right angles is taken as its position alone.
        """
        if pose is None:
            return cls(grid.columns, grid.rows, np.eye(3), np.zeros(3))
        axes = np.array(pose.rotation, dtype=np.float64).T
        if not _is_orthogonal(axes):
            axes = np.eye(3)
        return cls(grid.columns, grid.rows, axes, np.array(pose.position, dtype=np.float64))

    @property
    def cells(self) -> int:
        """Lines that follow the header."""
        return self.columns * self.rows

    def cut(self, cells: int) -> ScanHeader:
        """The header of a file that ends after so many cells: it claims no more of them."""
        if cells == self.cells:
            return self
        rows = min(self.rows, max(cells, 1))
        return replace(self, rows=rows, columns=max(1, -(-cells // rows)))

    def to_world(self, xyz: Floats) -> Floats:
        """World coordinates of (n, 3) file coordinates."""
        if np.array_equal(self.axes, np.eye(3)):
            return xyz + self.origin  # exact, and NaN in one coordinate stays in it
        with np.errstate(invalid="ignore", over="ignore"):  # infinite points stay so
            return xyz @ self.axes + self.origin

    def to_file(self, xyz: Floats) -> Floats:
        """File coordinates of (n, 3) world coordinates; needs axes at right angles."""
        if np.array_equal(self.axes, np.eye(3)):
            return xyz - self.origin
        return (xyz - self.origin) @ np.linalg.inv(self.axes)  # axes of text are not exact

    def format(self) -> str:
        """The ten lines, every number with all its digits."""
        matrix = np.column_stack((np.vstack((self.axes, self.origin)), (0, 0, 0, 1)))
        lines = [[self.columns], [self.rows], self.origin.tolist(), *self.axes.tolist()]
        lines += matrix.tolist()
        return "".join(" ".join(map(repr, line)) + "\n" for line in lines)

    def pose(self, xyz: Floats) -> tuple[Pose | None, tuple[str, ...]]:
        """Pose of the scanner and doubts about it; None where it is a mere default."""
        sample = xyz[:: max(1, len(xyz) // 1000)]
        sample = sample[np.isfinite(sample).all(axis=1)]
        distance = _middle_distance(sample, self.origin)
        doubts: tuple[str, ...] = ()
        if distance > FARTHEST:
            doubts = (f"The file puts the scanner {distance / 1000:.0f} km from the points.",)
            if not self.origin.any():  # what converters write that know no position
                return None, (*doubts, "Its position is taken as unknown.")
        lengths = np.linalg.norm(self.axes, axis=1)
        if not _is_orthogonal(self.axes):
            doubts += ("The file's matrix is no rotation: it scales or shears the points.",)
        axes = (self.axes / np.where(lengths > 0, lengths, 1.0)[:, None]).T.tolist()
        x, y, z = self.origin.tolist()
        return Pose((x, y, z), (tuple(axes[0]), tuple(axes[1]), tuple(axes[2]))), doubts


def _is_orthogonal(axes: Floats) -> bool:
    return np.allclose(axes @ axes.T, np.eye(3), atol=1e-3)


def _middle_distance(xyz: Floats, origin: Floats) -> float:
    if not len(xyz):
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.median(np.linalg.norm(xyz - origin, axis=1)))


def read_scan_header(path: Path, reader: LineReader) -> ScanHeader | None:
    """The next header; None where only blank lines are left.

    Raises
    ------
    BadInput
        A line is missing or holds something else.
    """
    first = reader.line()
    while first is not None and not first.strip():
        first = reader.line()
    if first is None:
        return None
    columns = _count(path, reader, first, "columns")
    rows = _count(path, reader, reader.line(), "rows")
    for _ in range(4):  # position and axes: the matrix says the same, and is what all use
        _numbers(path, reader, 3)
    matrix = np.array([_numbers(path, reader, 4) for _ in range(4)])
    if not np.isfinite(matrix[:, :3]).all():
        raise BadInput(f"{path.name}: the matrix before line {reader.lines_read} is not finite.")
    return ScanHeader(columns, rows, matrix[:3, :3], matrix[3, :3])


def _count(path: Path, reader: LineReader, line: str | None, what: str) -> int:
    text = (line or "").strip()
    if not text.isascii() or not text.isdigit() or len(text) > 18 or int(text) == 0:
        raise BadInput(
            f"{path.name}, line {reader.lines_read}: {text[:40]!r} is no number of {what}.",
            "This is no PTX file, or it is damaged here.",
        )
    return int(text)


def _numbers(path: Path, reader: LineReader, count: int) -> list[float]:
    line = reader.line() or ""
    try:
        numbers = [to_number(cell) for cell in split_cells(line, None)]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise BadInput(
            f"{path.name}, line {reader.lines_read}: {line.strip()[:40]!r} should hold"
            f" {count} numbers.",
            "The header of this PTX scan is damaged.",
        )
    return numbers
