"""Fits of angular models without start values."""

from app.core.fitting.batch import FitBatch, fit_many
from app.core.fitting.result import Estimate, FitResult
from app.core.fitting.single import fit

__all__ = ["Estimate", "FitBatch", "FitResult", "fit", "fit_many"]
