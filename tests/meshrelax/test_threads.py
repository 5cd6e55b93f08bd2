# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation of a mesh has the same bits for any number of threads."""

from __future__ import annotations

import numpy as np

import stitchmesh as sm
from tests.compute.thread_counts import thread_count
from tests.gallery import tube


def test_a_relaxed_mesh_has_the_same_bits_for_any_number_of_threads() -> None:
    surface = sm.label(tube(8, 2, radius=2.0, height=2.0))
    fabric = sm.tessellate(surface, stitch_width=0.5)
    found = []
    for threads in (1, 2, 3, 7):
        with thread_count(threads):
            found.append(sm.relax_mesh(fabric, surface=surface, device="cpu").fabric.vertices)
    assert all(np.array_equal(found[0], other) for other in found[1:])
