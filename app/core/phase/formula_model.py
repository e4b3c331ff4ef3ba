"""A user's own angular model: a checked expression in omega with named parameters."""

from __future__ import annotations

import ast
import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations
from typing import Any

import msgspec
import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.formula import LONGEST_TEXT, MOST_NODES
from app.core.formula_syntax import CALLS, channels_of, check, parse
from app.core.phase._registry import MODELS
from app.core.phase.angular import AngularModel
from app.core.phase.dual import walk
from app.core.phase.parameter import Parameter

OMEGA = "omega"
MOST_PARAMETERS = 8
EQUAL = 1e-9


class FormulaParameter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One parameter of a formula, as it is stored.

    Attributes
    ----------
    name : str
    typical : (float, float)
        Where a value may be expected: searches start there, sliders reach from end to end; in
        units of the largest value if `scales`.
    lower, upper : float or None
        Bounds; None for none.
    unit, meaning : str
    scales : bool
        Proportional to the data.
    """

    name: str
    typical: tuple[float, float]
    lower: float | None = None
    upper: float | None = None
    unit: str = "1"
    meaning: str = ""
    scales: bool = False


class FormulaDefinition(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A formula model as it is stored: nothing but texts and numbers.

    Attributes
    ----------
    name : str
        Must not be that of a model of the registry.
    expression : str
        In ``omega``, radians, and the parameters; see `app.core.formula.compile_formula` for
        what is allowed. An exponent may be any expression here.
    parameters : tuple of FormulaParameter
    """

    name: str
    expression: str
    parameters: tuple[FormulaParameter, ...]


@dataclass(frozen=True)
class FormulaModel(AngularModel):
    """A model made of a `FormulaDefinition` by `make_formula_model`."""

    definition: FormulaDefinition = field(kw_only=True)
    tree: ast.expr = field(kw_only=True, repr=False, compare=False)

    def evaluate(self, angle: Floats, values: Mapping[str, float]) -> Floats:
        """I(ω); NaN where the formula has no finite value."""
        return self._walk(angle, values, ())[0]

    def slope(self, angle: Floats, values: Mapping[str, float]) -> Floats:
        """dI/dω per radian, by differentiating the formula."""
        return self._walk(angle, values, (OMEGA,))[1][OMEGA]

    def jacobian(self, angle: Floats, values: Mapping[str, float], names: Sequence[str]) -> Floats:
        """dI/dparameter, (n, len(names)), by differentiating the formula."""
        by = self._walk(angle, values, tuple(names))[1]
        return np.stack([by[name] for name in names], axis=-1)

    @property
    def is_scaled(self) -> bool:
        """Whether some parameters are proportional to the data."""
        return any(p.scales for p in self.parameters)

    def _walk(
        self, angle: Floats, values: Mapping[str, float], by: tuple[str, ...]
    ) -> tuple[Floats, dict[str, Floats]]:
        angle = np.asarray(angle, np.float64)
        known: dict[str, Any] = {
            p.name: np.float64(values.get(p.name, np.nan)) for p in self.parameters
        }
        with np.errstate(all="ignore"):
            found = walk(self.tree, known | {OMEGA: angle}, frozenset(by))
        return _finite(found.value, angle), {
            name: _finite(found.by.get(name, 0.0), angle) for name in by
        }


def _finite(value: Any, angle: Floats) -> Floats:
    wide = np.broadcast_to(np.asarray(value, np.float64), angle.shape)
    return np.where(np.isfinite(wide), wide, np.nan)


@lru_cache(maxsize=64)
def make_formula_model(definition: FormulaDefinition) -> FormulaModel:
    """Check a definition and make it a model.

    Raises
    ------
    WrongUse
        The name is taken, the expression holds something that is not allowed, a parameter is
        named twice, impossible or unused, its bounds are empty, or those that should scale do
        not.
    MissingChannel
        The expression holds a name that is neither ``omega`` nor a parameter.
    """
    if not definition.name.strip() or definition.name in MODELS:
        raise WrongUse(f"A formula model cannot be named {definition.name!r}.", "Choose another.")
    names = [p.name for p in definition.parameters]
    _check_names(names)
    tree = _read(definition.expression, names)
    used = {node.id for node in _list_names(tree)}
    if OMEGA not in used:
        raise WrongUse("The formula does not depend on omega, the angle in radians.")
    if idle := [name for name in names if name not in used]:
        raise WrongUse(f"The formula does not use {', '.join(idle)}.")
    model = FormulaModel(
        name=definition.name,
        title=definition.name,
        formula=definition.expression,
        source="a user's formula",
        parameters=tuple(map(_make_parameter, definition.parameters)),
        definition=definition,
        tree=tree,
    )
    _check_scaling(model)
    return model


