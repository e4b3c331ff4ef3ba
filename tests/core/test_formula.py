from __future__ import annotations

import ast
import inspect

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from app.core import formula, formula_syntax
from app.core.errors import BadInput, Cancelled, LeafscopeError, MissingChannel, WrongUse
from app.core.formula import CHUNK, FUNCTIONS, compile_formula
from app.core.progress import LiveProgress

A = np.array([0.5, 2.0, -1.0, 0.0, np.nan])
B = np.array([0.25, 4.0, 3.0, 0.0, 1.0])


def value(text: str) -> np.ndarray:
    return compile_formula(text, ["a", "b"]).evaluate({"a": A, "b": B})


ATTACKS = [
    "__import__('os').system('true')",
    "().__class__.__bases__[0].__subclasses__()",
    "a.__class__",
    "a[0]",
    "(lambda: a)()",
    "[a for a in (1, 2)]",
    "f'{a}'",
    "'a' * 1000000000",
    "a ** b",
    "9 ** 9 ** 9 ** 9 + a",
    "a ** 1e9",
    "a if a > 0 else b",
    "eval('a')",
    "where(a > 0, a, b, out=a)",
    "(b := a)",
    "a @ b",
    "a << 9",
    "True + a",
    "1j * a",
    "a and b",
    "abs(*a)",
    "minimum.reduce(a)",
    "a; import os",
    "a\x00",
    "...",
    "a is b",
    "a in b",
    "not a",
    "a ** --2",
    "",
    "1e999 * a",
]


@pytest.mark.parametrize("text", ATTACKS)
def test_attacks_are_refused_with_a_sentence(text: str) -> None:
    with pytest.raises(WrongUse) as caught:
        compile_formula(text, ["a", "b"])
    assert caught.value.what.endswith(".")


@pytest.mark.parametrize(
    "text",
    ["a" + " + 1" * 125, "-" * 499 + "a", "(" * 240 + "a" + ")" * 240, "a" + "+a" * 120],
)
def test_long_and_deep_texts_are_refused(text: str) -> None:
    with pytest.raises(WrongUse):
        compile_formula(text, ["a"])


def test_bignum_is_a_float_and_cannot_grow() -> None:
    assert value("a * " + "9" * 300)[0] == 0.5 * float("9" * 300)
    assert np.isnan(value("a * 1e300 * 1e300")[1])
    with pytest.raises(WrongUse, match="too large"):
        compile_formula("a * " + "9" * 400, ["a"])


def test_nothing_compiles_or_runs_the_text() -> None:
    for module in (formula, formula_syntax):
        called = {
            node.func.id
            for node in ast.walk(ast.parse(inspect.getsource(module)))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        assert not called & {"eval", "exec", "compile", "getattr", "__import__"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(a - b) / (a + b)", [1 / 3, -1 / 3, -2.0, np.nan, np.nan]),
        ("a ** 2 + -b", [0.0, 0.0, -2.0, 0.0, np.nan]),
        ("a ** -1", [2.0, 0.5, -1.0, np.nan, np.nan]),
        ("log10(a)", [np.log10(0.5), np.log10(2), np.nan, np.nan, np.nan]),
        ("where((a > 0) & ~(b > 1), a, 7)", [0.5, 7, 7, 7, 7]),
        ("a > 0", [1, 1, 0, 0, 0]),
        ("(a > 0) + (b > 0)", [2, 2, 1, 0, 1]),
        ("0 < a <= 1", [1, 0, 0, 0, 0]),
        ("isfinite(b / a)", [1, 1, 1, 0, 0]),
        ("sqrt(b > 0.3)", [0, 1, 1, 0, 1]),
        ("arctan2(a, b) * 0 + maximum(a, b) // 1 % 3", [0, 1, 0, 0, np.nan]),
        ("1 / (1 / (a * 0))", [np.nan] * 5),
    ],
)
def test_values_by_hand(text: str, expected: list[float]) -> None:
    np.testing.assert_allclose(value(text), expected, rtol=1e-15)


