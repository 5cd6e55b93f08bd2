# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rounding of numbers for formats that store 32-bit floating-point numbers."""

from __future__ import annotations

from os import fspath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray


def from_float32(values: NDArray[Any]) -> FloatArray:
    """Return numbers of a file as float64; a NaN of any bits becomes a quiet NaN, which a later check refuses."""
    with np.errstate(invalid="ignore"):
        return values.astype(np.float64)


def to_float32(path: FilePath, what: str, values: FloatArray) -> NDArray[np.float32]:
    """Round values to the nearest float32.

    Args:
        path: the file that is being written, for the error message.
        what: what the values are, for the error message.
        values: an array of any shape.

    Raises:
        FileError: a value is not finite, or too large for float32.
    """
    # A third of the largest float32, so that bounding boxes stay finite.
    if not (np.abs(values) <= 1e38).all():
        raise FileError(f"{fspath(path)}: {what} are too large for the format's float32; write .h5")
    return values.astype(np.float32)
