# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How evenly B-spline yarns in a region pass uniform strains of the patch of ``examples/mixed/loops.toml``.

The patch is first at rest with its border held. It is then strained as a whole, its border is held again, and the
middles of the stitches with yarns alone are compared with places that the strain alone would give: root mean square in
the plane over the mean spacing of stitches and over the strain. Yarns everywhere do not keep a uniform strain exactly
either.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from benchmarks.places import MIXED_SCENES
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.assembly import Loads, loaded_system, start_positions
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumReport, EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.region import YARNS, Region, region_around
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.mixed_vector import MixedVector, Parts
from stitchmesh.mixed.scene.scene import read_scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare

SCENE = MIXED_SCENES / "loops.toml"
STRAIN = 0.04
STRAINS = {"courses": (0, 0), "wales": (1, 1), "shear": (0, 1)}
"""Entry of the gradient of each strain."""
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Patch:
    """The patch with a region."""

    prepared: PreparedScene
    region: Region

    @property
    def yarns(self) -> SplineYarns:
        """Its yarns."""
        yarns = self.prepared.fabric.yarns
        assert isinstance(yarns, SplineYarns)
        return yarns

    @property
    def border(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Vertices on the border, and control points of the stitches along it, which are held where yarns are alone."""
        vertices = self.prepared.fabric.cloth.vertices[:, :2]
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        width = self.prepared.scene.cloth.stitch_width or 0.0
        points = self.yarns.curves.points[:, :2]
        outer = np.flatnonzero(((points < low + width) | (points > high - width)).any(axis=1))
        held = outer if (self.region.triangle_kind == YARNS).all() else outer[:0]
        return np.flatnonzero(((vertices < low + 1e-9) | (vertices > high - 1e-9)).any(axis=1)), held

    def rest(self, gradient: Numbers, start: Parts | None = None) -> tuple[Parts, EquilibriumReport]:
        """The equilibrium of the patch after a deformation as a whole."""
        fabric, device = self.prepared.fabric, device_named(self.prepared.scene.solver.device)
        vertices, nodes = self.border
        loads = Loads(gravity=(0.0, 0.0, 0.0), held=[Attachment(vertices, nodes)])
        system = loaded_system(fabric, self.region, loads, device=device)
        v, p, s = start_positions(fabric, self.region, system).numpy() if start is None else start
        positions = MixedVector.from_numpy(v @ gradient.T, p @ gradient.T, s, wp.float64, device)
        settings = EquilibriumSettings(force_tolerance=3.0, most_iterations=250)
        report = find_equilibrium(system, positions, settings)
        return positions.numpy(), report

    def middles(self, parts: Parts, stitches: NDArray[np.int64]) -> Numbers:
        """Mean of the control points of each stitch [cm], shape (n, 3)."""
        points = np.array(self.yarns.curves.points)
        points[self.region.nodes] = parts[1]
        return np.array([points[self.yarns.curves.face == stitch].mean(axis=0) for stitch in stitches])


def mixed_splines() -> Rows:
    """Yield the table."""
    prepared = prepare(read_scene(SCENE))
    cloth, yarns = prepared.fabric.cloth, prepared.fabric.yarns
    every = region_around(
        cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, np.arange(len(cloth.triangles))
    )
    patches = {"region": Patch(prepared, prepared.region), "everywhere": Patch(prepared, every)}
    stitches = inner_stitches(patches["region"])
    spacing = float(np.sqrt(cloth.rest_area.sum() / (len(cloth.triangles) / 2)))
    yield "yarns", "strain", "Newton iterations", "time [s]", "deviation [spacings / strain]"
    for name, patch in patches.items():
        start, _report = patch.rest(np.eye(3))
        before = patch.middles(start, stitches)
        for strain, place in STRAINS.items():
            gradient = np.eye(3)
            gradient[place] += STRAIN
            began = time.perf_counter()
            end, report = patch.rest(gradient, start)
            apart = (patch.middles(end, stitches) - before @ gradient.T)[:, :2]
            deviation = float(np.sqrt((apart**2).sum(axis=1).mean())) / spacing / STRAIN
            seconds = time.perf_counter() - began
            yield name, strain, report.iterations, f"{seconds:.1f}", f"{deviation:.2f}"


def inner_stitches(patch: Patch) -> NDArray[np.int64]:
    """Stitches of which nine tenths of the control points are in the full-yarn region."""
    face = patch.yarns.curves.face
    inside = np.bincount(face[face >= 0], patch.region.node_kind[face >= 0] == YARNS)
    return np.flatnonzero(inside > 0.9 * np.bincount(face[face >= 0]))
