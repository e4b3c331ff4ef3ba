"""Values of a checked formula together with their derivatives, node by node (forward mode)."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.core.formula_syntax import CALLS, COMPARISONS, LOGIC, refusal

Gradient = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Dual:
    """A value and its derivatives by name; a name that is missing has derivative 0."""

    value: Any
    by: Gradient


def walk(node: ast.expr, values: Mapping[str, Any], by: frozenset[str]) -> Dual:
    """Value of a node that the allow-list has let pass, and its derivatives by the names `by`.

    Griewank and Walther, Evaluating Derivatives (2008), chapter 3. The tree is walked, nothing
    of it is run as code.
    """
    match node:
        case ast.Constant(value=value):
            return Dual(np.float64(value), {})  # type: ignore[arg-type]
        case ast.Name(id=name):
            return Dual(values[name], {name: 1.0} if name in by else {})
        case ast.BinOp(left=left, op=op, right=right):
            a, b = walk(left, values, by), walk(right, values, by)
            if type(op) in LOGIC:
                return Dual(LOGIC[type(op)](a.value, b.value), {})
            return PAIRS[type(op)](_number(a), _number(b))
        case ast.UnaryOp(op=op, operand=operand):
            inner = walk(operand, values, by)
            if isinstance(op, ast.Invert):
                return Dual(np.logical_not(inner.value), {})
            inner = _number(inner)
            return _chain(-inner.value, (inner, -1.0)) if isinstance(op, ast.USub) else inner
        case ast.Compare(left=left, ops=ops, comparators=others):
            sides = [walk(each, values, by).value for each in (left, *others)]
            pairs = zip(ops, sides[:-1], sides[1:], strict=True)
            held = [COMPARISONS[type(sign)](a, b) for sign, a, b in pairs]
            return Dual(np.logical_and.reduce(np.broadcast_arrays(*held)), {})
        case ast.Call(func=ast.Name(id=name), args=arguments):
            given = [walk(each, values, by) for each in arguments]
            return _call(name, given)
    raise refusal(node)


def _call(name: str, given: list[Dual]) -> Dual:
    if name == "where":
        test, a, b = given
        return _choose(test.value, _number(a), _number(b))
    given = [_number(each) for each in given]
    if name in ("minimum", "maximum"):
        a, b = given
        first = a.value <= b.value if name == "minimum" else a.value >= b.value
        return _choose(first, a, b)
    value = CALLS[name][0](*(each.value for each in given))
    if name == "isfinite":
        return Dual(value, {})
    slopes = SLOPES[name](value, *(each.value for each in given))
    return _chain(value, *zip(given, slopes, strict=True))


def _chain(value: Any, *parts: tuple[Dual, Any]) -> Dual:
    """Derivatives of a step from those of what went into it, and its slopes by them."""
    by: Gradient = {}
    for inner, slope in parts:
        for name, rate in inner.by.items():
            by[name] = by.get(name, 0.0) + slope * rate
    return Dual(value, by)


def _choose(first: Any, a: Dual, b: Dual) -> Dual:
    names = a.by.keys() | b.by.keys()
    by = {name: np.where(first, a.by.get(name, 0.0), b.by.get(name, 0.0)) for name in names}
    return Dual(np.where(first, a.value, b.value), by)


def _number(dual: Dual) -> Dual:
    return Dual(np.asarray(dual.value, np.float64), dual.by)


def _power(a: Dual, b: Dual) -> Dual:
    value = np.power(a.value, b.value)
    parts = [(a, b.value * np.power(a.value, b.value - 1.0))]
    if b.by:
        # 0**b is 0 for every positive b.
        safe = np.where(a.value > 0.0, a.value, 1.0)
        parts.append((b, np.where(a.value > 0.0, value * np.log(safe), 0.0)))
    return _chain(value, *parts)


PAIRS: Mapping[type[ast.operator], Callable[[Dual, Dual], Dual]] = {
    ast.Add: lambda a, b: _chain(a.value + b.value, (a, 1.0), (b, 1.0)),
    ast.Sub: lambda a, b: _chain(a.value - b.value, (a, 1.0), (b, -1.0)),
    ast.Mult: lambda a, b: _chain(a.value * b.value, (a, b.value), (b, a.value)),
    ast.Div: lambda a, b: _chain(a.value / b.value, (a, 1.0 / b.value), (b, -a.value / b.value**2)),
    ast.FloorDiv: lambda a, b: Dual(np.floor_divide(a.value, b.value), {}),
    ast.Mod: lambda a, b: _chain(
        np.mod(a.value, b.value), (a, 1.0), (b, -np.floor_divide(a.value, b.value))
    ),
    ast.Pow: _power,
}
SLOPES: Mapping[str, Callable[..., tuple[Any, ...]]] = {
    "abs": lambda _y, x: (np.sign(x),),
    "sqrt": lambda y, _x: (0.5 / y,),
    "exp": lambda y, _x: (y,),
    "log": lambda _y, x: (1.0 / x,),
    "log10": lambda _y, x: (1.0 / (x * np.log(10.0)),),
    "sin": lambda _y, x: (np.cos(x),),
    "cos": lambda _y, x: (-np.sin(x),),
    "tan": lambda y, _x: (1.0 + y**2,),
    "arctan2": lambda _z, y, x: (x / (x**2 + y**2), -y / (x**2 + y**2)),
}
