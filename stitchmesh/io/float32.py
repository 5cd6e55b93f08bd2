# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers for the formats that keep floats of four bytes: rounded to the nearest, never to infinity."""

from __future__ import annotations

from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray


def rounded(path: FilePath, what: str, values: FloatArray) -> NDArray[np.float32]:
    """The values as float32.

    Raises:
        FileError: one is too large; the message names the file and what they are.
    """
    if np.abs(values).max() > np.finfo(np.float32).max:
        raise FileError(f"{fspath(path)}: {what} are too large for the format's float32; write .h5")
    return values.astype(np.float32)
