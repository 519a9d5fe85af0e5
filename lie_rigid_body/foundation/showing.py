"""How results show themselves in a notebook and as tables of pandas, whichever room they are of."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import PACKAGE, LieRigidBodyError

if TYPE_CHECKING:
    from pandas import DataFrame


def report(module: str) -> Any:
    """A module of `report`, which knows the results that other rooms make: it is loaded where one is to be shown."""
    return import_module(f"{PACKAGE}.report.{module}")


class Shown:
    """A result that a notebook shows as a sentence and tables."""

    def _repr_html_(self) -> str:
        return str(report("notebook").html(self))


def data_frame(stamps_ns: Integers, arrays: Mapping[str, Array | None]) -> DataFrame:
    """Table of pandas with a row for each stamp, and a column for each component of the arrays that there are.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        The index, ``t_ns``.
    arrays : mapping of str to ndarray, shape (N, ...), or None
        A column is named after the axes of its component: ``gyro_x``, ``covariance_xy``, and ``attitude_w`` of
        ``attitude_xyzw``.

    Raises
    ------
    LieRigidBodyError
        If pandas is not installed.
    """
    try:
        from pandas import DataFrame, Index
    except ModuleNotFoundError:
        raise LieRigidBodyError("to_dataframe needs pandas, which is not installed: pip install pandas") from None
    columns = {
        "_".join([name.removesuffix("_xyzw"), "".join("xyzw"[axis] for axis in axes)]).rstrip("_"): array[
            (slice(None), *axes)
        ]
        for name, array in arrays.items()
        if array is not None
        for axes in np.ndindex(array.shape[1:])
    }
    return DataFrame(columns, index=Index(stamps_ns, name="t_ns"))
