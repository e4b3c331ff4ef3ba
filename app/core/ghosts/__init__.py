"""Ghost points: found, explained and put back where they belong (Balduzzi 2011)."""

from app.core.ghosts.correction import SURE, Corrections, correct_ghosts
from app.core.ghosts.image import GhostImage, lay_out, try_layout
from app.core.ghosts.reasons import WORDS, Reason, Reasons, explain_points
from app.core.ghosts.score import BEAM, THRESHOLD, Scores, score_ghosts, warm_up

__all__ = [
    "BEAM",
    "SURE",
    "THRESHOLD",
    "WORDS",
    "Corrections",
    "GhostImage",
    "Reason",
    "Reasons",
    "Scores",
    "correct_ghosts",
    "explain_points",
    "lay_out",
    "score_ghosts",
    "try_layout",
    "warm_up",
]
