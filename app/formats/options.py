"""What a caller may ask of a reader; plain values, so that it travels as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from app.core.errors import WrongUse


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """How to read a file.

    Attributes
    ----------
    every_nth : int
        Keep each n-th record only (the first one always).
    recover : bool
        Read the complete records of a file that is shorter than its header claims.
    separator : str or None
        Text files: what stands between two columns; None means guessed.
    header_lines : int or None
        Text files: lines to skip before the points; None means guessed.
    columns : tuple of str or None
        Text files: a name for each column; None means guessed.
    metres_per_unit : float
        Length of the file's unit; 1 where it holds metres. The reading service applies it
        to every format; readers leave coordinates in the file's unit.
    """

    every_nth: int = 1
    recover: bool = False
    separator: str | None = None
    header_lines: int | None = None
    columns: tuple[str, ...] | None = None
    metres_per_unit: float = 1.0

    def __post_init__(self) -> None:
        if self.every_nth < 1:
            raise WrongUse(
                f"Every n-th point: --every-nth must be 1 or more, not {self.every_nth}."
            )
        if not 1e-6 <= self.metres_per_unit <= 1e6:
            raise WrongUse(
                f"The unit in metres (--unit) lies in 1e-6 to 1e6, not at {self.metres_per_unit}."
            )

    def as_json(self) -> dict[str, Any]:
        """The options as a dictionary of plain values."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> ReadOptions:
        """The options that `as_json` wrote."""
        columns = values.get("columns")
        return cls(**{**values, "columns": None if columns is None else tuple(columns)})

    @classmethod
    def from_text(cls, texts: Mapping[str, str]) -> ReadOptions:
        """The options that `changed` gave."""
        return cls.from_json({name: json.loads(text) for name, text in texts.items()})

    def changed(self) -> dict[str, str]:
        """The options that differ from the defaults, as JSON texts for `Source.options`."""
        default = ReadOptions()
        return {
            item.name: json.dumps(getattr(self, item.name))
            for item in fields(self)
            if getattr(self, item.name) != getattr(default, item.name)
        }


DEFAULTS = ReadOptions()
