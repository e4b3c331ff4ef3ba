"""Fits arranged as Kaasalainen prints them: a block per parameter, samples × channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from app.core.errors import BadInput
from app.core.fitting import Estimate
from app.services.fit import FitReport

Cells = tuple[Estimate | None, ...]


@dataclass(frozen=True, slots=True)
class Block:
    """One parameter of all fits.

    Attributes
    ----------
    parameter, unit, meaning : str
    down : str
        What the rows are, e.g. ``sample``.
    across : str
        What the columns are, e.g. ``channel``; empty where there is but one.
    columns : tuple of str
    rows : tuple of (str, tuple of Estimate or None)
        None where there is no fit.
    """

    parameter: str
    unit: str
    meaning: str
    down: str
    across: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, Cells], ...]


def arrange_blocks(report: FitReport) -> tuple[Block, ...]:
    """A block per parameter; the last label of the groups goes across, the others down.

    Raises
    ------
    BadInput
        The fits are not apart by anything, or two are of the same sample and channel.
    """
    labels = list(report.fits[0].group)
    if not labels:
        raise BadInput(
            "A wide table needs fits apart by sample and channel.", "Group by these columns."
        )
    across = labels[-1] if len(labels) > 1 else ""
    down = labels[:-1] if across else labels
    rows = _unique([", ".join(one.group[name] for name in down) for one in report.fits])
    columns = _unique([one.group[across] if across else "all" for one in report.fits])
    cells: dict[tuple[str, str], dict[str, Estimate]] = {}
    for one in report.fits:
        place = (
            ", ".join(one.group[name] for name in down),
            one.group[across] if across else "all",
        )
        if place in cells:
            raise BadInput(f"Two fits are of {' and '.join(place)}: they share a cell.")
        cells[place] = dict(one.result.parameters) if one.result is not None else {}
    return tuple(
        Block(
            p.name, p.unit, p.meaning, ", ".join(down), across, tuple(columns),
            tuple(
                (row, tuple(cells.get((row, column), {}).get(p.name) for column in columns))
                for row in rows
            ),
        )
        for p in report.fits[0].model.parameters
    )  # fmt: skip


def _unique(names: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(names))
