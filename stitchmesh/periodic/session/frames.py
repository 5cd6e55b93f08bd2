# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a live swatch: the swatch at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.periodic.gauge import FabricMeasures, measure_fabric
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarnrelax import YarnMaterial


@dataclass(frozen=True, eq=False)
class Frame:
    """A swatch at one moment. A frame never changes."""

    number: int
    """Number of the frame in its session, from 1."""
    yarns: YarnSet
    """The yarns of one repeat, on its lattice."""
    fabric: StitchMesh | None
    """The stitches from which the yarns were generated; None for a weave."""
    report: Mapping[str, Any]
    """iteration, counted from the last change; residual and energy [erg], None before the first iteration; gamma, the
    current value; relaxation, the state that the frame shows, as in the report of ``swatch``; preview, whether the
    yarns will be let go off the needles next; at_rest; running, whether more frames follow without another change;
    seconds since the user asked for the change."""
    material: YarnMaterial
    """Material of the yarns."""
    error: Exception | None = None
    """Why the last change failed: the yarns are then in the last accepted state. None if nothing failed."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "report", MappingProxyType(dict(self.report)))

    @property
    def lattice(self) -> Lattice:
        """The periods of the repeat; ``tiling.instances`` gives the positions of its copies."""
        assert self.yarns.lattice is not None
        return self.yarns.lattice

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the repeat [cm], as ``SwatchOptions.period``."""
        return size_of(self.lattice)

    @cached_property
    def measures(self) -> FabricMeasures:
        """Size, gauge, loop length, thickness and areal density of the fabric at this moment."""
        return measure_fabric(self.yarns, self.fabric, self.material.mass_per_length)

    def curves(self, per_segment: int = 4) -> list[FloatArray]:
        """Points along each yarn of the repeat [cm], shape (n, 3) each, up to the start of its next copy.

        Args:
            per_segment: number of points on each segment of the splines.
        """
        return polylines_of_segments(self.yarns, np.arange(len(self.yarns.rest_length)), per_segment).points
