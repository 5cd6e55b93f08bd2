# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One repeat of a fabric of crossing yarns, with its neighbourhood.

The repeat is cut out of a patch that is laid out in the same manner as a fabric. All copies of a node of the repeat in
the patch move in the same manner (``cell_equilibrium``). Nodes of the repeat have the weight 1, all other nodes
the weight 0, and the weight of an element is the mean over its nodes. The copies of an element therefore have the
weight 1 together. The energy of the patch is then the energy of one repeat of an endless fabric, and the border of the
patch does not count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.crossings.crossing_term import CrossingElements, crossing_elements
from stitchmesh.mixed.crossings.stitch_term import StitchElements, stitch_elements
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.knit import checked_spacing, lay_knit
from stitchmesh.mixed.layout.weave import lay_weave, yarn_distance

Numbers = NDArray[np.float64]
Integers = NDArray[np.int64]
MARGIN = 4
"""Width of the patch around the repeat, in yarns or loops; an element reaches over two nodes."""
OUTSIDE = -1
"""Copy number of a node near the border of the patch that is no copy of a node of the repeat."""


@dataclass(frozen=True, eq=False, kw_only=True)
class YarnCell:
    """A repeat of n nodes in a patch of P nodes; arrays are read-only.

    Raises:
        ParameterError: a node of the repeat has no copy among the neighbours of another one: the patch is too small.
    """

    period: Numbers
    """Width of the repeat along the courses and height along the wales [cm], shape (2,)."""
    flat: Numbers
    """Position of each node of the patch in the flat fabric [cm], shape (P, 2)."""
    sliding: Numbers
    """Rest Eulerian coordinates of the nodes [cm], shape (P, 2)."""
    copy_of: Integers
    """Node of the repeat, 0 to n - 1, of which each node of the patch is a copy, or ``OUTSIDE``; shape (P,)."""
    elements: CrossingElements
    """Elements of the patch, with the weights of the repeat."""
    stitches: StitchElements
    """Stitch contacts of a knit, with the weights of the repeat; none for a weave."""
    materials: FabricMaterials
    """Materials of the yarns."""

    def __post_init__(self) -> None:
        for array in (self.period, self.flat, self.sliding, self.copy_of):
            array.flags.writeable = False
        if self.node_count == 0:
            raise ParameterError("yarn cell: the repeat holds no node; expected at least one crossing")

    @property
    def node_count(self) -> int:
        """Number n of nodes of the repeat."""
        return int(self.copy_of.max(initial=OUTSIDE)) + 1

    @property
    def area(self) -> float:
        """Area of the repeat [cm^2]."""
        return float(self.period.prod())

    @property
    def density(self) -> float:
        """Mass of yarn per area [g/cm^2]."""
        return float((self.elements.density * self.elements.rest_length).sum()) / self.area

    @property
    def stiffness(self) -> float:
        """Largest stretch stiffness of a yarn [dyn], the scale of forces."""
        return float(self.elements.stretch.max())


def weave_cell(over: ArrayLike, *, ends: float, picks: float, materials: FabricMaterials) -> YarnCell:
    """The repeat of a weave.

    Args:
        over: whether each weft passes over each warp in one repeat, shape (wefts, warps), as in ``lay_weave``.
        ends: warps per cm.
        picks: wefts per cm.
        materials: materials of wefts and warps.

    Raises:
        ParameterError: the matrix is empty or a density is not positive.
    """
    matrix = np.asarray(over)
    rows, columns = matrix.shape if matrix.ndim == 2 else (1, 1)
    spacing = np.array([yarn_distance("ends", ends), yarn_distance("picks", picks)])
    count = np.array([columns, rows])
    yarns = lay_weave(_patch(-MARGIN * spacing, (count + MARGIN) * spacing), matrix, ends=ends, picks=picks)
    return cell_of(yarns, count * spacing, materials)


