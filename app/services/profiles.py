"""Profiles as TOML files: read with checks, found by name, written whole or not at all."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec

from app.core.errors import BadInput, LeafscopeError
from app.core.radiometry.profile import Profile
from app.formats.atomic import atomic_path
from app.simulate.ready_files import find_ready, read_start

LARGEST = 4_000_000
"""Bytes; a profile of a hundred free parameters has a tenth of it."""


def list_profiles() -> list[Profile]:
    """The published profiles that come with the program, by name of their files."""
    return list(name_profiles().values())


def name_profiles() -> dict[str, Profile]:
    """The published profiles by the names under which `find_profile` knows them."""
    return {name: find_profile(name) for name in sorted(find_ready("profiles"))}


def find_profile(name: str) -> Profile:
    """The profile of a TOML file, or a published one by name.

    Raises
    ------
    BadInput
        There is neither, or the file is no profile.
    """
    ready = find_ready("profiles")
    path = Path(name)
    if name in ready and not path.is_file():
        return decode_profile(read_start(ready[name], LARGEST, "profile"), f"{name}.toml")
    if not path.is_file():
        raise BadInput(
            f"There is no profile {name}.",
            f"Give a TOML file, or one of {', '.join(sorted(ready))}.",
        )
    return read_profile(path)


def read_profile(path: str | Path) -> Profile:
    """Read a profile from a TOML file; raises `BadInput` where it is none."""
    path = Path(path)
    return decode_profile(read_start(path, LARGEST, "profile"), path.name)


def decode_profile(content: bytes, file: str) -> Profile:
    """Make a profile of the content of its file.

    Raises
    ------
    BadInput
        The content is too large, not TOML, or a key is missing, unknown or out of bounds; the
        sentence names `file` and the key.
    """
    if len(content) > LARGEST:
        raise BadInput(f"{file} is too large for a profile.", "Choose another file.")
    try:
        return msgspec.toml.decode(content, type=Profile)
    except msgspec.ValidationError as error:
        cause = error.__cause__
        if isinstance(cause, LeafscopeError):
            raise BadInput(f"{file}: {cause.what}", cause.hint or "Correct it there.") from error
        raise _explain(str(error), file) from error
    except LeafscopeError as error:
        raise BadInput(f"{file}: {error.what}", error.hint or "Correct it there.") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadInput(f"{file} is not a TOML file: {error}.", "Correct it there.") from error


def encode_profile(profile: Profile) -> bytes:
    """A profile as TOML; every number comes back as it was."""
    import tomli_w

    return tomli_w.dumps(msgspec.to_builtins(profile)).encode()


def write_profile(profile: Profile, path: str | Path, overwrite: bool = False) -> None:
    """Write a profile as TOML, whole or not at all; raises `BadInput` where it cannot."""
    with atomic_path(Path(path), overwrite) as temporary:
        temporary.write_bytes(encode_profile(profile))


def _explain(message: str, file: str) -> BadInput:
    """The decoder's message as a sentence that names file and key."""
    complaint, _, path = message.partition(" - at `$")
    place = path.rstrip("`").lstrip(".")
    field = re.search("(unknown|required) field `(.*)`", complaint)
    if field:
        key = ".".join(filter(None, (place, field[2])))
        if field[1] == "unknown":
            return BadInput(f"{file} has the key {key}, which no profile has.", "Remove it.")
        return BadInput(f"{file} lacks the key {key}.", "Add it, or choose a profile.")
    wanted = complaint[:1].lower() + complaint[1:].replace("`", "")
    return BadInput(f"{file}, key {place or 'of the whole file'}: {wanted}.", "Correct it there.")
