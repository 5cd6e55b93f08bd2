# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sets of yarns beside each other: each keeps its shape, and none overlaps another."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.beside import yarns_beside


def wave(scale: float) -> YarnSet:
    along = np.linspace(0.0, 6.0, 12)
    points = scale * np.stack([along, np.sin(along) - 7.0, np.cos(along)], axis=1)
    return YarnSet.from_curves([points], closed=[False], radius=0.1 * scale)


def test_sets_stand_beside_each_other_on_one_ground():
    sets = [wave(1.0), wave(2.0), wave(1.5)]
    joined = yarns_beside(sets)
    assert joined.yarn_count == 3 and list(joined.radius) == [0.1, 0.2, pytest.approx(0.15)]
    parts = [joined.points[begin:end] for begin, end in zip(joined.start[:-1], joined.start[1:], strict=True)]
    for own, part in zip(sets, parts, strict=True):
        assert np.ptp(part - own.points, axis=0).max() < 1e-12  # moved as a whole
        assert part[:, 1].min() == pytest.approx(0.0, abs=1e-12)
    for left, right in pairwise(parts):
        assert right[:, 0].min() - left[:, 0].max() == pytest.approx(0.12 * 12.0)  # GAP of the widest one
    assert joined.lengths.sum() == pytest.approx(sum(yarns.lengths.sum() for yarns in sets))


def test_no_sets_are_refused():
    with pytest.raises(ParameterError, match="expected at least one set"):
        yarns_beside([])
