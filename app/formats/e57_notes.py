"""What our E57 writer notes beside the standard: names, types, channels, provenance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import msgspec

from app.core.errors import BadInput
from app.formats.cloud import Cloud
from app.formats.sidecar import Sidecar, apply_sidecar, describe_cloud, encode_json
from app.model.scan import PoseKnownBy, Scan

LONGEST = 1 << 20  # the longest text that our reader takes from the XML section


@dataclass(frozen=True, slots=True)
class Notes:
    """Content of the element ``leafscope:notes`` of a scan; `names` go by element."""

    cloud: Sidecar
    names: Mapping[str, str] = field(default_factory=dict)
    known_by: PoseKnownBy | None = None


def write_notes(cloud: Cloud, names: Mapping[str, str]) -> str:
    """The notes as JSON; pose and grid have their own places in E57.

    Raises
    ------
    BadInput
        The provenance is longer than an E57 reader takes.
    """
    content = replace(describe_cloud(cloud), pose=None, grid=None)
    known_by = None if cloud.scan.pose is None else cloud.scan.pose.known_by
    text = encode_json(Notes(content, names, known_by)).decode()
    if len(text) > LONGEST:
        raise BadInput("The provenance is too long for E57 (1 MB).", "Export as NPZ or LAZ.")
    return text


def apply_notes(scan: Scan, text: str) -> Scan:
    """The scan with what our own writer noted; foreign files have no notes."""
    if not text:
        return scan
    try:
        notes = msgspec.json.decode(text, type=Notes)
    except (msgspec.MsgspecError, RecursionError):
        return replace(scan, warnings=(*scan.warnings, "Damaged notes of Leafscope: ignored."))
    attributes = {notes.names.get(name, name): values for name, values in scan.attributes.items()}
    pose = scan.pose
    if pose is not None and notes.known_by is not None:
        pose = replace(pose, known_by=notes.known_by)
    return apply_sidecar(replace(scan, attributes=attributes, pose=pose), notes.cloud)
