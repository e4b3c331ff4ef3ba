"""Which indices a scan can have: named ones and a user's own, for each kind of channels."""

from __future__ import annotations

from dataclasses import dataclass

from app.core.errors import LeafscopeError
from app.core.indices import NAMED
from app.model.project import Project
from app.services.synthetic_footprints import index_in


@dataclass(frozen=True, slots=True)
class Choice:
    """An index to choose; `missing` says in a sentence why it cannot be had, else it is empty."""

    name: str
    title: str
    missing: str = ""


def list_indices(project: Project, scan: str) -> list[Choice]:
    """Indices of a scan, those that cannot be had last; of corrected channels only the others."""
    state = project.state.scan(scan)
    own = {formula.name: formula.text for formula in state.parameters.formulas}
    found, missing = [], []
    for workflow in state.workflows:
        suffix = f"_{workflow}" if workflow else ""
        for name, title in (*((n, index.title) for n, index in NAMED.items()), *own.items()):
            whole = f"{name} = {title}" if name in own else f"{name.upper()}, {title}"
            said = f"{whole} ({workflow.upper()})" if workflow else whole
            try:
                index_in(project, scan, name + suffix)
            except LeafscopeError as error:
                if not workflow:
                    missing.append(Choice(name, said, error.what))
            else:
                found.append(Choice(name + suffix, said))
    return found + missing
