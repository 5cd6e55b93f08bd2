# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of runs of mixed yarns and triangles: the blending field, and tension."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.drape import Draped
from stitchmesh.mixed.output.display import Display
from stitchmesh.mixed.output.files import StateMaps, state_maps
from stitchmesh.mixed.output.frames import DrapeFrame
from stitchmesh.render.colour_scale import ColourScale
from stitchmesh.yarn import YarnSet

LEAST_TENSION = 1.0
"""The last colour stands for at least this tension [dyn, or dyn/cm]."""
ALPHA_SCALE = ColourScale(np.array([[128, 152, 184], [200, 176, 130], [196, 84, 60]]), 0.0, 1.0)
"""Colours of the blending field: triangles, hybrid region, yarns."""


def nodes_at_points(draped: Draped, frame: DrapeFrame, curves: YarnSet) -> IntArray:
    """Return the yarn node that is nearest to each control point of the yarns of a state, shape (P,).

    The numbers of one state serve all states of a run.
    """
    found: IntArray = cKDTree(draped.shown_at(frame).nodes).query(curves.points)[1]
    return found


@dataclass(frozen=True, eq=False)
class DrapedValues:
    """Values of one state of a run, at the control points of its yarns and at the vertices of its surface."""

    draped: Draped
    """The run."""
    frame: DrapeFrame
    """The state."""
    node: IntArray
    """Yarn node at each control point of the yarns, shape (P,): ``nodes_at_points``."""

    def alpha(self) -> tuple[FloatArray, FloatArray]:
        """Return the blending field at the control points, shape (P,), and at the vertices, shape (W,)."""
        return self._display.region.node_alpha[self.node], self._display.surface_alpha

    def cloth_tension(self) -> tuple[FloatArray, FloatArray]:
        """Return the larger principal tension of the triangles [dyn/cm], at the control points and at the vertices."""
        tension = self._maps.triangle_tension
        own = tension[self.draped.prepared.fabric.yarns.triangle[self.node]]
        return own, self._display.at_surface(tension)

    def yarn_tension(self) -> FloatArray:
        """Return the tension of the yarns [dyn] at the control points: the larger one of the two yarns at a node."""
        values = np.zeros(len(self._maps.nodes))
        np.maximum.at(values, self._maps.yarn_node, self._maps.yarn_tension)
        at_points: FloatArray = values[self.node]
        return at_points

    @property
    def _display(self) -> Display:
        return self.draped.display_of(self.frame)

    @cached_property
    def _maps(self) -> StateMaps:
        return state_maps(self.draped.prepared.fabric, self._display, self.frame)
