# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fast reading of small arrays on the host: a GPU copies them into pinned memory that is allocated once.

``array.numpy()`` allocates memory at each reading. Between two kernels of some microseconds this takes too long.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray


class HostCopy:
    """The contents of an array on the host."""

    def __init__(self, array: wp.array[Any]) -> None:
        """Allocate the memory on the host; the array itself stays on its device."""
        self._array = array
        self._host = wp.empty_like(array, device="cpu", pinned=True) if array.device.is_cuda and array.size else array

    def read(self) -> NDArray[np.float64]:
        """Return the present contents, after all earlier launches have ended."""
        if self._host is not self._array:
            wp.copy(self._host, self._array)
            wp.synchronize_stream(self._array.device)
        result: NDArray[np.float64] = self._host.numpy().copy()
        return result
