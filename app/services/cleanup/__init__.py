"""The clean-up of ghost points: an answer for each, explained, applied as one step, counted."""

from app.services.cleanup.answers import SETTINGS, Answer, Setting, Uncertain
from app.services.cleanup.apply import make_step
from app.services.cleanup.explain import Explainer
from app.services.cleanup.plan import Plan, plan_cleanup
from app.services.cleanup.statistics import Statistics, sum_up

__all__ = [
    "SETTINGS",
    "Answer",
    "Explainer",
    "Plan",
    "Setting",
    "Statistics",
    "Uncertain",
    "make_step",
    "plan_cleanup",
    "sum_up",
]
