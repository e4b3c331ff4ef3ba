"""Δω as wrinkles are measured: leaf by leaf, with a curve of choice.

No formula of the document gives these values: a service measures them and hands them over. They
go when leaves, points, ghost marks or deletions change, and a session does not keep them.
"""

from __future__ import annotations

from app.core.arrays import Ints
from app.core.errors import BadInput
from app.model.fields import Computed, Evaluation, FieldSpec, Need

DELTA, SIGNIFICANCE = "wrinkle_delta", "wrinkle_significance"
NEEDS: tuple[Need, ...] = ("points", "pose", "deleted", "marks", "leaves")


def refuse_wrinkles(evaluation: Evaluation, _: Ints | None) -> Computed:
    """Say where the values come from; raises `BadInput`."""
    raise BadInput(
        f"Wrinkles of {evaluation.subject.state.scan.name} are not measured: their curve is "
        "chosen each time, and no session keeps them.",
        "Press Measure wrinkles in the Δω panel.",
    )


WRINKLES = (
    FieldSpec(
        DELTA, "Δω as measured", "°", "signed angle", refuse_wrinkles, needs=NEEDS, given=True
    ),
    FieldSpec(
        SIGNIFICANCE, "Δω as measured, over its σ", "", "signed angle", refuse_wrinkles,
        needs=NEEDS, given=True,
    ),
)  # fmt: skip
