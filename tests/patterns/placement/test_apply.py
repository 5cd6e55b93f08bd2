# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns on fabrics: where the tiles lie, and which parts of the fabric stay unchanged."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.change import Marks, Patch, apply_change, inverse_change
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Cell, Loop, Pattern, Row, apply_pattern, lay_pattern, read_pattern
from stitchmesh.patterns.placement.placement import plain_above
from stitchmesh.tessellate import tessellate
from tests.gallery import GARMENTS, ROOT
from tests.gallery import tube as coarse_tube
from tests.nightly import mostly_at_night
from tests.patterns.fabrics import checked, codes, differing, flat, pattern, tube

ASSETS = ROOT / "assets" / "meshes"
NAMES = mostly_at_night([path.stem for path in GARMENTS], by_day=("hat", "sheep", "sweater"))
RIB = pattern("k k p p")
PURL = pattern("p p p p")
CROSSED = pattern("k k k k", "k k k k", below={1: (Loop(2, 1), Loop(2, 1), Loop(-2, 0), Loop(-2, 0))})
LACE = pattern("k k k k", "y d12k y d12k")
SHIFTING = pattern("k k y d21k k d12k y", "k k k k k k k", "y k k k k k k k", "d12k k k k k k k")


def restored(fabric: StitchMesh, *args, **kwargs) -> StitchMesh:
    """Apply a pattern and its inverse, and return the fabric."""
    inverses = []
    for change in lay_pattern(fabric, *args, **kwargs).changes:
        inverses.append(inverse_change(fabric, change))
        fabric = apply_change(fabric, change)
    for change in reversed(inverses):
        fabric = apply_change(fabric, change)
    return fabric


@cache
def garment(name: str) -> StitchMesh:
    """Return a garment of the assets with wide stitches."""
    return tessellate(label(read_mesh(ASSETS / f"{name}.obj")), stitch_width=1.6)


def narrowing_tube() -> StitchMesh:
    """Return a tube of plain stitches with four decreases of each slant."""
    return tessellate(label(coarse_tube(4, 1, radius=5.0, height=6.0, top_radius=3.8)), stitch_width=0.8)


def test_loops_that_no_tile_covers_stay_unchanged():
    assert codes(apply_pattern(tube(11, 3), PURL))[1:] == ["kkkpppppppp"] * 2
    assert codes(apply_pattern(flat(11, 3), PURL))[1:] == ["kppppppppkk"] * 2


def test_borders_lie_only_at_the_ends_of_flat_rows():
    bordered = pattern("p k p p", left=1, right=1)
    assert codes(apply_pattern(flat(8, 2), bordered))[1] == "pkpkpkpp"
    assert codes(apply_pattern(tube(8, 2), bordered))[1] == "kpkpkpkp"


def test_stretched_tiles_cover_all_loops():
    assert codes(apply_pattern(tube(10, 2), RIB, remainder="stretch"))[1] == "kkpppkkppp"
    assert codes(apply_pattern(flat(7, 2), RIB, remainder="stretch"))[1] == "kkpkkpp"


def test_the_message_for_a_refused_remainder_suggests_loop_counts():
    with pytest.raises(ParameterError, match=r"row 0 \(face 0\): got 10 loops for pattern 'tried'; .* 8 or 12"):
        apply_pattern(tube(10, 3), RIB, remainder="refuse")
    with pytest.raises(ParameterError, match="grid at face 8: got 5 rows for the 2 of pattern 'tried'"):
        apply_pattern(tube(8, 6), LACE, face=9, remainder="refuse")


def test_applying_twice_changes_nothing_more():
    made = apply_pattern(tube(16, 6), CROSSED)
    assert lay_pattern(made, CROSSED).changes == ()


def test_a_pattern_of_one_yarn_keeps_the_yarns_of_the_fabric():
    base = tube(8, 3)
    striped = apply_change(base, Marks("yarn", np.arange(8, 16), np.full(8, 2)))
    assert "yarn" not in differing(apply_pattern(striped, RIB), striped)
    colours = Pattern("two", "", (Row((Cell(Stitch.KNIT, yarn=1), Cell(Stitch.KNIT))),))
    assert apply_pattern(striped, colours).yarn[8:].tolist() == [1, 0] * 8


@pytest.mark.parametrize("chosen", [RIB, CROSSED, LACE, SHIFTING])
@pytest.mark.parametrize("fabric", [flat(17, 10), tube(17, 10)], ids=["flat", "tube"])
def test_the_inverse_restores_every_array(chosen, fabric):
    assert differing(apply_pattern(fabric, chosen), fabric)
    assert differing(restored(fabric, chosen), fabric) == []


