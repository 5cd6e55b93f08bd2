# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fabric with more stitches than its surface has room for must neither fold nor keep on moving."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh import apply_pattern, generate_yarns, label, read_mesh, read_pattern, tessellate
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import relax_mesh_with_report

pytestmark = pytest.mark.decides

MESHES = Path(__file__).parents[2] / "assets" / "meshes"


def sides_between_faces_that_point_apart(fabric: StitchMesh) -> int:
    inner = np.flatnonzero(fabric.twin >= 0)
    first, second = (fabric.face_vector_area[fabric.side_face[side]] for side in (inner, fabric.twin[inner]))
    return int((np.einsum("si,si->s", first, second) < 0.0).sum()) // 2


def openwork(name: str, stitch_width: float) -> tuple[StitchMesh, Mesh]:
    surface = read_mesh(MESHES / f"{name}.obj")
    plain = tessellate(label(surface), stitch_width=stitch_width)
    return apply_pattern(plain, read_pattern("openwork-trellis")), surface


def test_lace_on_the_instep_of_a_sock_does_not_fold() -> None:
    fabric, surface = openwork("sock", 0.8)
    relaxed, report = relax_mesh_with_report(fabric, surface=surface)
    assert report.converged
    assert sides_between_faces_that_point_apart(relaxed) == 0
    assert generate_yarns(relaxed, quality="draft").yarn_count > 0  # refused where yarns of folded stitches touch


def test_a_glove_comes_to_rest_in_the_valleys_between_its_fingers() -> None:
    fabric, surface = openwork("glove", 0.6)
    assert relax_mesh_with_report(fabric, surface=surface)[1].converged
