"""What file names say of a series: by a pattern, or the number that changes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from app.core.errors import WrongUse
from app.services.series.entries import (
    TITLES,
    VALUES,
    Entry,
    Understood,
    count_hours,
    parse_number,
    set_time,
    set_value,
)

NUMBER = r"[-+−]?\d+(?:[.,]\d+)?"
MOMENT = r"\d{4}-?\d{2}-?\d{2}[T_ -]?\d{2}[-:h]?\d{2}(?:[-:m]?\d{2})?"
TEXT = r"[^/\\]+?"
PLACES = {
    "angle": NUMBER,
    "hours": NUMBER,
    "time": f"(?:{MOMENT}|{NUMBER})",
    "treatment": TEXT,
    "label": TEXT,
}
"""What may stand in braces in a pattern, and what it fits."""
# A minus counts as one only where no word or number ends before it: scan-05 is scan 5.
CHANGING = re.compile(rf"{MOMENT}|(?<![A-Za-z0-9])[-+−]?\d+(?:\.\d+)?|\d+(?:\.\d+)?")
WORDS = {
    "angle": re.compile(r"(?:^|[^a-z])(?:angle|angle_deg|deg|degrees?|tilt|rot|holder)$"),
    "hours": re.compile(r"(?:^|[^a-z])(?:hours?|hrs?|h|t|time)$"),
}
"""Words before a number that say its unit."""
UNITS = {
    "angle": re.compile(r"^(?:deg|degrees?|°)(?![a-z])"),
    "hours": re.compile(r"^(?:hours?|hrs?|h)(?![a-z])"),
}
"""Words behind it."""
GAPS = "_-= ."


def match_names(files: Sequence[Path], pattern: str) -> Understood:
    """Entries by a pattern such as ``leaf_{angle}.laz``; ``*`` stands for anything.

    Raises
    ------
    WrongUse
        The pattern has nothing in braces, something unknown, or does not fit a name.
    """
    wanted = re.findall(r"\{(\w*)\}", pattern)
    unknown = [name for name in wanted if name not in PLACES]
    if not wanted or unknown or len(set(wanted)) != len(wanted):
        raise WrongUse(
            f"{pattern!r} is no pattern of names.",
            f"Write one of {', '.join('{' + name + '}' for name in PLACES)}, each once.",
        )
    pieces = re.split(r"(\{\w+\}|\*)", pattern)
    regex = re.compile("".join(map(_translate, pieces)), re.IGNORECASE)
    entries = []
    for file in files:
        found = regex.fullmatch(file.name) or regex.fullmatch(file.stem)
        if found is None:
            raise WrongUse(f"{file.name} does not look like {pattern}.")
        entries.append(_entry(file, found.groupdict()))
    return Understood(count_hours(entries), f"{', '.join(wanted)} from names like {pattern}")


def _translate(piece: str) -> str:
    if piece == "*":
        return ".*?"
    name = piece[1:-1]
    return f"(?P<{name}>{PLACES[name]})" if piece.startswith("{") else re.escape(piece)


def _entry(file: Path, found: dict[str, str]) -> Entry:
    entry = Entry(file, treatment=found.get("treatment", ""), label=found.get("label", ""))
    for role in VALUES:
        if role in found:
            entry = set_value(entry, role, parse_number(found[role]))
    if "time" in found:
        entry = set_time(entry, _tidy_moment(found["time"]), file.name)
    return entry


def _tidy_moment(text: str) -> str:
    """A moment as ISO 8601 from the ways in which names write it; other text as it is."""
    digits = re.sub(r"\D", "", text)
    if not re.fullmatch(MOMENT, text) or len(digits) not in (12, 14):
        return text
    return f"{digits[:8]}T{digits[8:]}"


def read_names(files: Sequence[Path]) -> Understood:
    """Entries by what changes from name to name: numbers with their unit, or one number.

    Raises
    ------
    WrongUse
        Nothing changes, the names are not alike, or it is not clear which number is meant.
    """
    roles, doubt, text, numbers = _compare(files)
    entries = [
        _entry(file, {role: row[k] for role, k in roles.items()})
        for file, row in zip(files, numbers, strict=True)
    ]
    titles = [TITLES.get(role, role) for role in roles]
    how = f"{', '.join(titles)} from names like {_shape(roles, text)}{doubt}"
    return Understood(count_hours(entries), how)


def guess_pattern(files: Sequence[Path]) -> str:
    """The pattern by which `read_names` understands names, for `match_names`; raises as it does."""
    roles, _, text, _ = _compare(files)
    return _shape(roles, text)


def _compare(
    files: Sequence[Path],
) -> tuple[dict[str, int], str, list[str], list[list[str]]]:
    """Which of the numbers in the names is what, a doubt, the text between, all numbers."""
    stems = [file.stem for file in files]
    texts = [CHANGING.split(stem) for stem in stems]
    numbers = [CHANGING.findall(stem) for stem in stems]
    if len({tuple(text) for text in texts}) > 1:
        first = stems[0]
        other = next(s for s, text in zip(stems, texts, strict=True) if text != texts[0])
        raise WrongUse(
            f"The names {first} and {other} are not alike: they differ in more than numbers.",
            "Say how to read them, such as leaf_{angle}.laz, or give a CSV.",
        )
    changing = [k for k in range(len(numbers[0])) if len({row[k] for row in numbers}) > 1]
    roles, doubt = _assign(changing, texts[0], numbers[0])
    return roles, doubt, texts[0], numbers


def _assign(
    changing: Sequence[int], text: Sequence[str], numbers: Sequence[str]
) -> tuple[dict[str, int], str]:
    """Which of the numbers that change is what, and what is doubtful about it."""
    roles: dict[str, int] = {}
    for k in changing:
        # Behind a gap a word says the unit of the number that follows it, if one does.
        behind = text[k + 1].lstrip(GAPS) if k + 2 == len(text) else text[k + 1]
        role = _guess(text[k], behind, numbers[k])
        if role is not None:
            if role in roles:
                raise _unclear(changing)
            roles[role] = k
    if roles:
        return roles, ""
    if len(changing) != 1:
        raise _unclear(changing)
    # Goniometers are the usual series.
    return {"angle": changing[0]}, "; nothing in them says so: a number alone is taken for degrees"


def _guess(before: str, behind: str, number: str) -> str | None:
    """What a number is, by the words about it; None where they do not tell."""
    if re.fullmatch(MOMENT, number):
        return "time"
    before, behind = before.casefold().rstrip(GAPS), behind.casefold()
    for told in UNITS, WORDS:
        for role in VALUES:
            if told is UNITS and UNITS[role].search(behind):
                return role
            if told is WORDS and WORDS[role].search(before):
                return role
    return None


def _unclear(changing: Sequence[int]) -> WrongUse:
    what = f"{len(changing)} numbers change" if changing else "No number changes"
    return WrongUse(
        f"{what} from name to name: it is not clear which is the angle or the time.",
        "Say how to read them, such as leaf_{angle}.laz, or give a CSV.",
    )


def _shape(roles: dict[str, int], text: Sequence[str]) -> str:
    by_place = {k: "{" + role + "}" for role, k in roles.items()}
    gaps = [by_place.get(k, "*") for k in range(len(text) - 1)]
    return "".join(f"{before}{gap}" for before, gap in zip(text, gaps, strict=False)) + text[-1]
