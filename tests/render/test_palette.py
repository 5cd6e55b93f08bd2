# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of stitches."""

from __future__ import annotations

import itertools

import numpy as np

from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.palette import STITCH_COLOURS


def test_every_stitch_has_its_own_colour():
    assert set(STITCH_COLOURS) == set(Stitch)
    for (first, one), (second, other) in itertools.combinations(STITCH_COLOURS.items(), 2):
        # Five steps of 255 in one channel are the smallest visible difference of neighbouring colours.
        assert np.abs(np.subtract(one, other)).max() >= 5, f"{first.name} and {second.name}"