@pytest.mark.parametrize("chosen", [LACE, SHIFTING])
def test_new_faces_fit_in_the_place_of_plain_stitches(chosen):
    fabric = tube(22, 9)
    made = checked(apply_pattern(fabric, chosen))
    for row in (0, 8):
        loops = [side.n_top[side.row == row].sum() for side in (fabric, made)]
        assert loops[0] == loops[1] == 22
    assert [len(loop) for loop in made.boundary_loops] == [len(loop) for loop in fabric.boundary_loops]
    assert len(made.vertices) - len(made.edge_side) + made.face_count == 0  # Euler's number of a tube


def test_new_vertices_lie_on_the_old_course_lines():
    made = apply_pattern(tube(20, 9), SHIFTING)
    radius = 20.0 / (2.0 * np.pi)
    distance = np.linalg.norm(made.vertices[:, :2], axis=1)
    rounding = 1e-12
    assert distance.max() <= radius + rounding
    assert distance.min() >= radius * np.cos(np.pi / 20.0) - rounding  # the chords of the old line
    assert np.allclose(made.vertices[:, 2], np.rint(made.vertices[:, 2]), atol=rounding)


def test_relaxed_stretch_is_unknown_at_new_edges_only():
    fabric = flat(8, 4)
    known = StitchMesh(**{
        **{name: getattr(fabric, name) for name in ("vertices", "face_start", "face_vertex", "twin", "n_bottom")},
        **{name: getattr(fabric, name) for name in ("n_top", "stitch", "row")},
        "stretch": np.ones(len(fabric.edge_side)),
    })  # fmt: skip
    made = apply_pattern(known, LACE)
    border = made.side_edge[made.twin == BORDER]
    assert (made.stretch[border] == 1.0).all()
    assert np.isnan(made.stretch).any()


def test_shaping_keeps_its_loops_and_becomes_knit_or_purl_as_the_pattern_is():
    fabric = narrowing_tube()
    left, right = (np.flatnonzero(fabric.stitch == stitch) for stitch in (Stitch.D21K, Stitch.D12K))
    assert len(left) and len(right)
    made = apply_pattern(fabric, pattern("p"))
    assert (made.stitch[left] == Stitch.D12P).all()
    assert (made.stitch[right] == Stitch.D21P).all()
    assert differing(apply_pattern(made, pattern("k")), fabric) == []


@pytest.mark.parametrize("name", NAMES)
def test_ribs_follow_the_wales_of_every_garment(name):
    fabric = garment(name)
    laid = lay_pattern(fabric, read_pattern("rib2x2"))
    made = checked(laid.fabric)
    outside = np.concatenate([np.zeros(0, dtype=np.int64), *(part.faces for part in laid.left_out)])
    below = np.setdiff1d(np.flatnonzero(plain_above(made) != BORDER), outside)
    assert (made.stitch[below] == made.stitch[plain_above(made)[below]]).all()
    purl = (made.stitch == Stitch.PURL).sum() / made.face_count
    assert 0.3 < purl < 0.7  # half of the stitches, except for cast-on rows, shaping, and ribs that shaping cuts


@pytest.mark.parametrize("name", NAMES)
def test_lace_fits_every_garment(name):
    fabric, lace = garment(name), read_pattern("openwork-trellis")
    made = checked(apply_pattern(fabric, lace))
    assert lay_pattern(fabric, lace).faces_laid > 0.1 * fabric.face_count  # tiles fit
    assert (made.n_top - made.n_bottom).sum() == (fabric.n_top - fabric.n_bottom).sum()
    assert differing(restored(fabric, lace), fabric) == []


@pytest.mark.parametrize("name", NAMES)
def test_cables_on_every_garment_are_whole(name):
    made = checked(apply_pattern(garment(name), read_pattern("rope-cable")))
    groups = cable_groups(made)
    assert groups
    assert {tuple(group.destination) for group in groups} == {(2, 3, 0, 1)}


@pytest.mark.parametrize("name", ["rope-cable", "braid-cables"])
def test_cables_have_purl_on_both_sides_beside_stitches_left_over(name):
    width = read_pattern(name).width
    laid = lay_pattern(tube(width + 2, 9), name)
    left_over = laid.reason >= 0
    assert left_over.sum() == 2 * 8
    right = right_neighbours(laid.fabric)
    beside = np.concatenate([right[left_over], np.flatnonzero(left_over[right])])
    assert (laid.fabric.stitch[beside[~left_over[beside]]] == Stitch.PURL).all()


def test_a_grid_around_a_face_ends_at_shaping():
    fabric = narrowing_tube()
    shaped = fabric.row[fabric.n_bottom > 1].min()
    start = int(np.flatnonzero(fabric.row == 1)[0])
    made = apply_pattern(fabric, pattern("p"), face=start)
    assert set(made.row[made.stitch == Stitch.PURL].tolist()) == set(range(1, shaped))