def _check_names(names: list[str]) -> None:
    if not 1 <= len(names) <= MOST_PARAMETERS:
        raise WrongUse(f"A formula has 1 to {MOST_PARAMETERS} parameters, not {len(names)}.")
    for name in names:
        if not (name.isascii() and name.isidentifier()) or name == OMEGA or name in CALLS:
            raise WrongUse(f"{name!r} cannot be the name of a parameter.")
        if names.count(name) > 1:
            raise WrongUse(f"Two parameters are named {name!r}.")


def _make_parameter(p: FormulaParameter) -> Parameter:
    lower = -np.inf if p.lower is None else p.lower
    upper = np.inf if p.upper is None else p.upper
    low, high = p.typical
    # Written so that a NaN fails.
    if not (lower <= low < high <= upper and np.isfinite(high - low)):
        raise WrongUse(
            f"{p.name} needs a usual range within its bounds: {lower:g} ≤ {low:g} < {high:g} ≤"
            f" {upper:g} does not hold."
        )
    if p.scales and any(np.isfinite(b) and b != 0.0 for b in (lower, upper)):
        raise WrongUse(f"{p.name} scales with the data: only 0 can be a bound of it.")
    return Parameter(p.name, p.unit, p.meaning, (low, high), lower, upper, p.scales)


def _read(expression: str, names: list[str]) -> ast.expr:
    """The checked tree of an expression."""
    if len(expression) > LONGEST_TEXT:
        raise WrongUse(f"The formula has {len(expression)} characters; {LONGEST_TEXT} are allowed.")
    tree = parse(expression)
    if sum(1 for _ in ast.walk(tree)) > MOST_NODES:
        raise WrongUse(f"The formula has more than {MOST_NODES} parts; split it.")
    known = {name: name for name in (OMEGA, *names)}
    # Formulas over channels allow numbers as exponents only; here each is a formula itself,
    # which is as safe: floats overflow to infinity.
    plain = copy.deepcopy(tree)
    for node in [n for n in ast.walk(plain) if isinstance(n, ast.BinOp)]:
        if isinstance(node.op, ast.Pow):
            check(node.right, known)
            node.right = ast.Constant(1.0)
    if check(plain, known):
        raise WrongUse("The formula is a condition, not a number.")
    return tree


def _list_names(tree: ast.expr) -> list[ast.Name]:
    return list(channels_of(tree))


def _check_scaling(model: FormulaModel) -> None:
    """Raise `WrongUse` where doubling the scaling parameters does not double the curve."""
    flagged = [p.name for p in model.parameters if p.scales]
    if flagged and not _doubles(model, flagged):
        raise WrongUse(
            f"Doubling {join_words(flagged)} does not double the curve.", _find_cure(model, flagged)
        )


def _doubles(model: FormulaModel, scaling: Sequence[str]) -> bool:
    """Whether the curve doubles with some parameters, wherever it has a value."""
    angle = np.linspace(0.05, 1.4, 28)
    generator = np.random.default_rng(0)
    for _ in range(4):
        once = model.random(generator)
        twice = once | {name: 2.0 * once[name] for name in scaling}
        a, b = 2 * model.evaluate(angle, once), model.evaluate(angle, twice)
        if not np.allclose(a, b, rtol=EQUAL, atol=0.0, equal_nan=True):
            return False
    return True


def _find_cure(model: FormulaModel, flagged: Sequence[str]) -> str:
    """Which parameters are to scale, so that the curve does: nearest to those that were said."""
    names = [p.name for p in model.parameters]
    groups = [set(g) for size in range(1, len(names) + 1) for g in combinations(names, size)]
    groups.sort(key=lambda group: len(group ^ set(flagged)))
    cure = next((group for group in groups if _doubles(model, list(group))), None)
    if cure is None:
        return "No choice of its parameters scales it: let none scale."
    one = len(cure) == 1
    said = join_words([name for name in names if name in cure])
    return f"Let {said} scale with the data, and {'it' if one else 'them'} alone."


def join_words(names: Sequence[str]) -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
