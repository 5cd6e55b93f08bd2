# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Maps of stress: tension in the triangles and in the yarns.

The tension of a triangle is the larger principal value of the Cauchy stress times thickness [dyn/cm] of its membrane,
sigma = F S F^T / det F with the deformation gradient F and the second Piola-Kirchhoff stress S. In the full-yarn region
it is computed for triangles that follow the yarns and have the stiffness of the cloth. The tension of the yarns
themselves is

    k_s (|w| - 1) [dyn],    w = dx / du on each segment (Cirio et al. 2014).

For B-spline yarns, with the length L and the rest length l of a segment, it is the derivative of the stretch energy and
the length penalty by L, for a uniform parameter speed (``yarnrelax.energies.segment_forces``),

    2 (k_len + k_length) (L / l - 1) / l [dyn].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.splines.spline_material import SplineMaterial
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.yarn import YarnSet


def triangle_tension(cloth: Cloth, material: ClothMaterial, vertices: FloatArray) -> FloatArray:
    """Return the larger principal tension of each triangle [dyn/cm], shape (T,).

    Args:
        cloth: the cloth.
        material: material of the cloth.
        vertices: positions of the vertices [cm], shape (V, 3).
    """
    gradient = cloth.deformation_gradients(vertices)
    strain = 0.5 * (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(2))
    course, wale, shear = material.curves()
    coupling = float(material.moduli()[0, 1])
    stress = np.empty_like(strain)
    stress[:, 0, 0] = course.at(strain[:, 0, 0]) + coupling * strain[:, 1, 1]
    stress[:, 1, 1] = wale.at(strain[:, 1, 1]) + coupling * strain[:, 0, 0]
    stress[:, 0, 1] = stress[:, 1, 0] = shear.at(2.0 * strain[:, 0, 1])
    area = np.sqrt(np.maximum(np.linalg.det(np.swapaxes(gradient, 1, 2) @ gradient), 1e-30))
    cauchy = gradient @ stress @ np.swapaxes(gradient, 1, 2) / area[:, None, None]
    plane, _ = np.linalg.qr(gradient)
    largest: FloatArray = np.linalg.eigvalsh(np.swapaxes(plane, 1, 2) @ cauchy @ plane)[:, 1]
    return largest


def yarn_tension(
    yarns: CrossingYarns, materials: FabricMaterials, nodes: FloatArray, sliding: FloatArray
) -> FloatArray:
    """Return the tension of the segment after each passage [dyn], 0 at the end of a yarn, shape (M,).

    Args:
        yarns: the layout.
        materials: materials of the yarns.
        nodes: positions of all nodes [cm], shape (N, 3).
        sliding: Eulerian coordinates of all nodes [cm], shape (N, 2).
    """
    place = nodes[yarns.yarn_node]
    along = sliding[yarns.yarn_node, yarns.yarn_coordinate]
    stiffness = np.array([material.stretch_stiffness for material in materials.by_family])
    inner = np.flatnonzero(yarns.passage_yarn[1:] == yarns.passage_yarn[:-1])
    length = np.linalg.norm(place[inner + 1] - place[inner], axis=1)
    tension = np.zeros(len(yarns.yarn_node))
    rest = np.maximum(along[inner + 1] - along[inner], 1e-12)
    tension[inner] = stiffness[yarns.yarn_family[yarns.passage_yarn[inner]]] * (length / rest - 1.0)
    return tension


def spline_tension(curves: YarnSet, material: SplineMaterial) -> FloatArray:
    """Return the tension of the segment that begins near each control point [dyn], 0 where none begins, shape (N,).

    Args:
        curves: the yarns.
        material: material of the yarns.
    """
    stiffness = 2.0 * (material.yarn.k_len + material.yarn.k_length)
    tension = np.zeros(len(curves.points))
    tension[curves.segment_points[:, 1]] = stiffness * curves.strain / curves.rest_length
    return tension


@dataclass(frozen=True, eq=False)
class StateMaps:
    """Weights and stress of a state, on the cloth and along the yarns; the content of ``maps.h5``."""

    vertices: FloatArray
    """Positions of the vertices [cm], shape (V, 3)."""
    triangles: IntArray
    """Vertices of the triangles, shape (T, 3)."""
    vertex_alpha: FloatArray
    """The blending field at the vertices, shape (V,)."""
    triangle_kind: IntArray
    """0 where triangles are simulated, 1 in the hybrid region, 2 where yarns are; shape (T,)."""
    triangle_tension: FloatArray
    """Larger principal tension of the triangles [dyn/cm], shape (T,)."""
    nodes: FloatArray
    """Positions of all yarn nodes [cm], shape (N, 3)."""
    yarn_start: IntArray
    """First passage of each yarn, and M at the end, shape (Y + 1,)."""
    yarn_node: IntArray
    """Node of each passage, shape (M,)."""
    yarn_tension: FloatArray
    """Tension of the segment after each passage [dyn], shape (M,); 0 at the end of a yarn."""
