# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files of a run: yarns, surface, maps and animation. Each is written beside its target and then renamed.

The triangles outside a region of yarns may touch one another in a single vertex. Mesh files of manifold surfaces need a
separate vertex for each fan of triangles (``one_vertex_for_each_fan``).

*Maps of tension.* The tension of a triangle is the larger principal value of the Cauchy stress times thickness [dyn/cm]
of its membrane, sigma = F S F^T / det F with the deformation gradient F and the second Piola-Kirchhoff stress S. In the
full-yarn region it is computed for triangles that follow the yarns and have the stiffness of the cloth. The tension of
the yarns themselves is

    k_s (|w| - 1) [dyn],    w = dx / du on each segment (Cirio et al. 2014).

For B-spline yarns, with the length L and the rest length l of a segment, it is the derivative of the stretch energy and
the length penalty by L, for a uniform parameter speed (``yarnrelax.energies.segment_forces``),

    EA (L / l - 1) [dyn].
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stitchmesh.io.hdf5 import read_dataclass, write_dataclass
from stitchmesh.io.yarn_formats.animated_usd import UsdFrame, write_animated_usd
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mixed.assembly import MixedFabric
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.output.display import Display, Displays, Shown
from stitchmesh.mixed.output.frames import DrapeFrame
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.yarn import YarnSet

YARNS, SURFACE, MAPS, ANIMATION = "yarns", "cloth.obj", "maps.h5", "animation.usdc"
"""Names of files in the output folder; the name of the yarns has no suffix here."""
FORMAT = "stitchmesh mixed maps"
"""Attribute ``format`` of the maps file."""


def one_vertex_for_each_fan(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Return triangles whose vertices have one fan each, and the original vertex of each new vertex.

    Args:
        triangles: vertices of each triangle, shape (T, 3); each edge belongs to at most two of them.

    Returns:
        Vertices of each triangle, shape (T, 3), and the given vertex for each new vertex, shape (n,).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corners = np.arange(triangles.size).reshape(-1, 3)
    starts, ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    flat = triangles.ravel()
    reversed_side = flat[starts] > flat[ends]
    low, high = np.where(reversed_side, ends, starts), np.where(reversed_side, starts, ends)
    order = np.lexsort((flat[high], flat[low]))
    low, high = low[order], high[order]
    same = np.flatnonzero((flat[low[1:]] == flat[low[:-1]]) & (flat[high[1:]] == flat[high[:-1]]))
    one = np.concatenate([low[same], high[same]])
    other = np.concatenate([low[same + 1], high[same + 1]])
    links = coo_array((np.ones(len(one)), (one, other)), shape=(len(flat), len(flat)))
    count, fan = connected_components(links, directed=False)
    source = np.empty(count, dtype=np.int64)
    source[fan] = flat
    return fan[corners].astype(np.int64), source


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
    tension = np.zeros(len(curves.points))
    tension[curves.segment_points[:, 1]] = material.yarn.axial_stiffness * curves.strain
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


class RunFiles:
    """Writes the files of one run."""

    def __init__(self, folder: Path, fabric: MixedFabric, displays: Displays) -> None:
        """Write into a folder, which is created if it is missing."""
        self.folder, self.fabric, self.displays = folder, fabric, displays

    def write_state(self, frame: DrapeFrame, formats: Sequence[str]) -> None:
        """Write yarns, surface and maps of a state.

        Args:
            frame: the state.
            formats: suffixes of the files of yarns, without a dot.

        Raises:
            FileError: a file cannot be written.
        """
        from stitchmesh.io import write_mesh, write_yarns

        display, shown = self.displays.of(frame), self.displays.show(frame)
        curves = display.curves(shown, self.fabric.yarn_radius)
        for suffix in formats:
            write_yarns(self.folder / f"{YARNS}.{suffix}", curves)
        if len(shown.surface):
            triangles, source = one_vertex_for_each_fan(display.triangles)
            write_mesh(self.folder / SURFACE, Mesh.from_polygons(shown.surface[source], triangles.tolist()))
        write_dataclass(self.folder / MAPS, state_maps(self.fabric, display, frame), FORMAT)

    def write_animation(self, frames: Iterable[DrapeFrame], frames_per_second: float) -> int:
        """Write all frames as USD, and return their number.

        Raises:
            FileError: the file cannot be written.
        """
        path = self.folder / ANIMATION
        return write_animated_usd(path, self._animated(frames), frames_per_second=frames_per_second)

    def _animated(self, frames: Iterable[DrapeFrame]) -> Iterator[UsdFrame]:
        for frame in frames:
            display, shown = self.displays.of(frame), self.displays.show(frame)
            tension = triangle_tension(self.fabric.cloth, self.fabric.cloth_material, shown.vertices)
            values = {"alpha": display.surface_alpha, "tension": display.at_surface(tension)}
            curves = display.curves(shown, self.fabric.yarn_radius)
            yield UsdFrame(frame.time, curves, shown.surface, display.triangles, values)


def state_maps(fabric: MixedFabric, display: Display, frame: DrapeFrame) -> StateMaps:
    """Return weights and stress of a state."""
    shown = display.show(frame.vertices, frame.nodes)
    cloth, yarns, region = fabric.cloth, fabric.yarns, display.region
    sliding = np.array(yarns.rest_sliding)
    sliding[region.nodes] = frame.sliding
    return StateMaps(
        vertices=shown.vertices,
        triangles=cloth.triangles,
        vertex_alpha=region.vertex_alpha,
        triangle_kind=region.triangle_kind,
        triangle_tension=triangle_tension(cloth, fabric.cloth_material, shown.vertices),
        nodes=shown.nodes,
        yarn_start=yarns.yarn_start,
        yarn_node=yarns.yarn_node,
        yarn_tension=_tension(fabric, display, shown, sliding),
    )


def _tension(fabric: MixedFabric, display: Display, shown: Shown, sliding: FloatArray) -> FloatArray:
    """Tension of the yarns after each passage [dyn], shape (M,)."""
    yarns, materials = fabric.yarns, fabric.yarn_materials
    if isinstance(yarns, SplineYarns) or isinstance(materials, SplineMaterial):
        assert isinstance(materials, SplineMaterial)
        return spline_tension(display.curves(shown, fabric.yarn_radius), materials)
    return yarn_tension(yarns, materials, shown.nodes, sliding)


def read_maps(path: Path) -> StateMaps:
    """Read the maps of a run.

    Raises:
        FileError: the file cannot be read, or is not a file of maps.
    """
    return read_dataclass(path, StateMaps, FORMAT)
