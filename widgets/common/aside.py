"""A second document with the same contents, for a worker to read."""

from __future__ import annotations

from app.model.project import Project


def copy_aside(project: Project, scan: str) -> Project:
    """A document of the same state with the known fields of one scan.

    It shares the immutable arrays and nothing else: a worker may compute with it, and what
    it does never reaches the document.
    """
    aside = Project()
    aside.state = project.state
    aside.cache.accept(scan, project.cache.known(scan))
    return aside
