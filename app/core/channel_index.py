"""An index of either kind, named or a formula, over channels that are chosen already."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.formula_wavelengths import Pick, Resolved, resolve_formula
from app.core.indices import NAMED, NamedIndex, evaluate, match_channels

STEP = 1e-6


@dataclass(frozen=True, slots=True)
class ChannelIndex:
    """An index and the channels that it is made of.

    Attributes
    ----------
    name : str
        Of a named index, or the text of the formula.
    channels : tuple of str
    picks : tuple of Pick
        Which channel stands for which wavelength of a formula.
    how : NamedIndex or Resolved
    """

    name: str
    channels: tuple[str, ...]
    picks: tuple[Pick, ...]
    how: NamedIndex | Resolved

    def evaluate(self, values: Mapping[str, Floats]) -> Floats:
        """Values of the index from those of its channels, arrays of one shape (n,)."""
        if isinstance(self.how, Resolved):
            return self.how.evaluate(values)
        return evaluate(self.how, self._by_role(values))

    def slopes(self, values: Mapping[str, Floats]) -> Floats:
        """Derivative by each channel, (channels, n), by central differences."""
        found = []
        for channel in self.channels:
            step = STEP * np.maximum(np.abs(values[channel]), STEP)
            up, down = (
                self.evaluate({**values, channel: values[channel] + s}) for s in (step, -step)
            )
            found.append((up - down) / (2.0 * step))
        return np.array(found)

    def propagate(self, values: Mapping[str, Floats], covariance: Floats) -> Floats:
        """Standard deviation of the index to first order, (n,).

        Parameters
        ----------
        values : mapping of channel to (n,) array
        covariance : (channels, channels, n) array
        """
        slopes = self.slopes(values)
        variance = np.einsum("in,ijn,jn->n", slopes, covariance, slopes)
        sigma: Floats = np.sqrt(np.maximum(variance, 0.0))
        return sigma

    def _by_role(self, values: Mapping[str, Floats]) -> dict[str, Floats]:
        assert isinstance(self.how, NamedIndex)  # noqa: S101 - the other kind was told apart
        return {role: values[c] for role, c in zip(self.how.roles, self.channels, strict=True)}


def choose_index(
    text: str, wavelengths: Mapping[str, float | None], names: Iterable[str] = ()
) -> ChannelIndex:
    """An index by its name or as a formula, over the nearest channels.

    Parameters
    ----------
    text : str
        ``ndi``, or e.g. ``r900 / r970``.
    wavelengths : mapping of channel name to nm
    names : iterable of str
        Channels that a formula may name besides.

    Raises
    ------
    MissingChannel, WrongUse
        See `match_channels` and `resolve_formula`.
    """
    if text in NAMED:
        roles = match_channels(NAMED[text], wavelengths)
        return ChannelIndex(text, tuple(roles.values()), (), NAMED[text])
    found = resolve_formula(text, wavelengths, names)
    return ChannelIndex(text, tuple(dict.fromkeys(found.reads.values())), found.picks, found)
