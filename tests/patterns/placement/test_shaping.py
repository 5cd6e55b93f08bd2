# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns beside increases and decreases: repeats stay whole, and what does not fit is worked plain and reported."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.courses import find_courses
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import lay_pattern, parse_pattern, read_pattern
from stitchmesh.patterns.placement.units import units_of
from stitchmesh.tessellate import tessellate
from tests.gallery import ROOT
from tests.gallery import tube as coarse_tube
from tests.patterns.fabrics import checked, flat, pattern

LACE = parse_pattern("""pattern "Lace 8 x 6"
rounds 1, 3, 5: k8
round 2: k1 yo ssk k1 k2tog yo k2
round 4: k2 yo sk2p yo k3
round 6: k8""")
ROPE = read_pattern("rope-cable")


def garment(name: str, width: float) -> StitchMesh:
    """Return a garment of the assets."""
    return tessellate(label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")), stitch_width=width)


def cone(top_radius: float) -> StitchMesh:
    """Return a tube of plain stitches that narrows or widens a little in each row."""
    return tessellate(label(coarse_tube(6, 1, radius=6.0, height=14.0, top_radius=top_radius)), stitch_width=0.8)


def loops_of_lines(fabric: StitchMesh) -> list[int]:
    """Return the number of loops above each course, in the order of the courses' rows."""
    courses = sorted(find_courses(fabric), key=lambda course: int(fabric.row[course.faces[0]]))
    return [int(fabric.n_top[list(course.faces)].sum()) for course in courses]


def test_a_lace_covers_a_hat_up_to_its_crown():
    fabric = garment("hat", 1.0)
    laid = lay_pattern(fabric, LACE)
    assert laid.faces_laid > 0.9 * fabric.face_count  # whole rectangles of plain stitches covered 0.5
    made = checked(laid.fabric)
    overs, rows = made.row[made.stitch == Stitch.YARN_OVER], made.row.max()
    assert set(range(2, int(0.7 * rows), 6)) <= set(overs.tolist())  # each row with yarn-overs, up to the crown


@pytest.mark.parametrize("top_radius", [4.5, 7.5], ids=["narrowing", "widening"])
@pytest.mark.parametrize("chosen", [LACE, ROPE], ids=["lace", "rope"])
def test_counts_of_every_line_stay_where_shaping_moves(chosen, top_radius):
    fabric = cone(top_radius)
    assert (fabric.n_bottom != fabric.n_top).any()
    made = checked(lay_pattern(fabric, chosen).fabric)
    assert loops_of_lines(made) == loops_of_lines(fabric)


def test_no_column_of_cables_loses_a_crossing_where_a_tube_widens():
    fabric = cone(7.5)
    laid = lay_pattern(fabric, ROPE)
    made = checked(laid.fabric)
    crossings = {}
    for group in cable_groups(made):
        row = int(made.row[made.side_face[group.sides[0]]])
        crossings[row] = crossings.get(row, 0) + 1
        assert tuple(group.destination) == (2, 3, 0, 1)
    counts = [crossings[row] for row in sorted(crossings)]
    assert all(later >= earlier for earlier, later in pairwise(counts))  # columns begin, and none ends
    assert np.diff(sorted(crossings)).max() == ROPE.height


def test_decreases_lie_in_the_ground_beside_cables():
    fabric = cone(5.4)
    made = lay_pattern(fabric, ROPE).fabric
    decreases = np.flatnonzero(made.n_bottom == 2)
    assert len(decreases)
    purled = np.isin(made.stitch[decreases], (Stitch.D12P, Stitch.D21P))
    assert purled.all()  # the ground is purl and the cables are knit


def test_the_row_of_the_pattern_is_the_same_along_a_course():
    made = lay_pattern(garment("hat", 1.0), LACE).fabric
    for course in find_courses(made):
        kinds = set(made.stitch[list(course.faces)].tolist())
        assert not {int(Stitch.D312K), int(Stitch.YARN_OVER)} < kinds - {int(Stitch.D312K)}
        assert not (Stitch.D312K in kinds and made.row[course.faces[0]] % 6 != 4)


def test_a_unit_is_laid_where_its_loops_are_all_there():
    chosen = pattern("k k k k k k", "y d12k k k d21k y")
    fabric = flat(9, 3)
    faces = [*range(9, 18), *range(19, 27)]  # the second row begins one stitch later
    laid = lay_pattern(fabric, chosen, faces=faces)
    overs = (laid.fabric.stitch == Stitch.YARN_OVER).sum()
    assert overs == 2
    cut = lay_pattern(fabric, chosen, faces=[*range(9, 18), *range(20, 27)])
    assert (cut.fabric.stitch == Stitch.YARN_OVER).sum() == 1  # the other pair misses a loop
    assert any(part.reason.startswith("shaping or the end of a row cuts the repeat") for part in cut.left_out)


def test_units_are_the_smallest_parts_that_keep_the_number_of_loops():
    units = units_of(pattern("k y d12k k d21k y"))
    assert sorted((unit.column, unit.block.width) for unit in units.larger) == [(0, 6), (1, 2), (4, 2)]
    assert sorted(column for _, _, column in units.single) == [0, 3]


def test_a_tuck_and_the_stitch_above_it_are_one_unit():
    units = units_of(read_pattern("half-cardigan"))
    sizes = [(unit.column, unit.block.width, unit.block.height, len(unit.block.stitch)) for unit in units.larger]
    assert sizes == [(0, 2, 2, 4), (0, 1, 2, 2), (1, 1, 2, 2)]  # the repeat, then its two columns of two rows
