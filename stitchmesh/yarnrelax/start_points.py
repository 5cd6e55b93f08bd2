# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Other positions of the same yarns from which a relaxation starts."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet


def start_points(start: YarnSet, yarns: YarnSet) -> FloatArray:
    """Control points to start from [cm], shape (N, 3).

    Raises:
        ParameterError: they are not those of the same yarns.
    """
    if not (np.array_equal(start.start, yarns.start) and np.array_equal(start.closed, yarns.closed)):
        found = f"{start.yarn_count} yarns of {len(start.points)} control points"
        expected = f"{yarns.yarn_count} of {len(yarns.points)}, closed where they are"
        raise ParameterError(f"start: got {found}; expected the same yarns, {expected}")
    return start.points
