"""What commands print: a few lines for people, or JSON for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from app.cli.console import LINE


def say(text: str) -> None:
    """Print a line for the user, free of the progress line."""
    LINE.wipe()
    print(text)


def plain(value: Any) -> Any:
    """The same value as JSON can hold it: NaN becomes null, numpy numbers become numbers."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if hasattr(value, "item"):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def print_json(value: Any) -> None:
    """Print JSON and nothing else."""
    say(json.dumps(plain(value), indent=2, ensure_ascii=False))


def write_json(value: Any, path: Path, overwrite: bool) -> None:
    """Write JSON to a file, whole or not at all."""
    from app.formats.atomic import atomic_path

    with atomic_path(path, overwrite) as temporary:
        temporary.write_text(json.dumps(plain(value), indent=2, ensure_ascii=False))


def print_values(found: Mapping[str, Any], as_json: bool) -> None:
    """Print names and values."""
    if as_json:
        print_json(found)
        return
    for name, value in found.items():
        say(f"{name.replace('_', ' ')}: {_show(value)}")


def print_info(found: Mapping[str, Any], as_json: bool) -> None:
    """Print what a file holds."""
    if as_json:
        print_json(found)
        return
    say(f"points: {found['points']:,}")
    grid = found["grid"]
    say(f"grid: {grid[0]} rows × {grid[1]} columns" if grid else "grid: none")
    scanner = found["scanner"]
    say(f"scanner: {_show(scanner)}" if scanner else "scanner: unknown (give --origin X,Y,Z)")
    _print_neighbours(found["neighbours"])
    for channel in found["channels"]:
        nm = channel["wavelength_nm"]
        say(
            f"channel: {channel['name']}, {nm or 'wavelength unknown'}{' nm' if nm else ''}, "
            f"{channel['kind']}"
        )
    if not found["channels"]:
        say("channels: none")
    say(f"attributes: {', '.join(found['attributes']) or 'none'}")
    for name, value in found["details"].items():
        if value:
            say(f"{name.replace('_', ' ')}: {value}")
    say(f"bounds: {_show(found['bounds'])}")
    print_warnings(found["warnings"])


def _print_neighbours(scans: Sequence[Mapping[str, Any]]) -> None:
    for scan in scans:
        whose = f" in {scan['scan']}" if len(scans) > 1 else ""
        line = f"neighbours{whose}: {scan['method']}, {scan['reason']}"
        if scan["step_deg"] is not None and scan["method"] == "scan grid":
            down, across = scan["step_deg"]
            line += f": {down:.3g}° × {across:.3g}° between beams"
        say(line)


def print_report(report: Mapping[str, Any], out: Path, as_json: bool) -> None:
    """Print what was computed and what it cost."""
    if as_json:
        print_json(report)
        return
    for name, seconds in report["seconds"].items():
        count = report["computed"].get(name)
        points = f", {count:,} points" if count is not None else ""
        undefined = report["undefined"].get(name, 0)
        without = f", {undefined:,} of them undefined" if undefined else ""
        say(f"{name}: {seconds:.2f} s{points}{without}")
    print_warnings(report["warnings"])
    say(f"{out} written.")


def print_leaves(rows: Sequence[Mapping[str, Any]], out: Path, as_json: bool) -> None:
    """Print how many leaves there are, or the whole table as JSON."""
    if as_json:
        print_json({"leaves": list(rows)})
        return
    say(f"{count_of(len(rows), 'leaf', 'leaves')}; {out} written.")


def print_replay(report: Mapping[str, Any], out: Path, as_json: bool) -> None:
    """Print what a replay did and whether its fits came out the same."""
    if as_json:
        print_json(report)
        return
    say(f"{len(report['steps'])} steps replayed.")
    for fit in report["fits"]:
        say(f"{fit['fit']} {fit['model']}: {'same' if fit['same'] else 'DIFFERENT'}")
    for scan in report["scans"]:
        say(
            f"{scan['scan']}: {scan['shown']:,} of {scan['points']:,} points, "
            f"{scan['leaves']} leaves"
        )
    say(f"{out} written.")


def count_of(number: int, one: str, many: str) -> str:
    """``1 leaf``, ``2 leaves``."""
    return f"{number} {one if number == 1 else many}"


def print_warnings(warnings: Sequence[str]) -> None:
    """Print warnings, a line each."""
    for warning in warnings:
        say(f"note: {warning}")


def _show(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(_show(inner) for inner in value)
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}"
    return str(value)
