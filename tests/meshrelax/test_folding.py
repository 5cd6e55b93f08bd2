# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fabric with more stitches than fit on its surface must not fold, and its relaxation must converge."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from stitchmesh import apply_pattern, generate_yarns, label, read_mesh, read_pattern, tessellate
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import MeshRelaxOptions, relax_mesh
from stitchmesh.meshrelax.dynamics import ON_SURFACE

pytestmark = pytest.mark.decides

MESHES = Path(__file__).parents[2] / "assets" / "meshes"


def folded_edges(fabric: StitchMesh) -> int:
    """Number of edges between faces whose normals differ by more than a right angle."""
    inner = np.flatnonzero(fabric.twin >= 0)
    first, second = (fabric.face_vector_area[fabric.side_face[side]] for side in (inner, fabric.twin[inner]))
    return int((np.einsum("si,si->s", first, second) < 0.0).sum()) // 2


def openwork(name: str, stitch_width: float) -> tuple[StitchMesh, Mesh]:
    surface = read_mesh(MESHES / f"{name}.obj")
    plain = tessellate(label(surface), stitch_width=stitch_width)
    return apply_pattern(plain, read_pattern("openwork-trellis")), surface


def test_lace_on_the_instep_of_a_sock_does_not_fold() -> None:
    fabric, surface = openwork("sock", 1.0)
    made = relax_mesh(fabric, surface=surface)
    relaxed, report = made.fabric, made.report
    assert report.converged
    assert folded_edges(relaxed) == 0
    # The generation of yarns raises an error if the yarns of folded stitches touch.
    assert generate_yarns(relaxed, quality="draft").yarn_count > 0


@pytest.mark.nightly
def test_a_glove_converges_in_the_valleys_between_its_fingers() -> None:
    fabric, surface = openwork("glove", 0.6)
    assert relax_mesh(fabric, surface=surface).report.converged


def test_stitches_whose_forces_must_rise_before_they_fall_converge() -> None:
    """Rows of a coarse sock slip past its heel: judged by the residual alone, steps shrink to nothing there."""
    surface = read_mesh(MESHES / "sock.obj")
    fabric = tessellate(label(surface), stitch_width=1.6)
    made = relax_mesh(fabric, surface=surface)
    relaxed, report = made.fabric, made.report
    assert ON_SURFACE.patience is not None and report.iterations > ON_SURFACE.patience
    assert report.converged and report.remedy == ""
    assert folded_edges(relaxed) == 0


@pytest.mark.nightly
def test_the_aspect_of_a_message_works() -> None:
    surface = read_mesh(MESHES / "hat.obj")
    fabric = tessellate(label(surface), stitch_width=4.0)
    report = relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(aspect=6.0)).report
    assert not report.converged
    for aspect in re.findall(r"from (.*) to (.*), because", report.remedy)[0]:
        assert relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(aspect=float(aspect))).report.converged
