"""What a user formula may hold: the allow-list, and the check of a text against it."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from app.core.errors import MissingChannel, WrongUse

LARGEST_EXPONENT = 16.0

ARITHMETIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.FloorDiv: np.floor_divide,
    ast.Mod: np.mod,
    ast.Pow: np.power,
}
LOGIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.BitAnd: np.logical_and,
    ast.BitOr: np.logical_or,
}
COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}
# name -> (function, number of arguments)
CALLS: dict[str, tuple[Callable[..., Any], int]] = {
    "abs": (np.abs, 1),
    "sqrt": (np.sqrt, 1),
    "exp": (np.exp, 1),
    "log": (np.log, 1),
    "log10": (np.log10, 1),
    "sin": (np.sin, 1),
    "cos": (np.cos, 1),
    "tan": (np.tan, 1),
    "arctan2": (np.arctan2, 2),
    "minimum": (np.minimum, 2),
    "maximum": (np.maximum, 2),
    "isfinite": (np.isfinite, 1),
    "where": (np.where, 3),
}
_PLAIN_WORDS = {
    "Attribute": "a dot after a name",
    "Subscript": "square brackets",
    "Lambda": "a lambda",
    "IfExp": "if and else (use where)",
    "JoinedStr": "text",
    "Starred": "a star",
    "BoolOp": "and / or (use & and |)",
    "NamedExpr": "an assignment",
    "Not": "not (use ~)",
    "BitXor": "^ (use ** for a power)",
}


def parse(text: str) -> ast.expr:
    """Syntax tree of a text; nothing of it is run. Raises `WrongUse` with the parser's reason."""
    try:
        return ast.parse(text.strip(), "formula", mode="eval").body
    except SyntaxError as error:
        raise WrongUse(f"The formula cannot be read: {error.msg}.") from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise WrongUse("The formula cannot be read.") from error


def channels_of(tree: ast.expr) -> Iterator[ast.Name]:
    """Names that stand for channels, from left to right; not those of functions."""
    if isinstance(tree, ast.Name):
        yield tree
    children = tree.args if isinstance(tree, ast.Call) else ast.iter_child_nodes(tree)
    for child in children:
        if isinstance(child, ast.expr):
            yield from channels_of(child)


def check(node: ast.expr, known: Mapping[str, str]) -> bool:
    """Refuse what is not allowed; say whether the node is a condition."""
    match node:
        case ast.Constant():
            return _check_number(node)
        case ast.Name():
            return _check_channel(node, known)
        case ast.Call():
            return _check_call(node, known)
        case ast.Compare(left=left, ops=ops, comparators=others):
            for operand in (left, *others):
                check(operand, known)
            for sign in ops:
                _refuse_unless(type(sign) in COMPARISONS, sign)
            return True
        case ast.BinOp(left=left, op=op, right=right):
            return _check_pair(left, op, right, known)
        case ast.UnaryOp(op=ast.Invert(), operand=operand):
            return _check_condition(operand, known)
        case ast.UnaryOp(op=op, operand=operand):
            _refuse_unless(isinstance(op, ast.USub | ast.UAdd), op)
            check(operand, known)
            return False
    raise refusal(node)


def _check_number(node: ast.Constant) -> bool:
    if isinstance(node.value, bool) or not isinstance(node.value, int | float):
        raise WrongUse(f"The formula holds {node.value!r}, which is not a real number.")
    try:
        number = float(node.value)
    except OverflowError:
        number = np.inf
    if not np.isfinite(number):
        raise WrongUse("The formula holds a number that is too large.")
    node.value = number
    return False


def _check_channel(node: ast.Name, known: Mapping[str, str]) -> bool:
    if node.id not in known:
        raise MissingChannel(
            f"{node.id} in the formula is no channel.",
            f"Channels: {', '.join(known.values()) or 'none'}.",
        )
    return False


def _check_call(node: ast.Call, known: Mapping[str, str]) -> bool:
    if not isinstance(node.func, ast.Name) or node.func.id not in CALLS:
        raise WrongUse(
            "The formula calls something that is not allowed.",
            f"Functions: {', '.join(CALLS)}.",
        )
    name = node.func.id
    wanted = CALLS[name][1]
    if node.keywords or len(node.args) != wanted:
        raise WrongUse(f"{name} in the formula takes {wanted} value(s), without names.")
    conditions = [check(argument, known) for argument in node.args]
    if name == "where" and not conditions[0]:
        raise WrongUse("where in the formula needs a condition first, such as a > 0.")
    return name == "isfinite" or (name == "where" and all(conditions))


def _check_pair(
    left: ast.expr, op: ast.operator, right: ast.expr, known: Mapping[str, str]
) -> bool:
    if type(op) in LOGIC:
        return _check_condition(left, known) and _check_condition(right, known)
    _refuse_unless(type(op) in ARITHMETIC, op)
    check(left, known)
    check(right, known)
    if isinstance(op, ast.Pow):
        _check_exponent(right)
    return False


def _check_exponent(node: ast.expr) -> None:
    if isinstance(node, ast.UnaryOp):
        node = node.operand
    # `check` has made every allowed constant a float.
    literal = node.value if isinstance(node, ast.Constant) else None
    if not isinstance(literal, float) or literal > LARGEST_EXPONENT:
        raise WrongUse(f"An exponent must be a number of at most {LARGEST_EXPONENT:g}.")


def _check_condition(node: ast.expr, known: Mapping[str, str]) -> bool:
    if not check(node, known):
        raise WrongUse(
            f"& | ~ work on conditions, and {ast.unparse(node)} is a number.",
            "Write comparisons in brackets: (a > 1) & (b < 2).",
        )
    return True


def _refuse_unless(allowed: bool, node: ast.AST) -> None:
    if not allowed:
        raise refusal(node)


def refusal(node: ast.AST) -> WrongUse:
    """The error for a piece of syntax that is not allowed."""
    kind = type(node).__name__
    return WrongUse(
        f"The formula holds {_PLAIN_WORDS.get(kind, kind)}, which is not allowed.",
        "Use numbers, channels, + - * / **, comparisons, & | ~ and the listed functions.",
    )
