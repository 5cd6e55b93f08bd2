# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fabrics of several yarns: stripes, stranded colourwork with floats, and blocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.spiral import make_spiral
from stitchmesh.labeling import label
from stitchmesh.linking.certificate import linking_certificate
from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import parse_pattern
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.floats_and_tails import LANE_SHARES
from stitchmesh.yarngen.generate import YarnRoutes, trace_yarn_routes
from tests.gallery import grid, tube

pytestmark = pytest.mark.decides

Rule = Callable[[int, int], int]
"""Yarn of a stitch, from its row and its position in the row."""
ROUND = tessellate(label(tube(8, 2, radius=2.0, height=1.2)), stitch_width=0.6)
FLAT = tessellate(label(grid(1, 1, width=5.0, height=3.2)), stitch_width=0.5)


def with_yarns(fabric: StitchMesh, rule: Rule) -> StitchMesh:
    yarn = np.zeros(fabric.face_count, dtype=int)
    for course in find_courses(fabric):
        for place, face in enumerate(course.faces):
            yarn[face] = rule(int(fabric.row[face]), place)
    return replace(fabric, yarn=yarn)


FABRICS = {
    "stripes around": with_yarns(ROUND, lambda row, _: row // 2 % 2),
    "stripes to and fro": with_yarns(FLAT, lambda row, _: row // 2 % 2),
    "stripes in a spiral": with_yarns(make_spiral(ROUND), lambda row, _: row // 2 % 2),
    "pairs around": with_yarns(ROUND, lambda row, place: (place // 2 + row) % 2),
    "pairs to and fro": with_yarns(FLAT, lambda row, place: (row + place) // 2 % 2),
    "pairs in a spiral": with_yarns(make_spiral(ROUND), lambda row, place: place // 2 % 2),
    "a motif": with_yarns(FLAT, lambda row, place: int(row > 0 and 3 <= place <= 6)),
    "one stitch": with_yarns(ROUND, lambda row, place: int((row, place) == (2, 3))),
    "three yarns": with_yarns(FLAT, lambda row, place: place // 2 % 3),
}


def linking_numbers(yarns: YarnSet) -> np.ndarray:
    return linking_certificate(yarns, device="cpu").toarray()


@pytest.mark.parametrize("name", FABRICS)
def test_a_yarn_visits_the_stitches_of_its_number_and_no_others_and_starts_apart_from_them(name):
    fabric = FABRICS[name]
    yarns = generate_yarns(fabric, quality="draft")
    # touching yarns are two radii apart; the smallest distance is at the last stitch of a spiral, whose yarn differs
    # from that of the bind-off beside it
    least = {"pairs in a spiral": 0.4, "three yarns": 0.5}.get(name, 0.75)
    assert smallest_distance(yarns, within=2 * yarns.radius[0])[0] > least * yarns.radius[0]
    colour = yarns.colour[yarns.point_yarn]
    # the feet of a stitch belong to its own row, its heads to the row below; a bind-off row has one yarn
    own = yarns.row == fabric.row[yarns.face]
    np.testing.assert_array_equal(colour[own], fabric.yarn[yarns.face[own]])
    assert set(yarns.face[own]) == set(range(fabric.face_count))
    assert set(yarns.colour) == set(fabric.yarn)


@pytest.mark.parametrize("name", ["stripes to and fro", "stripes in a spiral"])
def test_each_stripe_is_a_yarn_with_tails_on_the_wrong_side(name):
    fabric = FABRICS[name]
    yarns = generate_yarns(fabric, quality="draft")
    rows = int(fabric.row.max()) + 1
    # the bind-off continues in the yarn of the last stripe
    assert yarns.yarn_count == -(-rows // 2) and not yarns.closed.any()
    ends = np.concatenate([yarns.start[:-1], yarns.start[1:] - 1])
    centre = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1]) / np.diff(fabric.face_start)[:, None]
    face = yarns.face[ends]
    height = np.einsum("nd,nd->n", yarns.points[ends] - centre[face], fabric.face_vector_area[face])
    assert (height < 0.0).all()


def test_each_yarn_of_stranded_rounds_is_a_ring():
    yarns = generate_yarns(FABRICS["pairs around"], quality="draft")
    rows = int(ROUND.row.max()) + 1
    assert yarns.closed.all() and yarns.yarn_count == 2 * rows + 1
    for yarn in range(yarns.yarn_count):
        own = slice(yarns.start[yarn], yarns.start[yarn + 1])
        assert len(set(yarns.row[own])) == 1


def test_yarns_of_one_round_are_not_linked_with_each_other():
    yarns = generate_yarns(FABRICS["pairs around"], quality="draft")
    row = yarns.row[yarns.start[:-1]]
    numbers = linking_numbers(yarns)
    for first, second in np.argwhere(np.triu(row[:, None] == row, 1)):
        assert numbers[first, second] == 0


def test_stranded_rows_to_and_fro_are_one_yarn_each():
    for name, count in (("pairs to and fro", 2), ("a motif", 2), ("three yarns", 3)):
        yarns = generate_yarns(FABRICS[name], quality="draft")
        assert yarns.yarn_count == count and not yarns.closed.any()
        assert sorted(yarns.colour) == list(range(count))


def floats_within(routes: YarnRoutes) -> list[tuple[int, FloatArray]]:
    """The stitch at the left end of each float within a row, and the points of the float behind other stitches [cm]."""
    whole, found = routes.whole, []
    for crossing, path in routes.bridges.paths.items():
        sides = np.array([crossing, path.to]) // SLOTS
        rows = whole.row[whole.side_face[sides]]
        if whole.side_role[sides[0]] == 1 and rows[0] == rows[1] and (whole.twin[sides] != BORDER).all():
            # the first and the last point lie on the wale sides
            found.append((int(whole.side_face[sides[0]]), path.points[1:-1]))
    assert found
    return found


def test_floats_lie_behind_every_stitch_that_they_pass():
    radius = 0.06
    routes = trace_yarn_routes(FABRICS["pairs to and fro"], radius, 24)
    knit = np.repeat(routes.whole.stitch[routes.parts.face] == Stitch.KNIT, np.diff(routes.parts.start))
    deepest = routes.parts.points[knit, 2].min()
    for face, points in floats_within(routes):
        if routes.whole.stitch[face] != Stitch.KNIT:
            continue  # cast-on loops have a smaller depth
        # 2.2 radii behind the deepest point of the yarn, which the sampled points do not reach exactly
        assert -2.3 * radius < points[:, 2].max() - deepest < -2.0 * radius


def test_the_yarn_of_the_lower_number_floats_in_the_lower_lane():
    routes = trace_yarn_routes(with_yarns(FLAT, lambda row, place: place // 2 % 2), 0.06, 12)
    whole = routes.whole
    base = whole.vertices[whole.face_vertex[whole.face_start[:-1]], 1]
    for face, points in floats_within(routes):
        lane = (points[:, 1] - base[face]) / whole.side_length[whole.right_wale[face]]
        np.testing.assert_allclose(lane, LANE_SHARES[whole.yarn[face]], atol=1e-9)  # rounding


@pytest.mark.parametrize(("chart", "distance"), [
    (("012", "120"), 1.5), (("0213", "1032", "3120"), 1.3), (("01234", "12340"), 0.95), (("012345", "123450"), 0.75),
])  # fmt: skip
def test_yarns_of_a_row_start_apart_however_many_they_are(chart, distance):
    """Lanes of six yarns are a sixth of a course apart: 1.05 radii, and less where a yarn passes between two lanes."""
    pattern = parse_pattern("\n".join(["chart colours:", *chart]))
    fabric = torus_mesh(pattern, stitch_width=8 * 0.125, stitch_height=0.77 * 8 * 0.125)
    yarns = generate_yarns(fabric, yarn_radius=0.125, quality="standard", finish=YarnFinish(longest_float=7))
    assert smallest_distance(yarns, 2 * 0.125)[0] > distance * 0.125


def test_a_yarn_is_cut_where_it_would_float_too_far():
    blocks = with_yarns(FLAT, lambda row, place: int(3 <= place <= 6))
    carried = generate_yarns(blocks, quality="draft", finish=YarnFinish(longest_float=4))
    cut = generate_yarns(blocks, quality="draft", finish=YarnFinish(longest_float=2))
    assert carried.yarn_count == 2
    # the block is three stitches from the row ends, so its yarn is not carried to them: each of its rows is one yarn
    assert (cut.colour == 1).sum() == (FLAT.row.max() + 1)
    assert not cut.closed.any() and cut.yarn_count > carried.yarn_count


def test_no_floats_are_laid_where_none_are_allowed():
    routes = trace_yarn_routes(FABRICS["pairs around"], 0.07, 12)
    assert routes.bridges.paths
    yarns = generate_yarns(FABRICS["pairs around"], quality="draft", finish=YarnFinish(longest_float=0))
    changes = (FABRICS["pairs around"].yarn != 0).sum() // 2
    # every pair of stitches is a yarn of its own, and the bind-off is a ring
    assert yarns.yarn_count == 2 * changes + 1 and yarns.closed.sum() == 1


def test_a_bind_off_row_is_of_one_yarn():
    routes = trace_yarn_routes(FABRICS["pairs around"], 0.07, 12)
    assert len(set(routes.whole.yarn[ROUND.face_count :])) == 1
