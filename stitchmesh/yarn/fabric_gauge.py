# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The gauge of a fabric as it was made."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn.yarn_presets import Gauge


def fabric_gauge(fabric: StitchMesh) -> Gauge:
    """Return the gauge of the median stitch of a fabric.

    The wale spacing is the median length of the course sides, and the course spacing that of the wale sides.
    """
    width, height = (float(np.median(fabric.side_length[sides])) for sides in (~fabric.is_wale, fabric.is_wale))
    return Gauge.of_stitch(width, height)
