"""Kinds of parts that a scene is made of: one file each."""

from app.simulate.parts._registry import KINDS, AnyPart
from app.simulate.parts.part import Part, Pieces, Surroundings, assemble

__all__ = ["KINDS", "AnyPart", "Part", "Pieces", "Surroundings", "assemble"]
