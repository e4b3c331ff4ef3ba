"""What is written to a file: a scan, the fields computed on it, and where they came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.model.scan import Grid, Scan


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """A scan with computed fields, ready to be exported.

    Attributes
    ----------
    scan : Scan
    fields : mapping of str to (n,) arrays
        Computed values beside the scan's own attributes; a field hides an attribute
        of the same name.
    units : mapping of str to str
        Unit of a field or attribute, by its name.
    provenance : mapping of str to object
        Whatever JSON can hold: versions, sources, operations, parameters.
    """

    scan: Scan
    fields: Mapping[str, AnyArray] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, values in self.fields.items():
            if len(values) != len(self.scan):
                raise BadInput(f"{name} has {len(values)} values for {len(self.scan)} points.")

    @property
    def columns(self) -> dict[str, AnyArray]:
        """All values beside the coordinates: attributes, fields, cells of the grid."""
        columns = {**self.scan.attributes, **self.fields}
        grid = self.scan.grid
        if grid is not None:
            columns |= {"row": grid.row, "column": grid.column}
        return columns

    def subset(self, indices: AnyArray) -> Cloud:
        """The points of `indices` ((k,) integers or (n,) booleans), with all that is theirs."""
        fields = {name: values[indices] for name, values in self.fields.items()}
        return replace(self, scan=take_points(self.scan, indices), fields=fields)


def take_points(scan: Scan, indices: AnyArray) -> Scan:
    """A scan of the points of `indices`; cells without echo stay, they are facts of the beams."""
    return replace(
        scan,
        xyz=scan.xyz[indices],
        attributes={name: values[indices] for name, values in scan.attributes.items()},
        grid=_take_cells(scan.grid, indices),
        waveforms=None if scan.waveforms is None else scan.waveforms.take(indices),
    )


def _take_cells(grid: Grid | None, indices: AnyArray) -> Grid | None:
    if grid is None:
        return None
    return replace(grid, row=grid.row[indices], column=grid.column[indices])
