"""Tables of panels as the window asks for them, and the report of a calibration as a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.core.errors import BadInput
from app.core.radiometry.panels import BRIGHTEST
from app.formats.atomic import atomic_files
from app.services.calibrate import CalibrationReport
from app.services.calibration_report import tell
from app.services.panel_columns import TableOptions, read_panels

ANY_NM = 1000.0


@dataclass(frozen=True, slots=True)
class TableLook:
    """What a table of panels holds, and what has to be asked about it.

    Attributes
    ----------
    path : Path
    channels : tuple of str
    rows, scans, panels : int
    brightest : float
        Largest reflectance.
    wavelength_missing : bool
    """

    path: Path
    channels: tuple[str, ...]
    rows: int
    scans: int
    panels: int
    brightest: float
    wavelength_missing: bool

    @property
    def looks_percent(self) -> bool:
        """Whether its reflectances can only be percent."""
        return self.brightest > BRIGHTEST


def look_at_table(path: Path) -> TableLook:
    """Read a table of panels to see what is missing; raises `BadInput` where it is none."""
    try:
        file, missing = read_panels(path), False
    except BadInput:
        # If a wavelength is all that it lacks, it can be asked for.
        file, missing = read_panels(path, TableOptions(wavelength_nm=ANY_NM)), True
    tables = file.tables
    return TableLook(
        path,
        tuple(table.channel for table in tables),
        sum(len(table) for table in tables),
        len({scan for table in tables for scan in table.scans}),
        len({panel for table in tables for panel in table.panels}),
        max(float(table.reflectance.max(initial=0.0)) for table in tables),
        missing,
    )


def write_report(found: CalibrationReport, path: Path, overwrite: bool = False) -> None:
    """Write the report of a calibration as Markdown with its picture (.png): both or none.

    With `overwrite` a picture of that name is replaced only where it belongs to an older report.
    """
    from app.services.calibration_picture import draw_calibration

    picture, older = path.with_suffix(".png"), path.exists()
    with atomic_files() as begin:
        begin(path, overwrite).write_text(tell(found, picture.name), encoding="utf-8")
        draw_calibration(found, begin(picture, overwrite and older))
