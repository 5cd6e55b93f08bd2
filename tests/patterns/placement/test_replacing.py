# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns over patterns: the faces of a region are made anew, whatever stitches they hold."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.change import Patch, apply_change
from stitchmesh.mesh.renumbering import Renumbering
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import LaidPattern, apply_pattern, lay_pattern, pattern_names
from stitchmesh.patterns.placement.plain_ground import plain_ground
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import check_loops, generate_yarns
from tests.gallery import ROOT
from tests.nightly import mostly_at_night
from tests.patterns.fabrics import checked, codes, differing, flat, pattern, tube

NAMES = ("rib2x2", "twisted-rib", "linen-stitch", "rope-cable", "eyelet-lace", "feather-and-fan", "half-cardigan",
         "mrs-montagues")  # fmt: skip
"""Patterns of every kind: loops twisted, slipped, crossed, and tucks; units of one row and of two."""
PAIRS = tuple(zip(NAMES, (*NAMES[1:], NAMES[0]), strict=True))
"""Each pattern once below and once above."""


@cache
def fabric_of(name: str, width: float = 1.6) -> StitchMesh:
    """Return a flat piece or a garment of plain stitches of some width [cm]."""
    if name == "flat":
        return flat(38, 26)
    return tessellate(label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")), stitch_width=width)


@cache
def laid_on_plain(name: str, width: float, pattern: str) -> LaidPattern | None:
    """Return a garment with a pattern of the library on all of it; None where the pattern fits nowhere."""
    try:
        return lay_pattern(fabric_of(name, width), pattern)
    except StitchMeshError:
        return None


def share_of(laid: LaidPattern) -> float:
    """Return the part of the stitches that are in the pattern, of all that could be."""
    return laid.faces_laid / (laid.faces_laid + sum(len(part.faces) for part in laid.left_out))


def assert_undone(fabric: StitchMesh, laid: LaidPattern) -> None:
    """Check that the inverse changes restore every array."""
    edited = apply_changes(fabric, laid.changes)
    assert differing(edited.fabric, laid.fabric) == []
    assert differing(apply_changes(edited.fabric, edited.inverse).fabric, fabric) == []


def numbers_after(fabric: StitchMesh, laid: LaidPattern) -> np.ndarray:
    """Return the number of each face after the changes, -1 if it is removed, shape (F,)."""
    numbers = np.arange(fabric.face_count)
    for change in laid.changes:
        if isinstance(change, Patch):
            after = Renumbering.of(fabric.face_count, change.removed_faces, change.added_faces).after
            numbers = np.where(numbers < 0, -1, after[numbers])
        fabric = apply_change(fabric, change)
    return numbers


@pytest.mark.parametrize(("first", "second"), mostly_at_night(product(NAMES, NAMES), by_day=PAIRS))
def test_a_pattern_over_a_pattern_covers_what_it_covers_of_a_plain_piece(first, second):
    below = apply_pattern(fabric_of("flat"), first)
    laid = lay_pattern(below, second)
    cable_groups(checked(laid.fabric))
    assert laid.faces_laid == lay_pattern(fabric_of("flat"), second).faces_laid
    assert_undone(below, laid)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "width", "least"),
    # The shaping of the dress lies between the repeats of the first pattern, where more loops are left over.
    [("swatch", 0.8, 0.99), ("dress", 1.6, 0.93)],
)
@pytest.mark.parametrize("second", pattern_names())
def test_a_pattern_of_the_library_over_every_other_one(name, width, least, second):
    wanted = laid_on_plain(name, width, second)
    for first in pattern_names() if wanted is not None else ():
        below = laid_on_plain(name, width, first)
        if below is not None:
            laid = lay_pattern(below.fabric, second)
            cable_groups(checked(laid.fabric))
            borders = (sorted(map(len, each.boundary_loops)) for each in (laid.fabric, below.fabric))
            assert len({tuple(each) for each in borders}) == 1, first
            assert share_of(laid) > least * share_of(wanted), first
            assert_undone(below.fabric, laid)


@pytest.mark.parametrize("second", ["rope-cable", "eyelet-lace", "half-cardigan"])
def test_a_pattern_over_lace_and_shaping_of_a_garment(second):
    below = apply_pattern(fabric_of("hat"), "feather-and-fan")
    laid = lay_pattern(below, second)
    made = checked(laid.fabric)
    cable_groups(made)
    plain = lay_pattern(fabric_of("hat"), second)
    share = laid.faces_laid / made.face_count, plain.faces_laid / plain.fabric.face_count
    assert share[0] > share[1] - 0.02  # shaping may lie at other stitches of its rows than before the first pattern
    assert_undone(below, laid)


