"""A scan as its file tells it: points, channels, scanner pose, grid. Never changed in place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, finite_rows
from app.core.errors import BadInput, MissingChannel, MissingScanner
from app.model.waveforms import Waveforms

ChannelKind = Literal["DN", "dB", "linear", "reflectance"]
PoseKnownBy = Literal["file", "given", "assumed"]
Vector = tuple[float, float, float]
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Channel:
    """One wavelength of one instrument, and what its numbers mean.

    Attributes
    ----------
    name : str
        Name of the field, e.g. ``reflectance_1063``.
    attribute : str
        Key of the values in `Scan.attributes`.
    wavelength_nm : float or None
    kind : {'DN', 'dB', 'linear', 'reflectance'}
    calibration : str
        Where the numbers come from; empty when raw.
    sigma : float or None
        Standard deviation of one value, in the channel's own unit.
    workflow : str
        How it was corrected for the angle of incidence; empty when it was not.
    """

    name: str
    attribute: str
    wavelength_nm: float | None = None
    kind: ChannelKind = "DN"
    calibration: str = ""
    sigma: float | None = None
    workflow: str = ""


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the beams start, in world metres, and how the scanner was turned.

    `rotation` holds the scanner's axes as columns (scanner to world).
    """

    position: Vector
    rotation: tuple[Vector, Vector, Vector] = IDENTITY
    known_by: PoseKnownBy = "file"


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Rows and columns of a range image. Several points may share a cell.

    Attributes
    ----------
    rows, columns : int
    row, column : (n,) int32 arrays
        Cell of each point, zero-based.
    no_return : (k,) int64 array
        Cells (row · columns + column) that the file records as beams without echo.
    """

    rows: int
    columns: int
    row: AnyArray
    column: AnyArray
    no_return: Ints = field(default_factory=lambda: np.empty(0, np.int64))


@dataclass(frozen=True, slots=True)
class Source:
    """The file that a scan came from, enough to find it again and to know it.

    `sidecar` is the hash of the sidecar beside it, which may hold pose and channels (and of
    the file of columns that it names); empty where there was none, None where nobody looked.
    """

    path: str
    size: int
    sha256: str
    scan_index: int = 0
    options: Mapping[str, str] = field(default_factory=dict)
    sidecar: str | None = None


@dataclass(frozen=True, eq=False)
class Scan:
    """Points with what was measured at them, in file order.

    Attributes
    ----------
    name : str
    xyz : (n, 3) float64 array
        World coordinates in metres. Rows that are not finite stay, so that rows keep
        their meaning, and are left out by `valid`.
    attributes : mapping of str to (n,) arrays
        Everything else that the file holds, in the file's own type.
    channels : tuple of Channel
    pose : Pose or None
        None means unknown: whatever needs it must refuse (see `scanner`).
    grid : Grid or None
    source : Source or None
    metadata : mapping of str to str
        Instrument, coordinate system and other facts of the file.
    warnings : tuple of str
    waveforms : Waveforms or None
        Digitised records that the points were found in, where the file has them.
    """

    name: str
    xyz: Floats
    attributes: Mapping[str, AnyArray] = field(default_factory=dict)
    channels: tuple[Channel, ...] = ()
    pose: Pose | None = None
    grid: Grid | None = None
    source: Source | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    waveforms: Waveforms | None = None

    def __post_init__(self) -> None:
        if self.xyz.ndim != 2 or self.xyz.shape[1] != 3:
            raise BadInput(f"{self.name}: coordinates must be n × 3, not {self.xyz.shape}.")
        for key, values in self.attributes.items():
            if len(values) != len(self.xyz):
                raise BadInput(
                    f"{self.name}: {key} has {len(values)} values for {len(self.xyz)} points."
                )
        if self.waveforms is not None and len(self.waveforms) != len(self.xyz):
            raise BadInput(f"{self.name}: its waveforms are those of other points.")

    def __len__(self) -> int:
        return len(self.xyz)

    @cached_property
    def valid(self) -> Bools:
        """Points with finite coordinates, (n,) booleans."""
        return finite_rows(self.xyz)

    def scanner(self, needed_for: str) -> Floats:
        """Position of the scanner, (3,) metres.

        Raises
        ------
        MissingScanner
            The position is unknown; the sentence names `needed_for`.
        """
        if self.pose is None:
            raise MissingScanner(needed_for)
        return np.array(self.pose.position)

    @property
    def wavelengths(self) -> dict[str, float | None]:
        """Wavelength of each channel, nm, by its name."""
        return {channel.name: channel.wavelength_nm for channel in self.channels}

    def channel(self, name: str) -> Channel:
        """The channel of that name; raises `MissingChannel` with the names there are."""
        for channel in self.channels:
            if channel.name == name:
                return channel
        known = ", ".join(c.name for c in self.channels) or "none"
        raise MissingChannel(f"{self.name} has no channel {name}; its channels: {known}.")

    def channel_values(self, name: str) -> Floats:
        """Values of a channel, (n,) float64, in the channel's own unit."""
        return self.attributes[self.channel(name).attribute].astype(np.float64)

    def with_pose(self, pose: Pose | None) -> Scan:
        """The same scan, seen from another position."""
        return self._with_same_points(pose=pose)

    def with_channels(self, channels: tuple[Channel, ...]) -> Scan:
        """The same scan, with its channels named anew."""
        return self._with_same_points(channels=channels)

    def with_xyz(self, xyz: Floats) -> Scan:
        """The same scan with moved points (ghost correction)."""
        return replace(self, xyz=xyz)

    def _with_same_points(self, **changes: Any) -> Scan:
        scan = replace(self, **changes)
        if "valid" in self.__dict__:  # looking for it again takes long on large scans
            scan.__dict__["valid"] = self.valid
        return scan
