"""The cache of fields of a project, and the counter that proves what was computed."""

from __future__ import annotations

from collections.abc import Mapping

from app.model.fields import Catalogue, Subject, Values, fingerprint


class FieldCache:
    """Values of fields by scan and name. One set of values per field: the latest."""

    def __init__(self) -> None:
        self._held: dict[tuple[str, str], Values] = {}
        self._computed: dict[tuple[str, str], int] = {}

    def known(self, scan: str) -> Mapping[str, Values]:
        """What is held for a scan, valid or stale."""
        return {name: values for (key, name), values in self._held.items() if key == scan}

    def find(self, scan: str, catalogue: Catalogue, name: str, subject: Subject) -> Values | None:
        """Values that are still valid, or None."""
        held = self._held.get((scan, name))
        if held is None or held.fingerprint != fingerprint(catalogue, name, subject):
            return None
        return held

    def accept(self, scan: str, results: Mapping[str, Values]) -> None:
        """Take over what an evaluation found, and count the points that it computed."""
        self.count(scan, results)
        for name, values in results.items():
            held = self._held.get((scan, name))
            self._held[scan, name] = values if held is None else held.join(values)

    def count(self, scan: str, results: Mapping[str, Values]) -> None:
        """Count the points that an evaluation computed, whether or not its values are kept."""
        for name, values in results.items():
            self._computed[scan, name] = self._computed.get((scan, name), 0) + values.fresh
            values.fresh = 0

    def computed(self, scan: str) -> dict[str, int]:
        """Points computed since the scan was opened, per field."""
        return {name: n for (key, name), n in self._computed.items() if key == scan}