@pytest.mark.parametrize("first", NAMES)
def test_plain_stitches_over_a_pattern_leave_nothing_of_it(first):
    made = apply_pattern(apply_pattern(fabric_of("flat"), first), "stockinette")
    assert codes(made) == ["c" * 38, *["k" * 38] * 25]
    assert not made.cable_shift.any() and not made.twist.any()


def test_shaping_keeps_its_place_under_a_lace_that_is_replaced():
    hat = fabric_of("hat")
    shaping = plain_ground(apply_pattern(hat, "eyelet-lace"), np.ones(hat.face_count, dtype=bool))
    assert shaping is not None
    bare = apply_change(apply_pattern(hat, "eyelet-lace"), shaping.patch)
    for row in range(1, hat.row.max()):
        faces = [np.flatnonzero(fabric.row == row) for fabric in (hat, bare)]
        loops = [
            fabric.n_top[own].sum() - fabric.n_bottom[own].sum() for fabric, own in zip((hat, bare), faces, strict=True)
        ]
        assert loops[0] == loops[1]
        shaped = (bare.n_bottom[faces[1]] != bare.n_top[faces[1]]).sum()
        assert shaped <= abs(loops[1])  # no decrease beside an increase is left


@pytest.mark.parametrize("seed", range(4))
def test_a_ragged_region_leaves_the_faces_around_it_as_they_were(seed):
    random = np.random.default_rng(seed)
    fabric = apply_pattern(fabric_of("hat"), NAMES[random.integers(len(NAMES))])
    region = ragged_region(fabric, random, 260)
    laid = lay_pattern(fabric, NAMES[random.integers(4)], faces=region)
    made = checked(laid.fabric)
    cable_groups(made)
    around = np.setdiff1d(np.arange(fabric.face_count), region)
    after = numbers_after(fabric, laid)[around]
    assert (after >= 0).all()
    for name in ("stitch", "yarn", "row", "n_bottom", "n_top"):
        assert np.array_equal(getattr(made, name)[after], getattr(fabric, name)[around])
    assert_undone(fabric, laid)


def ragged_region(fabric: StitchMesh, random: np.random.Generator, size: int) -> np.ndarray:
    """Return faces that grow at random from one face."""
    inside, front = {int(random.integers(fabric.face_count))}, []
    front = list(inside)
    while front and len(inside) < size:
        face = front[random.integers(len(front))]
        across = fabric.twin[fabric.sides_of(np.array([face]))]
        free = [int(other) for other in fabric.side_face[across[across != BORDER]] if int(other) not in inside]
        if free:
            inside.add(free[0])
            front.append(free[0])
        else:
            front.remove(face)
    return np.array(sorted(inside))


def test_a_cable_that_the_border_of_a_region_cuts_is_removed_as_a_whole():
    crossed = apply_pattern(flat(12, 9), "rope-cable")
    sides = cable_groups(crossed)[0].sides
    above = crossed.side_face[crossed.twin[sides]]
    laid = lay_pattern(crossed, pattern("p"), faces=[int(above[0])])
    assert len(cable_groups(laid.fabric)) == len(cable_groups(crossed)) - 1
    assert_undone(crossed, laid)


def test_a_yarn_over_without_its_decrease_becomes_an_increase():
    lace = apply_pattern(tube(8, 4), pattern("k k k k", "y d12k k k"))
    over = int(np.flatnonzero(lace.stitch == Stitch.YARN_OVER)[0])
    right = int(lace.side_face[lace.twin[lace.left_wale[over]]])
    laid = lay_pattern(lace, pattern("p"), faces=[right, over])
    made = checked(laid.fabric)
    assert (made.stitch == Stitch.PY).sum() + (made.stitch == Stitch.YP).sum() == 1
    assert (made.stitch == Stitch.D12K).sum() == 2  # the decrease lies outside the region
    assert_undone(lace, laid)


def test_an_edit_replaces_the_stitches_of_a_region():
    lace = apply_pattern(tube(16, 9), "eyelet-lace")
    faces = np.flatnonzero((lace.row >= 2) & (lace.row <= 6)).tolist()
    edited = apply_edit(lace, Edit("paste_pattern", {"pattern": "rib2x2", "faces": faces}))
    rows = np.isin(edited.fabric.row, range(2, 7))
    assert set(edited.fabric.stitch[rows].tolist()) == {int(Stitch.KNIT), int(Stitch.PURL)}
    assert differing(apply_changes(edited.fabric, edited.inverse).fabric, lace) == []


@pytest.mark.decides
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("feather-and-fan", "rope-cable"),
        ("rope-cable", "eyelet-lace"),
        ("half-cardigan", "feather-and-fan"),
        ("eyelet-lace", "rib2x2"),
    ],
)
def test_loops_of_a_pattern_over_a_pattern_are_held_as_their_stitches_define(first, second):
    made = apply_pattern(apply_pattern(flat(24, 12), first), second)
    check_loops(made, generate_yarns(made, quality="draft"))
