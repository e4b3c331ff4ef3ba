"""What the commands that fit print: a block for each group, or JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.cli.printing import print_json, print_warnings, say

if TYPE_CHECKING:
    from app.services.lab.orders import LabReport

CRITERIA = {"AIC": "aic", "AICc": "aicc", "BIC": "bic"}


def print_lab(report: LabReport, written: Sequence[Path], as_json: bool) -> None:
    """Print fits, intervals and comparisons."""
    found = report.as_dict()
    if as_json:
        print_json(found)
        return
    for entry in found["fits"]:
        _print_fit(entry)
    for table in found.get("comparisons", ()):
        _print_comparison(table)
    print_warnings(found["notes"])
    for path in written:
        say(f"{path} written.")


def _print_fit(entry: Mapping[str, Any]) -> None:
    if entry["rss"] is None:
        say(f"{_name(entry['group'])}: {entry['model']}, not fitted: {' '.join(entry['warnings'])}")
        return
    rss = f"{entry['rss']:.6g}"
    what = "means" if entry["kind"] == "bins" else "points"
    say(f"{_name(entry['group'])}: {entry['model']}, {entry['n']} {what}, rss {rss}")
    for name, estimate in entry["parameters"].items():
        say(f"  {name} = {_show_estimate(estimate)}{_show_span(entry['intervals'][name])}")
        for what, word in (("profile", "by profile"), ("bootstrap", "by leaf")):
            one = entry.get(what, {}).get(name)
            if one is not None:
                say(f"    {word}: {_show_interval(one)}")
    if entry["aic"] is not None:
        told = (
            f"{name} {entry[key]:.5g}" for name, key in CRITERIA.items() if entry[key] is not None
        )
        say(f"  {', '.join(told)}")
    for what in ("profile", "bootstrap"):
        if words := entry.get(what, {}).get("words"):
            say(f"note: {words}")
    print_warnings(entry["warnings"])


def _print_comparison(table: Mapping[str, Any]) -> None:
    say(f"{_name(table['group'])}: models side by side")
    if table["models"]:
        say(
            f"  {'model':<18}{'k':>3}{'rmse':>12}{'ΔAIC':>10}{'ΔAICc':>10}{'ΔBIC':>10}{'weight':>9}"
        )
    for row in table["models"]:
        if row["n"] is None:
            say(f"  {row['model']:<18}{' '.join(row['words'])}")
            continue
        above = "".join(f"{_show(row[f'{key}_above'], '.2f'):>10}" for key in CRITERIA.values())
        weight = _show(row["weight"], ".3f")
        best = "  best" if row["best"] else ""
        say(f"  {row['model']:<18}{row['k']:>3}{row['rmse']:>12.5g}{above}{weight:>9}{best}")
    if table["note"]:
        say(f"note: {table['note']}")


def _name(group: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {value or '(empty)'}" for name, value in group.items()) or "all"


def _show_estimate(estimate: Mapping[str, Any]) -> str:
    value, sd, unit = (estimate[key] for key in ("value", "sd", "unit"))
    if value is None:
        return "not determined"
    said = "" if unit in ("1", "value") else f" {unit}"
    return f"{value:.6g} ± {'unknown' if sd is None else f'{sd:.2g}'}{said}"


def _show_span(span: Sequence[float] | None) -> str:
    return "" if span is None else f" (95 %: {span[0]:.5g} to {span[1]:.5g})"


def _show_interval(one: Mapping[str, Any]) -> str:
    low, high = (_show(one[key], ".5g") for key in ("low", "high"))
    return f"{low} to {high}{' (' + one['words'] + ')' if one['words'] else ''}"


def _show(value: float | None, form: str) -> str:
    return "–" if value is None else format(value, form)
