"""Fits of angular models without start values."""

from app.core.fitting.result import Estimate, FitResult
from app.core.fitting.solve import fit

__all__ = ["Estimate", "FitResult", "fit"]
