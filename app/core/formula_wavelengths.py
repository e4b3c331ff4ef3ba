"""Formulas over wavelengths: ``r1063`` stands for the channel that is nearest to 1063 nm."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from app.core.arrays import AnyArray, Floats
from app.core.errors import MissingChannel, WrongUse
from app.core.formula import LONGEST_TEXT, Formula, compile_formula
from app.core.formula_syntax import channels_of, parse
from app.core.progress import QUIET, Progress

SYMBOL = re.compile(r"[ri](\d{3,4})(?:_(\d))?")
SAME_LASER_NM = 5.0
"""Of channels so near to the nearest one, the first is taken: it is calibrated, if one is."""
FAR_NM = 20.0


@dataclass(frozen=True, slots=True)
class Pick:
    """The channel that was chosen for a wavelength.

    Attributes
    ----------
    symbol : str
        As the formula writes it, e.g. ``r1063`` or ``r564_3`` for 564.3 nm.
    wanted_nm : float
    channel : str
    nm : float
    """

    symbol: str
    wanted_nm: float
    channel: str
    nm: float

    @property
    def distance_nm(self) -> float:
        """How far the channel is from what was wanted, nm."""
        return abs(self.nm - self.wanted_nm)

    @property
    def words(self) -> str:
        """The choice in words; one that is far says so."""
        far = ", far from what was asked" if self.distance_nm > FAR_NM else ""
        return f"{self.symbol} is {self.channel} ({self.nm:g} nm, {self.distance_nm:g} nm off{far})"


@dataclass(frozen=True, slots=True)
class Resolved:
    """A formula whose wavelengths have found their channels.

    Attributes
    ----------
    formula : Formula
    picks : tuple of Pick
    """

    formula: Formula
    picks: tuple[Pick, ...]

    @property
    def reads(self) -> dict[str, str]:
        """Channel of each name in the formula."""
        picked = {pick.symbol: pick.channel for pick in self.picks}
        return {name: picked.get(name, name) for name in self.formula.names}

    def evaluate(self, values: Mapping[str, AnyArray], progress: Progress = QUIET) -> Floats:
        """Values of the formula from those of channels; see `Formula.evaluate`."""
        own = {name: values[channel] for name, channel in self.reads.items() if channel in values}
        return self.formula.evaluate(own, progress)


def resolve_formula(
    text: str, wavelengths: Mapping[str, float | None], names: Iterable[str] = ()
) -> Resolved:
    """Check a formula and choose the nearest channel for each wavelength in it.

    A name that is a channel stays that channel. The text is never run; see
    `app.core.formula.compile_formula`.

    Parameters
    ----------
    text : str
        E.g. ``(r1063 - r1545) / (r1063 + r1545)``.
    wavelengths : mapping of channel name to nm
        That wavelengths may stand for; the better one first.
    names : iterable of str
        Channels that may be named besides.

    Raises
    ------
    WrongUse
        Something that is not allowed, or two wavelengths for one channel.
    MissingChannel
        A name is no channel, or no wavelength is known.
    """
    channels = dict.fromkeys([*wavelengths, *names])
    picks = tuple(_pick(*symbol, wavelengths) for symbol in _find_symbols(text, channels))
    formula = compile_formula(text, [*channels, *(pick.symbol for pick in picks)])
    for number, pick in enumerate(picks):
        twin = next((p for p in picks[:number] if p.channel == pick.channel), None)
        if twin is not None and twin.wanted_nm != pick.wanted_nm:
            raise WrongUse(
                f"{twin.symbol} and {pick.symbol} are both nearest to {pick.channel} "
                f"({pick.nm:g} nm).",
                _list(wavelengths),
            )
    return Resolved(formula, picks)


def _find_symbols(text: str, channels: Mapping[str, object]) -> list[tuple[str, float]]:
    if len(text) > LONGEST_TEXT:
        return []  # refused when it is compiled
    names = dict.fromkeys(node.id for node in channels_of(parse(text)))
    found = []
    for name in names:
        match = SYMBOL.fullmatch(name)
        if match and name not in channels:
            found.append((name, float(f"{match[1]}.{match[2] or 0}")))
    return found


def _pick(symbol: str, wanted: float, wavelengths: Mapping[str, float | None]) -> Pick:
    known = {name: nm for name, nm in wavelengths.items() if nm is not None}
    if not known:
        raise MissingChannel(
            f"{symbol} asks for {wanted:g} nm, and no channel says its wavelength.",
            "Name the wavelengths of the channels.",
        )
    nearest = min(known.values(), key=lambda nm: abs(nm - wanted))
    channel = next(name for name, nm in known.items() if abs(nm - nearest) <= SAME_LASER_NM)
    return Pick(symbol, wanted, channel, known[channel])


def _list(wavelengths: Mapping[str, float | None]) -> str:
    there = [f"{name} ({nm:g} nm)" for name, nm in wavelengths.items() if nm is not None]
    return f"Channels: {', '.join(there)}."