def knit_cell(knit: ArrayLike, *, wale_spacing: float, course_spacing: float, materials: FabricMaterials) -> YarnCell:
    """The repeat of a knit.

    Args:
        knit: whether each stitch of the chart is a knit stitch, not a purl stitch, shape (rows, columns), as in
            ``lay_knit``.
        wale_spacing: distance of two wales [cm].
        course_spacing: distance of two courses [cm].
        materials: material of the yarn, as ``weft``.

    Raises:
        ParameterError: the chart is empty or a spacing is not positive.
    """
    chart = np.asarray(knit)
    rows, columns = chart.shape if chart.ndim == 2 else (1, 1)
    spacing = np.array([checked_spacing("wale", wale_spacing), checked_spacing("course", course_spacing)])
    count = np.array([columns, rows])
    cloth = _patch(-MARGIN * spacing, (count + MARGIN) * spacing)
    yarns = lay_knit(cloth, chart, wale_spacing=wale_spacing, course_spacing=course_spacing)
    return cell_of(yarns, count * spacing, materials)


def cell_of(yarns: CrossingYarns, period: Numbers, materials: FabricMaterials) -> YarnCell:
    """The repeat whose corner is at the origin of the panel, out of yarns that are laid out on a larger panel.

    Args:
        yarns: the patch, one panel.
        period: width and height of the repeat [cm], shape (2,).
        materials: materials of the yarns.

    Raises:
        ParameterError: the patch is too small.
    """
    copy_of = _copies(yarns.position, np.asarray(period, dtype=np.float64))
    inside = np.array((yarns.position >= 0.0).all(axis=1) & (yarns.position < period).all(axis=1))
    _check_neighbours(yarns, inside, copy_of)
    weight = inside.astype(np.float64)
    slides = np.ones((yarns.node_count, 2), dtype=bool)
    elements = crossing_elements(yarns, materials, alpha=weight, slides=slides)
    return YarnCell(
        period=np.array(period),
        flat=np.array(yarns.position),
        sliding=np.array(yarns.rest_sliding),
        copy_of=copy_of,
        elements=elements,
        stitches=stitch_elements(yarns, elements, materials.weft, alpha=weight),
        materials=materials,
    )


def _patch(low: Numbers, high: Numbers) -> Cloth:
    """A rectangle of two triangles."""
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    return Cloth(
        vertices=np.column_stack([corners, np.zeros(4)]),
        triangles=triangles,
        rest=corners[triangles],
        panel=np.zeros(2, dtype=np.int64),
        panel_names=("patch",),
    )


def _copies(position: Numbers, period: Numbers) -> Integers:
    """The node of the repeat of which each node is a copy."""
    tile = np.floor(position / period)
    place = np.round((position / period - tile) / 1e-6).astype(np.int64)  # nodes that are nearer are one
    inside = (tile == 0.0).all(axis=1)
    of_repeat, number = np.unique(place[inside], axis=0, return_inverse=True)
    if len(of_repeat) != inside.sum():
        raise ParameterError("yarn cell: two nodes of the repeat lie at the same place; expected different places")
    known = {tuple(key): int(which) for key, which in zip(place[inside].tolist(), number.reshape(-1), strict=True)}
    return np.array([known.get(tuple(key), OUTSIDE) for key in place.tolist()])


def _check_neighbours(yarns: CrossingYarns, inside: NDArray[np.bool_], copy_of: Integers) -> None:
    """Refuse a patch in which a node that shares an element with the repeat is not a copy of a node of the repeat."""
    reached = inside.copy()
    for _ in range(2):
        beside = yarns.neighbours[reached]
        if (beside < 0).any():
            raise ParameterError("yarn cell: a yarn ends within two nodes of the repeat; expected a larger patch")
        reached[beside] = True
    if (copy_of[reached] == OUTSIDE).any():
        raise ParameterError("yarn cell: the layout does not repeat with the given period; expected its repeat")
