"""Fits of samples × channels of a scan, as Kaasalainen's Tables 3 and 4, kept in one step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.model.fit_method import Method
from app.model.leaf import FitRecord
from app.model.operations import PutFit, Several
from app.model.project import Project
from app.model.state import make_key, next_key
from app.services.curves import plain
from app.services.fit import POINTS, FitReport, Group, GroupFit, fit_groups
from app.services.lab.gather import gather, members_of
from app.services.lab.own_models import AnyModel

SAMPLE, CHANNEL = "sample", "channel"
READ = 0.3
"""Share of the progress that reading takes."""


@dataclass(frozen=True, slots=True)
class SampleLeaves:
    """A row of the table: leaves that are fitted together; none: the whole scan."""

    name: str
    leaves: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FitTable:
    """Fits of samples × channels of one scan.

    Attributes
    ----------
    scan : str
    samples : tuple of SampleLeaves
    channels : tuple of str
    report : FitReport
        Sample by sample, and of each its channels.
    fixed : mapping of str to float
    """

    scan: str
    samples: tuple[SampleLeaves, ...]
    channels: tuple[str, ...]
    report: FitReport
    fixed: Mapping[str, float]

    @property
    def method(self) -> Method:
        """How they were fitted."""
        return self.report.method

    @property
    def cells(self) -> dict[tuple[str, str], GroupFit]:
        """Fits by the names of sample and channel."""
        return {(one.group[SAMPLE], one.group[CHANNEL]): one for one in self.report.fits}


def each_leaf(project: Project, scan: str, keys: Sequence[str] = ()) -> tuple[SampleLeaves, ...]:
    """One sample per leaf (none named: of all leaves of a scan), by the leaves' names."""
    leaves = [leaf for leaf in project.state.leaves_of(scan) if not keys or leaf.key in keys]
    names = [leaf.name for leaf in leaves]
    return tuple(
        SampleLeaves(
            leaf.name if names.count(leaf.name) == 1 else f"{leaf.name} ({leaf.key})", (leaf.key,)
        )
        for leaf in leaves
    )


def tabulate_fits(
    project: Project,
    scan: str,
    samples: Sequence[SampleLeaves],
    channels: Sequence[str],
    model: AnyModel,
    method: Method = POINTS,
    progress: Progress = QUIET,
    fixed: Mapping[str, float] | None = None,
) -> FitTable:
    """Fit each sample in each channel in one batch; changes nothing.

    A cell that cannot be fitted holds the reason.

    Raises
    ------
    WrongUse
        Two samples of one name, a leaf or a channel that is not there, an unknown model.
    BadInput
        There is no sample or no channel.
    Cancelled
    """
    names = [sample.name for sample in samples]
    if not samples or not channels:
        raise BadInput("A table of fits needs at least one sample and one channel.")
    if twice := {name for name in names if names.count(name) > 1}:
        raise WrongUse(f"Two samples are named {min(twice)}.", "Rename one of them.")
    read_angles(project, scan, samples, progress.part(0.0, READ))
    groups: list[Group] = []
    for sample in samples:
        progress.report(READ, f"Reading {sample.name}")
        for channel in channels:
            measured = gather(project, scan, sample.leaves, channel)
            labels = {SAMPLE: sample.name, CHANNEL: channel}
            groups.append((labels, measured.angle, measured.value))
    report = fit_groups(
        groups, model, method=method, fixed=fixed, progress=progress.part(READ, 1.0)
    )
    return FitTable(scan, tuple(samples), tuple(channels), report, dict(fixed or {}))


def read_angles(
    project: Project, scan: str, samples: Sequence[SampleLeaves], progress: Progress
) -> None:
    """Compute the angles of all samples at once, and not sample by sample."""
    whole = any(not sample.leaves for sample in samples)
    keys = () if whole else tuple(key for sample in samples for key in sample.leaves)
    points, alive = members_of(project, scan, keys), project.state.scan(scan).alive
    wanted = None if points is None else points[alive[points]]
    project.field(scan, "incidence", wanted, progress)


def record_fits(project: Project, table: FitTable) -> list[FitRecord]:
    """Keep all fits of a table in the project, as one step of the history.

    Raises
    ------
    BadInput
        No cell could be fitted; the sentence says why of the first.
    """
    leaves = {sample.name: sample.leaves for sample in table.samples}
    first = int(next_key(project.state.fits, "fit").rpartition("-")[2])
    done = [one for one in table.report.fits if one.result is not None]
    if not done:
        raise BadInput("Nothing could be fitted.", " ".join(table.report.fits[0].warnings))
    records = [
        FitRecord(
            make_key("fit", first + number),
            table.scan,
            leaves[one.group[SAMPLE]],
            one.group[CHANNEL],
            one.model.name,
            plain(one.result),
            table.method,
            dict(table.fixed),
        )
        for number, one in enumerate(done)
        if one.result is not None
    ]
    steps = tuple(PutFit(record.key, record) for record in records)
    if len(steps) == 1:
        project.do(steps[0])
    else:
        project.do(Several(f"Fit {len(steps)} curves", steps))
    return records