def test_thirteen_functions_agree_with_numpy() -> None:
    assert len(FUNCTIONS) == 13
    positive = {"a": np.array([0.3, 0.9]), "b": np.array([0.7, 0.2])}
    for name in set(FUNCTIONS) - {"where", "isfinite"}:
        pair = name in ("arctan2", "minimum", "maximum")
        result = compile_formula(f"{name}(a{', b' if pair else ''})", "ab").evaluate(positive)
        expected = getattr(np, name)(*list(positive.values())[: 1 + pair])
        np.testing.assert_array_equal(result, expected)


Term = tuple[str, float]


def joined(parts: tuple[Term, str, Term]) -> Term:
    (left, x), sign, (right, y) = parts
    result = {"+": x + y, "-": x - y, "*": x * y, "/": x / y if y else np.nan}[sign]
    return f"({left} {sign} {right})", result


terms = st.recursive(
    st.sampled_from([("a", 0.37), ("b", -1.9), ("0.5", 0.5), ("3", 3.0)]),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(joined),
        inner.map(lambda term: (f"-{term[0]}", -term[1])),
        inner.map(lambda term: (f"abs({term[0]})", abs(term[1]))),
    ),
    max_leaves=12,
)


@given(terms)
def test_against_python_floats(term: Term) -> None:
    text, expected = f"a * 0 + {term[0]}", term[1]
    assume(len(text) < 300)
    result = compile_formula(text, ["a", "b"]).evaluate({"a": [0.37], "b": [-1.9]})[0]
    assert result == pytest.approx(expected, rel=1e-12, nan_ok=True)


@given(st.text(alphabet="ab01.+-*/()&|~<>= ,[]{}'\"\\:@µ\n", max_size=60))
def test_any_text_is_accepted_or_refused_politely(text: str) -> None:
    try:
        checked = compile_formula(text, ["a", "b"])
    except LeafscopeError:
        return
    assert set(checked.names) <= {"a", "b"}


def test_names_are_the_channels_in_order_and_functions_are_not_channels() -> None:
    assert compile_formula("log(b) + a / b", ["a", "b", "log"]).names == ("b", "a")
    assert compile_formula("log(log)", ["log"]).names == ("log",)


def test_unknown_name_lists_the_channels() -> None:
    with pytest.raises(MissingChannel, match=r"c in the formula is no channel.*a, b"):
        compile_formula("a + c", ["a", "b"])


def test_names_that_the_parser_folds_are_found() -> None:
    checked = compile_formula("2 * µ", ["µ"])  # micro sign, folded to Greek mu
    assert checked.evaluate({"µ": np.array([1.5])}).tolist() == [3.0]


def test_a_formula_without_a_channel_is_refused() -> None:
    with pytest.raises(WrongUse, match="uses no channel"):
        compile_formula("1 + 1", ["a"])


@pytest.mark.parametrize("text", ["a & b", "~a", "where(a, a, b)"])
def test_conditions_are_not_numbers(text: str) -> None:
    with pytest.raises(WrongUse, match="condition"):
        compile_formula(text, ["a", "b"])


def test_chunks_join_without_a_seam_and_integers_do_not_wrap() -> None:
    n = CHUNK + 7
    a = np.arange(n, dtype=np.uint16)
    result = compile_formula("(a - 70000) * 2", ["a"]).evaluate({"a": a})
    np.testing.assert_array_equal(result, (a.astype(float) - 70000) * 2)


def test_evaluate_can_be_cancelled() -> None:
    progress = LiveProgress(print, cancelled=lambda: True)
    with pytest.raises(Cancelled):
        compile_formula("a", ["a"]).evaluate({"a": A}, progress)


def test_missing_or_uneven_channels() -> None:
    checked = compile_formula("a + b", ["a", "b"])
    with pytest.raises(MissingChannel, match="needs b"):
        checked.evaluate({"a": A})
    with pytest.raises(BadInput, match="different lengths"):
        checked.evaluate({"a": A, "b": B[:2]})


def test_empty_input_gives_empty_output() -> None:
    assert compile_formula("a", ["a"]).evaluate({"a": np.empty(0)}).shape == (0,)
