"""Angular models of the return ("phase functions"): one file per model."""

from app.core.phase._registry import MODELS, get_model
from app.core.phase.model import Parameter, PhaseModel, Reference

__all__ = ["MODELS", "Parameter", "PhaseModel", "Reference", "get_model"]