def test_the_grid_is_the_largest_rectangle():
    fabric = flat(9, 8)
    hole = [9 * 3 + 4]
    barred = apply_change(fabric, Marks("stitch", np.array(hole), np.array([Stitch.CAST_ON])))
    above = codes(apply_pattern(barred, pattern("p"), face=9 * 5 + 4))
    assert above == ["c" * 9, *["k" * 9] * 2, "kkkkckkkk", *["p" * 9] * 4]
    beside = codes(apply_pattern(barred, pattern("p"), face=9 * 3 + 3))
    assert beside == ["c" * 9, *["ppppkkkkk"] * 2, "ppppckkkk", *["ppppkkkkk"] * 4]


def test_stitches_of_a_crossing_that_does_not_fit_are_worked_without_the_crossing():
    fabric = flat(8, 4)
    barred = apply_change(fabric, Marks("stitch", np.array([8 * 2 + 1]), np.array([Stitch.CAST_ON])))
    made = apply_pattern(barred, CROSSED)
    assert [group.sides.tolist() for group in cable_groups(made)] == [[4 * face + 2 for face in (12, 13, 14, 15)]]


def test_nothing_crosses_from_one_turn_of_a_spiral_to_the_next():
    crossed = pattern("k k k k", below={0: CROSSED.rows[1].loops})
    made = apply_pattern(make_spiral(tube(9, 6)), crossed, face=9 * 3)
    groups = cable_groups(made)  # raises an error if a loop is moved off its row
    assert len(groups) == 8  # 8 of 11 crossings: the other three would begin in one turn and end in the next


@pytest.mark.parametrize("chosen", [RIB, LACE])
def test_old_crossings_are_removed_as_a_whole(chosen):
    crossed = apply_pattern(flat(8, 5), CROSSED)
    assert len(cable_groups(crossed)) == 4
    made = apply_pattern(crossed, chosen, face=8 * 2 + 1)
    assert cable_groups(made) == []
    assert differing(restored(crossed, chosen, face=8 * 2 + 1), crossed) == []


def test_a_half_turn_goes_with_the_stitch_through_the_back_leg_that_gave_it():
    """The loops below plain stitches in the place of twisted ones stayed twisted, and those above lost their turn."""
    fabric = flat(8, 7)
    twisted = apply_pattern(fabric, "twisted-rib")
    assert twisted.twist.any()
    assert differing(apply_pattern(twisted, pattern("k k")), fabric) == []
    made = apply_pattern(twisted, pattern("k k"), faces=np.flatnonzero((twisted.row >= 2) & (twisted.row <= 4)))
    below_plain = np.isin(twisted.row[twisted.side_face], [1, 2, 3])
    np.testing.assert_array_equal(made.twist, np.where(below_plain, 0, twisted.twist))


def test_lace_on_a_small_grid_leaves_the_other_stitches_unchanged():
    fabric = apply_pattern(tube(16, 8), pattern("p", "p", "k", "k", "k", "k", "k"))
    laid = lay_pattern(fabric, LACE, face=16 * 3)
    assert sum(isinstance(change, Patch) for change in laid.changes) == 1
    assert laid.faces_laid == 16 * 7
    assert laid.left_out == ()


def test_a_stitch_that_is_not_plain_does_not_move_the_columns_beside_it():
    barred = apply_change(flat(11, 4), Marks("stitch", np.array([2 * 11 + 3]), np.array([Stitch.CAST_ON])))
    made = apply_pattern(barred, LACE)
    lace = np.flatnonzero(made.n_bottom != made.n_top)
    places = made.corner_position[made.sides_of(lace), 0]
    assert (places.min(), places.max()) == (1.0, 9.0)  # the columns of a row without the barred stitch
    assert len(lace) == 2 * 3  # of four pairs of a yarn-over and a decrease, the barred stitch takes one


@pytest.mark.parametrize(
    ("chosen", "face", "message"),
    [
        (RIB, 999, "face 999: does not exist; the mesh has faces 0 to 39"),
        (RIB, 3, "face 3: is cast-on .* plain stitch such as knit"),
        (pattern("k " * 9), 12, "grid at face 8: got 8 columns; pattern 'tried' needs at least 9"),
        (pattern("k " * 9), None, "pattern 'tried': its 9 columns are more than any first row"),
        (pattern("y " * 9 + "d12k " * 9, "p " * 18), None, "its 18 columns are more than any first row"),
    ],
)
def test_patterns_that_do_not_fit_are_refused(chosen, face, message):
    with pytest.raises(ParameterError, match=message):
        apply_pattern(flat(8, 5), chosen, face=face)


def test_a_pattern_that_does_not_close_is_refused():
    with pytest.raises(PatternError, match="row 1: its tile leaves 3 loops, but row 1 is worked on 2"):
        apply_pattern(flat(8, 5), pattern("k y k"))


def test_an_unknown_remainder_is_refused():
    with pytest.raises(ParameterError, match="remainder 'crop': is unknown; expected one of centre, stretch, refuse"):
        apply_pattern(flat(8, 5), RIB, remainder="crop")


def test_panels_are_refused():
    with pytest.raises(ParameterError, match="face 0: is a panel of a coarse mesh"):
        apply_pattern(label(coarse_tube(4, 1)), RIB)
