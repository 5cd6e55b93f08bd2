# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small arrays that the host reads again and again, through memory that a GPU writes to directly.

``array.numpy()`` allocates for each reading. Between two kernels of some microseconds this counts.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray


class HostCopy:
    """The contents of an array on the host."""

    def __init__(self, array: wp.array[Any]) -> None:
        """Allocate; the array stays where it is."""
        self._array = array
        self._host = wp.empty_like(array, device="cpu", pinned=True) if array.device.is_cuda and array.size else array

    def read(self) -> NDArray[np.float64]:
        """The present contents; waits for what has been launched before."""
        if self._host is not self._array:
            wp.copy(self._host, self._array)
            wp.synchronize_stream(self._array.device)
        result: NDArray[np.float64] = self._host.numpy().copy()
        return result
