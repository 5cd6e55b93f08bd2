# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation of large fabrics: time, number of iterations, and remaining stretch.

The target is 65,000 faces within 60 seconds on two cores. The time is that of the whole stage: subdivision, the first
closest points, the relaxation, and the loading of the kernel, which is compiled once on each machine.
"""

from __future__ import annotations

import numpy as np

from benchmarks.scenes.garments import FORMULAS, Garment
from benchmarks.table import Rows
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING


def mesh_relaxation(*, faces: int = 65000) -> Rows:
    """Relax the garments of formulas.

    Args:
        faces: stitch faces of each fabric, about
    """
    yield "scene", "faces", "s", "iterations", "at rest", "residual", "rms stretch", "largest", "smallest"
    for name, make in FORMULAS.items():
        mesh = make()
        area = float(np.linalg.norm(mesh.face_vector_area, axis=1).sum())
        fabric = Garment(name, float(np.sqrt(area / (faces * COURSE_OVER_WALE_SPACING)))).divided()
        relaxed = relax_mesh(fabric, surface=mesh, device="cpu")
        report = relaxed.report
        assert relaxed.fabric.stretch is not None  # the relaxation fills it
        stretches = (report.rms_stretch, report.max_stretch, relaxed.fabric.stretch.min())
        yield (
            name, fabric.face_count, f"{report.seconds:.1f}", report.iterations, report.converged,
            f"{report.residual:.1e}", *(f"{stretch:.3f}" for stretch in stretches),
        )  # fmt: skip
