"""What Leafscope writes into the comments of a PLY file, and reads from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from app.formats.sidecar import encode_json
from app.model.scan import Pose

_POSE = "leafscope pose "
_NAME = "leafscope name "
_LONGEST = 400  # other programs read lines into buffers of 1024 bytes


def describe_pose(pose: Pose) -> str:
    """The comment that holds a pose."""
    return _POSE + msgspec.json.encode(pose).decode()


def pose_of_comments(comments: Iterable[str]) -> Pose | None:
    """The pose that `describe_pose` wrote; None where there is none, or a damaged one."""
    for comment in comments:
        if comment.startswith(_POSE):
            try:
                return msgspec.json.decode(comment.removeprefix(_POSE), type=Pose)
            except msgspec.MsgspecError:
                return None
    return None


def describe_names(names: Mapping[str, str]) -> list[str]:
    """Comments for the names that a PLY file cannot hold."""
    return [
        f"{_NAME}{in_file} {msgspec.json.encode(name).decode()}"
        for name, in_file in names.items()
        if name != in_file and len(name) < _LONGEST
    ]


def original_names(comments: Iterable[str]) -> dict[str, str]:
    """Names in the program by names in the file."""
    names: dict[str, str] = {}
    for comment in comments:
        in_file, _, name = comment.removeprefix(_NAME).partition(" ")
        if comment.startswith(_NAME):
            try:
                names[in_file] = msgspec.json.decode(name, type=str)
            except msgspec.MsgspecError:
                continue
    return names


def describe_provenance(provenance: Mapping[str, object]) -> list[str]:
    """One comment for each entry that is short enough; the sidecar holds all of it."""
    lines = [
        f"leafscope {key}: {msgspec.json.encode(msgspec.json.decode(encode_json(value))).decode()}"
        for key, value in provenance.items()
    ]
    return [line for line in lines if len(line) <= _LONGEST and line.isprintable()]
