# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths from marks on a yarn that state the length of yarn up to the next mark."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from stitchmesh.mesh import FloatArray


def marked_stretches(marks: Mapping[float, float], lengths: FloatArray) -> FloatArray:
    """Return the factor of each segment's length that gives the parts between marks their stated lengths.

    A segment belongs to the part in which its middle lies. What lies before the first mark, or in a part that is stated
    to have no length, keeps its length. The last mark reaches to the end of the yarn.

    Args:
        marks: place of each mark, in segments from the start of the yarn, and the length up to the next one [cm].
        lengths: present length of each segment [cm], shape (S,).
    """
    factor = np.ones(len(lengths))
    middles = np.arange(len(lengths)) + 0.5
    for start, end in pairwise([*sorted(marks), float(len(lengths))]):
        part = (middles >= start) & (middles < end)
        if marks[start] > 0.0 and part.any():
            factor[part] = marks[start] / lengths[part].sum()
    return factor
