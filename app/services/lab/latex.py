"""Tables of fits for a paper: LaTeX with booktabs, a block per parameter."""

from __future__ import annotations

import math
from collections.abc import Iterable

from app.core.fitting import Estimate
from app.services.fit import FitReport
from app.services.lab.method import describe_method
from app.services.lab.wide_table import Block, arrange_blocks

SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_",
    "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "°": r"$^\circ$", "ω": r"$\omega$", "μ": r"$\mu$", "ν": r"$\nu$", "σ": r"$\sigma$",
    "–": "--", "−": "$-$", "·": r"$\cdot$", "±": r"$\pm$", "\u202f": r"\,", "<": "$<$",
    ">": "$>$",
}  # fmt: skip
NONE = "--"


def as_latex(report: FitReport) -> str:
    """A table environment for each parameter; the preamble needs booktabs.

    Values are rounded to the first two digits of their standard deviation, without one to four
    digits; ``--`` is not determined.

    Raises
    ------
    BadInput
        See `app.services.lab.wide_table.arrange_blocks`.
    """
    blocks = arrange_blocks(report)
    title = report.fits[0].model.title
    told = f"{title}, fitted to {describe_method(report.method)}"
    return "% \\usepackage{booktabs}\n" + "\n".join(_write(block, told) for block in blocks)


def _write(block: Block, told: str) -> str:
    unit = {"1": "", "value": " (unit of the data)"}.get(block.unit, f" ({block.unit})")
    heads = [block.down, *block.columns]
    lines = [
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{escape(block.parameter)}{escape(unit)}: {escape(told)}. "
        r"Standard deviations after $\pm$; -- is not determined.}",
        rf"\begin{{tabular}}{{l{'r' * len(block.columns)}}}",
        r"\toprule",
    ]
    if block.across and len(block.columns) > 1:
        lines.append(rf" & \multicolumn{{{len(block.columns)}}}{{c}}{{{escape(block.across)}}} \\")
        lines.append(rf"\cmidrule(lr){{2-{len(block.columns) + 1}}}")
    lines += [_line(escape(head) for head in heads), r"\midrule"]
    lines += [_line([escape(name), *map(show_estimate, cells)]) for name, cells in block.rows]
    lines += [r"\bottomrule", r"\end{tabular}", r"\end{table}", ""]
    return "\n".join(lines)


def _line(cells: Iterable[str]) -> str:
    return " & ".join(cells) + r" \\"


def show_estimate(estimate: Estimate | None) -> str:
    r"""``$0.452 \pm 0.012$``; without a standard deviation the value alone."""
    if estimate is None or estimate.value is None:
        return NONE
    value, sd = estimate.value, estimate.sd
    if sd is None or sd == 0.0 or not math.isfinite(sd):
        return f"${_number(f'{value:.4g}')}$"
    places = 1 - math.floor(math.log10(sd))
    if places > 12 or places < -4:
        return rf"${_number(f'{value:.4g}')} \pm {_number(f'{sd:.2g}')}$"
    digits = max(places, 0)
    return rf"${round(value, places):.{digits}f} \pm {round(sd, places):.{digits}f}$"


def _number(text: str) -> str:
    """``1.2e-05`` as LaTeX sets powers of ten."""
    digits, _, power = text.partition("e")
    return rf"{digits} \times 10^{{{int(power)}}}" if power else digits


def escape(text: str) -> str:
    """A text as LaTeX prints it."""
    return "".join(SPECIAL.get(letter, letter) for letter in text)
