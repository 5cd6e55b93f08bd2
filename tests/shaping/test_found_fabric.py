# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is done with other fabrics is done with found ones: patterns, selections, edits, instructions, machines."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.machine_knitting.knitting import machine_program
from stitchmesh.mesh import BORDER, BOTTOM
from stitchmesh.selection.parts import Parts
from tests.gallery import ROOT
from tests.shaping.surfaces import in_triangles


def found(name: str, width: float) -> sm.StitchMesh:
    """A garment from triangles, whose rounds are multiples of four stitches."""
    mesh = in_triangles(sm.read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj"))
    shaped = sm.shape_fabric(mesh, stitch_width=width, options=sm.ShapingOptions(multiple=4))
    return sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric


@pytest.fixture(scope="module")
def hat() -> sm.StitchMesh:
    return found("hat", 1.6)


@pytest.fixture(scope="module")
def sweater() -> sm.StitchMesh:
    return found("sweater", 4.0)


@pytest.mark.parametrize("pattern", ["rope-cable", "eyelet-lace", "lice"])
def test_patterns_and_charts_are_laid_and_have_yarns(hat, pattern):
    laid = sm.apply_pattern(hat, pattern)
    assert (laid.stitch != hat.stitch).any() or (laid.yarn != hat.yarn).any()
    assert sm.generate_yarns(laid, quality="draft").yarn_count > 0


def test_a_rib_leaves_nothing_out_of_rounds_that_are_multiples_of_four(hat):
    brim = sm.select(hat, "hem 4")
    laid = sm.apply_pattern(hat, "rib2x2", faces=brim)
    purls = np.isin(np.flatnonzero(laid.stitch == sm.Stitch.PURL), brim).sum()
    # Cast-on stitches, those of the first row, stay as they are.
    assert purls == np.count_nonzero(hat.stitch[brim] == sm.Stitch.KNIT) / 2


def test_the_borders_of_found_garments_have_their_names(hat, sweater):
    assert [border.name for border in sm.borders(hat)] == ["hem", "tip"]
    assert {border.name for border in sm.borders(sweater)} == {"hem", "neck", "left cuff", "right cuff"}
    assert len(sm.select(sweater, "left sleeve")) == len(sm.select(sweater, "right sleeve")) > 0


@pytest.mark.decides
def test_rows_are_numbered_tube_by_tube(sweater):
    parts = Parts(sweater)
    for hand in ("left", "right"):
        rows = parts.row_numbers[parts.sleeve_rows(hand)]
        assert len(rows) > 5 and np.ptp(rows) == len(rows) - 1
    assert set(np.flatnonzero(sweater.row == 0)) == set(sm.select(sweater, "hem 1"))  # The longest begin comes first.
    below = np.flatnonzero((sweater.twin != BORDER) & (sweater.side_role == BOTTOM) & ~sweater.mismatched)
    # A row is made after the rows whose loops it takes.
    assert (sweater.row[sweater.side_face[below]] > sweater.row[sweater.side_face[sweater.twin[below]]]).all()


def test_edits_are_made_by_row(sweater):
    edited = sm.edits.insert_row(sweater, on="rows 3").fabric
    edited = sm.edits.paste_pattern(edited, on="rows 2-6", pattern="moss").fabric
    assert sm.generate_yarns(edited, quality="draft").yarn_count > 0


def test_written_instructions_are_read_back(hat, sweater):
    for fabric, pieces in ((hat, 1), (sweater, 4)):
        text = sm.knitting_instructions(fabric)
        assert text.startswith(f"Knitting instructions: {pieces} piece")
        assert len(sm.parse_instructions(text)) == pieces


def test_a_machine_knits_a_tube_and_refuses_what_it_cannot_in_one_line(hat, sweater):
    assert machine_program(hat).count("\nknit ") > hat.face_count / 2
    with pytest.raises(ParameterError, match=r"knitting machine: cannot make .*; change these, or knit") as caught:
        machine_program(sweater)
    assert "\n" not in str(caught.value)
