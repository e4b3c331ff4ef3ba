"""User formulas over channels: an allow-list of syntax, walked node by node, never run as code."""

from __future__ import annotations

import ast
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import BadInput, MissingChannel, WrongUse
from app.core.formula_syntax import (
    ARITHMETIC,
    CALLS,
    COMPARISONS,
    LOGIC,
    channels_of,
    check,
    parse,
    refusal,
)
from app.core.progress import QUIET, Progress

LONGEST_TEXT = 500
MOST_NODES = 200
CHUNK = 1_000_000
FUNCTIONS = tuple(CALLS)


@dataclass(frozen=True, slots=True)
class Formula:
    """A checked formula. Only its text is ever stored.

    Attributes
    ----------
    text : str
    names : tuple of str
        Channels that it uses, in order of appearance.
    """

    text: str
    names: tuple[str, ...]
    _tree: ast.expr = field(repr=False, compare=False)

    def evaluate(self, values: Mapping[str, AnyArray], progress: Progress = QUIET) -> Floats:
        """Values of the formula, in chunks of a million points.

        Parameters
        ----------
        values : mapping of channel name to (n,) array
        progress : Progress

        Returns
        -------
        (n,) float64 array
            Conditions give 0 and 1. A step that leaves the finite numbers (division by zero,
            log of zero or less, overflow) gives NaN there, never ±inf.

        Raises
        ------
        MissingChannel
            A channel of the formula is not among `values`.
        BadInput
            The channels are not of one length.
        """
        columns = {name: self._column(values, name) for name in self.names}
        lengths = {len(column) for column in columns.values()}
        if len(lengths) != 1:
            raise BadInput(f"The channels of {self.text} have different lengths.")
        (n,) = lengths
        result = np.empty(n)
        for start in range(0, n, CHUNK):
            progress.report(start / n, self.text)
            part = slice(start, start + CHUNK)
            here = {name: column[part].astype(np.float64) for name, column in columns.items()}
            with np.errstate(all="ignore"):
                result[part] = _walk(self._tree, here)
        return result

    def _column(self, values: Mapping[str, AnyArray], name: str) -> AnyArray:
        if name not in values:
            raise MissingChannel(f"{self.text} needs {name}, which is not given.")
        column = np.asarray(values[name])
        if column.ndim != 1:
            raise BadInput(f"{name} must be one row of values, not {column.shape}.")
        return column


def compile_formula(text: str, names: Iterable[str]) -> Formula:
    """Check a formula and make it ready to be evaluated.

    Allowed: numbers, channel names, ``+ - * / // % **`` (the exponent a number of at most 16
    in size), comparisons, ``& | ~`` between conditions, and the calls in `FUNCTIONS`. All
    else is refused. Numbers are floats, so no power or product can grow without bound.

    Parameters
    ----------
    text : str
        At most 500 characters.
    names : iterable of str
        Channels that may be used.

    Returns
    -------
    Formula

    Raises
    ------
    WrongUse
        The text holds something that is not allowed; the sentence says what.
    MissingChannel
        A name is no channel.
    """
    if len(text) > LONGEST_TEXT:
        raise WrongUse(f"The formula has {len(text)} characters; {LONGEST_TEXT} are allowed.")
    # The parser folds look-alikes (µ, ﬁ) in names; the channels must be folded alike.
    known = {unicodedata.normalize("NFKC", name): name for name in names}
    tree = parse(text)
    if sum(1 for _ in ast.walk(tree)) > MOST_NODES:
        raise WrongUse(f"The formula has more than {MOST_NODES} parts; split it.")
    check(tree, known)
    used = tuple(dict.fromkeys(known[node.id] for node in channels_of(tree)))
    if not used:
        raise WrongUse("The formula uses no channel.", f"Channels: {', '.join(known.values())}.")
    for node in channels_of(tree):
        node.id = known[node.id]
    return Formula(text, used, tree)


def _walk(node: ast.expr, values: Mapping[str, Floats]) -> Any:
    """Value of a node that `check` has let pass."""
    match node:
        case ast.Constant(value=value):
            return np.float64(value)  # type: ignore[arg-type]
        case ast.Name(id=name):
            return _finite(values[name])
        case ast.Call():
            return _call(node, values)
        case ast.Compare():
            return _compare(node, values)
        case ast.BinOp(left=left, op=op, right=right):
            pair = _walk(left, values), _walk(right, values)
            if type(op) in LOGIC:
                return LOGIC[type(op)](*pair)
            return _finite(ARITHMETIC[type(op)](*map(_number, pair)))
        case ast.UnaryOp(op=op, operand=operand):
            inner = _walk(operand, values)
            if isinstance(op, ast.Invert):
                return np.logical_not(inner)
            return -_number(inner) if isinstance(op, ast.USub) else _number(inner)
    raise refusal(node)


def _call(node: ast.Call, values: Mapping[str, Floats]) -> Any:
    name = node.func.id  # type: ignore[attr-defined]
    given = [_walk(each, values) for each in node.args]
    if name != "where":
        given = [_number(each) for each in given]
    return _finite(CALLS[name][0](*given))


def _compare(node: ast.Compare, values: Mapping[str, Floats]) -> Any:
    operands = [_walk(each, values) for each in (node.left, *node.comparators)]
    result = np.True_
    for sign, left, right in zip(node.ops, operands[:-1], operands[1:], strict=True):
        result = np.logical_and(result, COMPARISONS[type(sign)](left, right))
    return result


def _number(value: Any) -> Any:
    # numpy adds two conditions as "or"; a sum of conditions is meant to count.
    return value.astype(np.float64)


def _finite(value: Any) -> Any:
    return value if value.dtype == np.bool_ else np.where(np.isinf(value), np.nan, value)
