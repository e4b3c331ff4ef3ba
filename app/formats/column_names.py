"""Names of columns as a file can hold them: unique, and free of what the format forbids."""

from __future__ import annotations

from collections.abc import Callable, Iterable


def give_file_names(
    names: Iterable[str], taken: Iterable[str], clean: Callable[[str], str] = str
) -> dict[str, str]:
    """Name in the file for each name, in order.

    Parameters
    ----------
    names : iterable of str
    taken : iterable of str
        Names that the format needs for itself; compared without regard to case.
    clean : callable
        Takes out what the format forbids.

    Returns
    -------
    dict of str to str
        By the name in the program; a clash gets a number at its end.
    """
    used = {name.lower() for name in taken}
    given = {}
    for name in names:
        wanted = clean(name) or "field"
        free, number = wanted, 2
        while free.lower() in used:
            free, number = f"{wanted}_{number}", number + 1
        used.add(free.lower())
        given[name] = free
    return given
