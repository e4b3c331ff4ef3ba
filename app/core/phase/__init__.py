"""Angular models of the return ("phase functions"): one file per model."""

from app.core.phase._registry import MODELS, choose_model, get_model
from app.core.phase.model import Parameter, PhaseModel, Reference

__all__ = ["MODELS", "Parameter", "PhaseModel", "Reference", "choose_model", "get_model"]
