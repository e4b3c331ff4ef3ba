"""Operations as JSON plus arrays: for session files and for inverses on disk. No pickle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.model.operations import AnyOperation, Coordinates, Numbers
from app.model.points import PointSet


def encode(operation: AnyOperation, arrays: dict[str, AnyArray], prefix: str) -> bytes:
    """Write an operation as JSON; its arrays go into `arrays` under `prefix`-numbered names."""

    def hook(value: Any) -> Any:
        if isinstance(value, PointSet):
            array: AnyArray = value.indices
        elif isinstance(value, (Coordinates, Numbers)):
            array = value.values
        else:
            raise NotImplementedError(f"cannot store {type(value).__name__}")
        name = f"{prefix}-{len(arrays)}"
        arrays[name] = array
        return {"array": name}

    return msgspec.json.encode(operation, enc_hook=hook)


def decode(text: bytes | str, arrays: Mapping[str, AnyArray]) -> AnyOperation:
    """Read an operation; raises `BadInput` when the record is not one of ours."""

    def hook(wanted: type, value: Any) -> Any:
        return _restore(wanted, arrays[value["array"]])

    try:
        operation: AnyOperation = msgspec.json.decode(text, type=AnyOperation, dec_hook=hook)
    except (msgspec.MsgspecError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise BadInput(f"A step of the session cannot be read: {error}.") from error
    return operation


def _restore(wanted: type, array: AnyArray) -> Any:
    if wanted is PointSet:
        if array.ndim != 1 or array.dtype.kind not in "iu":
            raise ValueError("a point set must be a list of row numbers")
        return PointSet(array)
    if wanted is Coordinates:
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError("coordinates must be n × 3")
        return Coordinates(np.asarray(array, np.float64))
    if wanted is Numbers:
        if array.ndim != 1 or array.dtype.kind != "f":
            raise ValueError("numbers of points must be a list of floats")
        return Numbers(array)
    raise ValueError(f"unexpected {wanted.__name__}")
