"""Junttila's workflows: what is made of a calibrated channel to compare leaves at any angle."""

from app.core.workflows.chain import WORKFLOWS, Corrected, Limits, Workflow, correct, get_workflow

__all__ = ["WORKFLOWS", "Corrected", "Limits", "Workflow", "correct", "get_workflow"]
