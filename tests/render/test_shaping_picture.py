# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of shaping show decreases, grafts and stretch in their colours."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.render import render
from stitchmesh.render.face_colouring import IRREGULAR
from stitchmesh.render.labeling_drawing import MISMATCH_COLOUR
from stitchmesh.render.shaping_picture import render_shaping
from stitchmesh.shaping.report import shaping_report
from stitchmesh.shaping.triangle_surface import triangle_surface
from stitchmesh.tessellate import tessellate
from tests.gallery import tube
from tests.render.test_labeling_picture import SIZE, near
from tests.render.test_pictures import rings

pytestmark = pytest.mark.usefixtures("display")


def stitches(mesh: Mesh) -> StitchMesh:
    """Stitches of 0.6 cm, of which all edges are as long as they should be."""
    fabric = tessellate(label(mesh), stitch_width=0.6)
    return replace(fabric, stretch=np.ones(len(fabric.edge_side)))


def drawn(fabric: StitchMesh, path: Path, surface: Mesh) -> Path:
    render_shaping(fabric, path, asdict(shaping_report(fabric, triangle_surface(surface, 1.0), 1.0, 0.0)), size=SIZE)
    assert Image.open(path).size == SIZE
    return path


def test_decreases_are_marked_and_plain_stitches_are_not(tmp_path):
    narrowing, colour = tube(8, 3, radius=3.0, top_radius=1.5), IRREGULAR["decreases"]
    plain = near(drawn(stitches(tube(8, 3)), tmp_path / "plain.png", tube(8, 3)), colour)  # A few pixels of dark edges.
    assert near(drawn(stitches(narrowing), tmp_path / "narrow.png", narrowing), colour) > 300 + plain


def test_grafts_are_lines(tmp_path):
    mesh = tube(8, 5)
    for flip, count in (((), 0), ((16,), 100)):
        fabric = label(mesh, flip=flip)
        found = near(drawn(fabric, tmp_path / "grafts.png", mesh), MISMATCH_COLOUR)
        assert found > count if flip else found == 0


def test_one_view_of_the_shaping_is_a_colour_of_stitches(tmp_path):
    fabric = stitches(tube(8, 3, radius=3.0, top_radius=1.5))
    render(fabric, tmp_path / "view.png", colour="irregular", size=SIZE)
    assert near(tmp_path / "view.png", IRREGULAR["decreases"]) > 100
    with pytest.raises(ParameterError, match="got 'irregular'"):
        render(rings(), tmp_path / "yarns.png", colour="irregular")
