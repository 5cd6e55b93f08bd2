# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A copy on the host has the contents at the time of the reading, and keeps them."""

from __future__ import annotations

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.host_copy import HostCopy


def test_each_reading_has_the_contents_of_its_time():
    array = wp.zeros((3, 2), dtype=wp.float64, device=device_named("cpu"))
    copy = HostCopy(array)
    before = copy.read()
    array.fill_(2.0)
    assert np.array_equal(before, np.zeros((3, 2)))
    assert np.array_equal(copy.read(), np.full((3, 2), 2.0))


def test_an_empty_array_is_read_as_one():
    assert HostCopy(wp.zeros((0, 7), dtype=wp.float64, device=device_named("cpu"))).read().shape == (0, 7)
