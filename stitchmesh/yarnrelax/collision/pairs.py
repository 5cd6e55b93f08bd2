# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of contact samples, as candidate lists name them."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.vector_loads import load_vector
from stitchmesh.yarnrelax.model.lattice_images import entry_shift, sample_number


@wp.func
def from_entry(images: Any, samples: wp.array[Any], p: int, here: Any, entry: int) -> Any:
    """Vector from a sample that ``p`` lists, in its image, to ``here``, where p lies; the sum of the two radii last."""
    there = load_vector(samples, sample_number(images, entry))
    apart = here - there
    return type(here)(apart[0], apart[1], apart[2], here[3] + there[3]) - entry_shift(images, type(here)(), p, entry)
