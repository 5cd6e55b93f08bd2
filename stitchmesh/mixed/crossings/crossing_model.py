# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elements of crossing yarns on a device, as their kernels read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.precision import vector
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements


@dataclass(frozen=True, eq=False)
class CrossingModel:
    """Constants of N crossing nodes on a device; the meaning of the values is that of ``CrossingElements``."""

    link: wp.array[wp.int32]
    """Neighbours as 2 j + c, or -1; shape (N, 4)."""
    slides: wp.array[Any]
    """1 for each free Eulerian coordinate and 0 for each fixed one, two-vectors; shape (N,)."""
    segment: wp.array[Any]
    """k_s, k_c L, contact distance and merging distance of each segment, four-vectors; shape (N, 2)."""
    bend: wp.array[Any]
    """k_b and the merging distance of both segments together, two-vectors; shape (N, 2)."""
    shear: wp.array[Any]
    """k_x L of the quadrants, four-vectors; shape (N,)."""
    shear_rest: wp.array[Any]
    """Rest angle of the first quadrant, shape (N,)."""
    count: int
    """Number N of nodes."""

    @staticmethod
    def of(elements: CrossingElements, scalar: Any, device: wp.Device) -> CrossingModel:
        """The constants of elements, in the precision of ``scalar``."""
        merging = elements.merging_distance
        before = elements.link[:, 1::2]
        span = merging + np.where(before >= 0, merging.reshape(-1)[np.maximum(before, 0)], 0.0)
        segment = [elements.stretch, elements.contact, elements.contact_distance, merging]

        def upload(values: Any, size: int = 1) -> wp.array[Any]:
            return wp.array(values, dtype=scalar if size == 1 else vector(size, scalar), device=device)

        return CrossingModel(
            link=wp.array(elements.link.astype(np.int32), dtype=wp.int32, device=device),
            slides=upload(elements.slides.astype(np.float64), 2),
            segment=upload(np.stack(segment, axis=-1), 4),
            bend=upload(np.stack([elements.bending, span], axis=-1), 2),
            shear=upload(elements.shear, 4),
            shear_rest=upload(elements.rest_shear),
            count=elements.count,
        )

    @property
    def constants(self) -> list[Any]:
        """The first arguments of the kernels over stars."""
        return [self.link, self.segment, self.bend, self.shear, self.shear_rest]
