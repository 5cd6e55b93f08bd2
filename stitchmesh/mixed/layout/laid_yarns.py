# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of either model, laid out on a cloth: nodes at crossings, or control points of B-splines.

Both have ``node_count`` nodes with a ``panel``, a ``position`` in it, a ``triangle`` and ``barycentric`` coordinates, a
place in the ``world``, and Eulerian coordinates ``rest_sliding``; ``yarn_start`` and ``yarn_node`` list the nodes of
each yarn.
"""

from __future__ import annotations

from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.spline_yarns import SplineYarns

LaidYarns = CrossingYarns | SplineYarns
"""Yarns of either model."""
