# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames: what a live swatch looks like at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.periodic.continuation import size_of
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments


@dataclass(frozen=True, eq=False)
class Frame:
    """A swatch at one moment; nothing of it changes later."""

    number: int
    """Counts the frames of a session from 1."""
    yarns: YarnSet
    """One repeat, on its lattice."""
    fabric: StitchMesh | None
    """The stitches that the yarns were drawn from; None for a weave."""
    report: Mapping[str, Any]
    """iteration, since the change; residual and energy [erg], None as drawn; gamma, as far as it has come; at_rest;
    running, whether more frames follow without another change; seconds since the change was asked for."""
    error: Exception | None = None
    """Why the last change could not be made; the yarns are the last that were good."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "report", MappingProxyType(dict(self.report)))

    @property
    def lattice(self) -> Lattice:
        """Its periods; ``tiling.instances`` says where to draw the copies."""
        assert self.yarns.lattice is not None
        return self.yarns.lattice

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the repeat [cm], as ``SwatchOptions.period``."""
        return size_of(self.lattice)

    def curves(self, per_segment: int = 4) -> list[FloatArray]:
        """Points along each yarn of the repeat [cm], shape (n, 3) each, as far as where its next copy begins.

        Args:
            per_segment: points to a segment of the splines.
        """
        return polylines_of_segments(self.yarns, np.arange(len(self.yarns.rest_length)), per_segment).points
