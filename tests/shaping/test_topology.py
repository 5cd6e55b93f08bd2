# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a fabric lacks of its surface is told."""

from __future__ import annotations

import pytest

import stitchmesh as sm
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stages import auto_stitches_stage
from stitchmesh.run import QUIET
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.report import Topology, topology
from tests.gallery import ROOT, grid, tube
from tests.shaping.surfaces import closed_ball, in_triangles, ring_torus

MESHES = ROOT / "assets" / "meshes"


@pytest.mark.parametrize(
    ("mesh", "found"),
    [
        (grid(3, 2), Topology(1, 1, 0)), (tube(8, 3), Topology(1, 2, 0)), (closed_ball(8, 6), Topology(1, 0, 0)),
        (ring_torus(8, 12), Topology(1, 0, 1)),
    ],
)  # fmt: skip
def test_parts_borders_and_handles_are_counted(mesh, found):
    assert topology(mesh) == found


def test_borders_at_which_a_yarn_is_drawn_through_count_as_closed():
    assert topology(tube(8, 3), tips=2) == Topology(1, 0, 0)


def test_armholes_that_are_lost_at_a_large_stitch_are_told(caplog):
    """A shoulder of the dress is lower than a row, so that its armholes and its neck become one border."""
    mesh = in_triangles(sm.read_mesh(MESHES / "dress.obj"))
    garment = Garment(mesh=mesh, options=KnitOptions(stitch_width=3.0, shaping=ShapingOptions()))
    lost = auto_stitches_stage(garment, QUIET).report["shape"]["lost"]
    assert lost.startswith("the fabric has 2 borders instead of 4: ") and "choose a smaller stitch" in lost
    assert lost in caplog.text and "\n" not in lost


def test_fingertips_whose_holes_are_drawn_together_are_no_lost_borders():
    shaped = sm.shape_fabric(in_triangles(sm.read_mesh(MESHES / "glove.obj")), stitch_width=0.7)
    assert len(shaped.fabric.boundary_loops) == 6 and shaped.report.lost is None


def test_a_small_summit_that_is_knitted_over_is_no_lost_border():
    """If all borders of the sweater begin, its rows end at several summits, of which one is lower than a row."""
    borders = [[0.0, 0.0, 13.0], [0.0, 60.0, 5.0], [56.0, 10.0, 7.0], [-56.0, 10.0, 7.0]]
    marks = [sm.TimeMark("border", [place], "begin") for place in borders]
    mesh = in_triangles(sm.read_mesh(MESHES / "sweater.obj"))
    assert sm.shape_fabric(mesh, stitch_width=1.6, options=sm.ShapingOptions(marks=marks)).report.lost is None
