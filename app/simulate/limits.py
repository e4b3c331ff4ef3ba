"""What a number that describes an instrument may be; refused in words."""

from __future__ import annotations

from math import inf

from app.core.errors import WrongUse


def check_positive(what: str, value: float) -> None:
    """Raise `WrongUse` unless 0 < value < ∞."""
    if not 0 < value < inf:
        raise WrongUse(f"{what} cannot be {value:g}.", "Give a number above 0.")


def check_not_negative(what: str, value: float) -> None:
    """Raise `WrongUse` unless 0 ≤ value < ∞."""
    if not 0 <= value < inf:
        raise WrongUse(f"{what} cannot be {value:g}.", "Give 0 or a number above it.")


def check_share(what: str, value: float) -> None:
    """Raise `WrongUse` unless 0 ≤ value < 1."""
    if not 0 <= value < 1:
        raise WrongUse(f"{what} cannot be {value:g}.", "Give a share, from 0 to below 1.")


def check_choice(what: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise `WrongUse` unless the value is one of the choices."""
    if value not in choices:
        raise WrongUse(f"{what} cannot be {value!r}.", f"Choose from: {', '.join(choices)}.")
