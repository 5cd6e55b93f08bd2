# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cables: which loops cross, where they are worked, which loop lies in front, and the distances between their legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import LabelError
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups, course_line
from stitchmesh.mesh.courses import find_courses, top_sides
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.bridges import crossing_number
from stitchmesh.yarngen.cables import REST_LENGTH_RATIO, open_corners
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.generate import trace_yarn_routes
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from tests.gallery import tube
from tests.nightly import at_night
from tests.yarngen.samplers import sampler

pytestmark = pytest.mark.decides

RADIUS = 0.125
"""Yarn radius, for stitches of width one."""
K, P = Stitch.KNIT, Stitch.PURL


def turned(left: int, right: int, front: str = "left") -> tuple[list[int], list[int]]:
    """Destinations and layers of a cable in which ``left`` loops on the left cross ``right`` loops on the right."""
    in_front = front == "left"
    return [*range(right, left + right), *range(right)], [int(in_front)] * left + [int(not in_front)] * right


CROSSINGS = {
    "1 and 1": turned(1, 1),
    "1 and 3": turned(1, 3),
    "2 and 2": turned(2, 2, "right"),
    "4 and 4": turned(4, 4),
    "three strands": ([4, 5, 2, 3, 0, 1], [2, 2, 1, 1, 0, 0]),
    "over a middle": ([3, 2, 1, 0], [3, 1, 2, 0]),
}


def crossed(fabric: StitchMesh, row: int, column: int, crossing: tuple[list[int], list[int]]) -> StitchMesh:
    """A flat piece with one more group of crossing loops, which begins at the given stitch of the given row."""
    destination, layer = crossing
    side = line_of(fabric, row)[column : column + len(destination)]
    shifts, layers = fabric.cable_shift.copy(), fabric.cable_layer.copy()
    shifts[side], layers[side] = np.array(destination) - np.arange(len(destination)), layer
    return replace(fabric, cable_shift=shifts, cable_layer=layers)


def line_of(fabric: StitchMesh, row: int) -> np.ndarray:
    return np.array(next(top_sides(fabric, c.faces) for c in find_courses(fabric) if fabric.row[c.faces[0]] == row))


def plain(columns: int, rows: int, *, purled: int = 0) -> StitchMesh:
    """Knit rows above a cast-on, with some purl stitches at both ends."""
    return sampler([[P] * purled + [K] * (columns - 2 * purled) + [P] * purled] * rows)


def mixed(columns: int, rows: int) -> StitchMesh:
    rng = np.random.default_rng(7)
    return sampler([[K if knit else P for knit in rng.random(columns) < 0.5] for _ in range(rows)])


def places_worked(fabric: StitchMesh, yarns: YarnSet, row: int) -> set[tuple[int, int]]:
    """Position of each loop in its row and position of the stitch above that works it, as the yarn runs."""
    faces, above = fabric.side_face[line_of(fabric, row)].tolist(), fabric.side_face[line_of(fabric, row + 1)].tolist()
    found = set()
    for one, other in zip(yarns.face[:-1].tolist(), yarns.face[1:].tolist(), strict=True):
        for below, over in ((one, other), (other, one)):
            if below in faces and over in above:
                found.add((faces.index(below), above.index(over)))
    return found


@pytest.mark.parametrize("crossing", CROSSINGS.values(), ids=CROSSINGS)
def test_loops_are_worked_where_they_are_moved_to(crossing):
    fabric = crossed(plain(10, 4), 2, 1, crossing)
    expected = {(1 + place, 1 + to) for place, to in enumerate(crossing[0])}
    expected |= {(place, place) for place in range(10) if place not in range(1, 1 + len(crossing[0]))}
    assert places_worked(fabric, generate_yarns(fabric, yarn_radius=RADIUS), 2) == expected


@pytest.mark.parametrize("crossing", CROSSINGS.values(), ids=CROSSINGS)
def test_a_crossing_loop_of_a_higher_layer_lies_in_front(crossing):
    """By nearly a diameter wherever legs cross, also where they have not quite reached the height of their layers."""
    destination, layer = crossing
    fabric = crossed(plain(10, 4), 2, 1, crossing)
    bridges = trace_yarn_routes(fabric, RADIUS, 400).bridges  # so dense that legs are nearly straight
    sides = line_of(fabric, 2)[1 : 1 + len(layer)]
    legs = [[bridges.paths[crossing_number(side, slot)].points for slot in (0, 1)] for side in sides]
    for one in range(len(layer)):
        for other in range(one + 1, len(layer)):
            if destination[one] < destination[other]:
                continue
            above = np.sign(layer[one] - layer[other])
            for a in legs[one]:
                for b in legs[other]:
                    assert above * height_between(a, b) > 1.8 * RADIUS


def height_between(a: np.ndarray, b: np.ndarray) -> float:
    """Distance by which one curve lies in front of another where they cross; both run from bottom to top."""
    y = np.linspace(max(a[0, 1], b[0, 1]), min(a[-1, 1], b[-1, 1]), 2001)
    (ax, az), (bx, bz) = (np.stack([np.interp(y, c[:, 1], c[:, k]) for k in (0, 2)]) for c in (a, b))
    crossing = int(np.argmin(np.abs(ax - bx)))
    return float(az[crossing] - bz[crossing])


@pytest.mark.parametrize("quality", ["draft", *at_night("standard", "reference")])
@pytest.mark.parametrize("crossing", CROSSINGS.values(), ids=CROSSINGS)
def test_crossings_start_at_least_two_thirds_of_a_radius_apart_and_neighbouring_ones_half_a_radius(crossing, quality):
    """Touching yarns are two radii apart. The ground is knit and purl."""
    width = len(crossing[0])
    one, several = crossed(mixed(10, 4), 2, 1, crossing), mixed(2 * width + 1, 6)
    for row, column in ((1, 0), (2, width // 2), (4, 0), (4, width)):
        several = crossed(several, row, column, crossing)
    for fabric, least in ((one, 2 / 3), (several, 0.5)):
        distance, point = smallest_distance(generate_yarns(fabric, yarn_radius=RADIUS, quality=quality), 2 * RADIUS)
        assert distance > least * RADIUS, f"near control point {point}"


def test_a_crossing_neither_cuts_nor_joins_yarns():
    flat = crossed(crossed(plain(8, 5), 1, 2, turned(2, 2)), 3, 0, turned(3, 1))
    assert generate_yarns(flat).yarn_count == 1
    around = tessellate(label(tube(8, 3)), stitch_width=0.5)
    yarns = generate_yarns(crossed(around, 2, 3, turned(2, 2)))
    assert yarns.closed.all() and yarns.yarn_count == generate_yarns(around).yarn_count


def test_loops_of_the_last_row_cross_below_the_bind_off():
    fabric = crossed(plain(6, 3), 3, 1, turned(2, 2))
    assert (fabric.twin[cable_groups(fabric)[0].sides] == -1).all()
    for bind_off in ("drawn", "chain"):
        assert generate_yarns(fabric, yarn_radius=RADIUS, finish=YarnFinish(bind_off=bind_off)).yarn_count == 1


def test_twisted_loops_cross():
    fabric = crossed(plain(8, 4), 2, 2, turned(2, 2))
    twist = fabric.twist.copy()
    twist[line_of(fabric, 2)[2:6]] = [1, -1, 1, 1]
    yarns = generate_yarns(replace(fabric, twist=twist), yarn_radius=RADIUS)
    assert {(2, 4), (3, 5), (4, 2), (5, 3)} <= places_worked(fabric, yarns, 2)


def test_around_a_tube_a_cable_may_lie_anywhere():
    """A cable across the end of the course line has the same yarn as any other cable, rotated about the tube."""
    fabric = tessellate(label(tube(8, 3)), stitch_width=0.5)
    line = line_of(fabric, 2)
    here, there = crossed(fabric, 2, 0, turned(2, 2)), rolled(crossed(fabric, 2, 0, turned(2, 2)), line, -2)
    group = cable_groups(there)[0]
    assert group.sides.tolist() == [line[-2], line[-1], line[0], line[1]]
    assert group.destination.tolist() == [2, 3, 0, 1]
    lengths = [np.sort(generate_yarns(each).lengths) for each in (here, there)]
    # the stitches of a tessellated octagon differ a little
    np.testing.assert_allclose(lengths[0].sum(), lengths[1].sum(), rtol=1e-3)


def rolled(fabric: StitchMesh, line: np.ndarray, places: int) -> StitchMesh:
    """The fabric with the marks of a course line moved along the line."""
    shifts, layers = fabric.cable_shift.copy(), fabric.cable_layer.copy()
    shifts[line], layers[line] = np.roll(shifts[line], places), np.roll(layers[line], places)
    return replace(fabric, cable_shift=shifts, cable_layer=layers)


def test_groups_are_the_smallest_ranges_that_no_loop_leaves():
    fabric = crossed(crossed(crossed(plain(9, 3), 1, 0, turned(1, 1)), 1, 2, turned(2, 1)), 1, 6, turned(1, 1))
    line = line_of(fabric, 1)
    groups = cable_groups(fabric)
    assert [group.sides.tolist() for group in groups] == [line[:2].tolist(), line[2:5].tolist(), line[6:8].tolist()]
    assert [group.destination.tolist() for group in groups] == [[1, 0], [1, 2, 0], [1, 0]]
    found, is_ring = course_line(fabric, int(line[4]))
    assert found.tolist() == line.tolist() and not is_ring


def test_rows_move_apart_only_within_a_group():
    """The vertices at the ends of the group stay, and faces that meet within the group move equally."""
    fabric = crossed(plain(8, 4), 2, 2, turned(2, 2))
    moved = (open_corners(fabric, cable_groups(fabric)) - fabric.corner_position)[:, 1]
    line = line_of(fabric, 2)[2:6]
    inner = set(fabric.face_vertex[line[:-1]].tolist())
    assert set(fabric.face_vertex[np.flatnonzero(moved)].tolist()) == inner
    below = np.isin(fabric.side_face, fabric.side_face[line])
    for vertex in inner:
        at = fabric.face_vertex == vertex
        assert len(np.unique(moved[at & below])) == len(np.unique(moved[at & ~below])) == 1
        assert (moved[at & below] < 0).all() and (moved[at & ~below] > 0).all()


def test_crossing_legs_have_shorter_rest_lengths_and_belong_to_their_loops():
    fabric = crossed(plain(8, 4), 2, 2, turned(2, 2))
    yarns = generate_yarns(fabric, yarn_radius=RADIUS)
    share = yarns.rest_length / yarns.lengths
    share[~np.isin(yarns.row[yarns.segment_points[:, 1]], (1, 2, 3))] = 1.0  # The edges have tension.
    assert share.min() == pytest.approx(REST_LENGTH_RATIO) and share.max() == pytest.approx(1.0)
    legs = yarns.segment_points[share < 1.0 - 1e-6, 1:3]
    loops = fabric.side_face[line_of(fabric, 2)[2:6]]
    # a segment at the end of a leg takes the mean of both ratios
    assert (np.isin(yarns.face[legs], loops).any(axis=1)).all() and (yarns.row[legs] == 2).all()


def test_a_loop_length_leaves_crossing_loops_longer_than_plain_ones():
    fabric = crossed(plain(8, 5), 2, 2, turned(2, 2))
    yarns = generate_yarns(fabric, yarn_radius=RADIUS)
    wanted = apply_rest_lengths(yarns, RestLengths(loop_length=4.0), fabric=fabric)
    face = fabric.side_face[line_of(fabric, 2)]
    held = [wanted.rest_length[yarns.face[yarns.segment_points[:, 1]] == each].sum() for each in face[1:5]]
    assert held[0] == pytest.approx(4.0) and min(held[1:]) > 4.5


@pytest.mark.parametrize(
    ("column", "shifts", "layers", "message"),
    [
        (4, [2, -2], [1, 0], r"cable_shift 2 leads off its row; it has 4 loops on the left and 1 on the right"),
        (0, [-1, 1], [1, 0], "cable_shift -1 leads off its row"),
        (1, [1, 1, -2, -1], [1, 1, 0, 0], r"leads to the place of the loop from side \d+ \(face \d+.*must not overlap"),
        (1, [1, -1], [1, 1], r"crosses the loop from side \d+ .* in the same cable_layer 1; give the one in front"),
    ],
)
def test_loops_that_cannot_cross_are_refused(column, shifts, layers, message):
    fabric = plain(6, 3)
    side = line_of(fabric, 2)[column : column + len(shifts)]
    all_shifts, all_layers = fabric.cable_shift.copy(), fabric.cable_layer.copy()
    all_shifts[side], all_layers[side] = shifts, layers
    with pytest.raises(LabelError, match=message) as error:
        generate_yarns(replace(fabric, cable_shift=all_shifts, cable_layer=all_layers))
    assert "\n" not in str(error.value)


def test_a_ring_of_crossings_must_leave_a_place():
    fabric = tessellate(label(tube(8, 3)), stitch_width=0.5)
    line = line_of(fabric, 2)
    shifts, layers = fabric.cable_shift.copy(), fabric.cable_layer.copy()
    shifts[line[0::2]], shifts[line[1::2]], layers[line[0::2]] = 2, -2, 1
    with pytest.raises(LabelError, match="cross all around the tube; leave two neighbouring stitches"):
        cable_groups(replace(fabric, cable_shift=shifts, cable_layer=layers))


def test_rows_that_meet_head_to_head_take_no_cable():
    fabric = tessellate(label(tube(8, 2), flip=[8]), stitch_width=1.0)
    side = int(np.flatnonzero(fabric.mismatched & (fabric.side_role == 2))[0])
    line, _ = course_line(fabric, side)
    shifts, layers = fabric.cable_shift.copy(), fabric.cable_layer.copy()
    shifts[line[:2]], layers[line[:2]] = [1, -1], [1, 0]
    with pytest.raises(LabelError, match="crosses others where the row above has the opposite wale direction"):
        cable_groups(replace(fabric, cable_shift=shifts, cable_layer=layers))


@pytest.mark.nightly
def test_a_relaxed_rope_keeps_its_front():
    """Two loops cross two others on a purl ground: the right ones lie in front, from lower right to upper left."""
    fabric = crossed(plain(8, 7, purled=2), 4, 2, turned(2, 2, "right"))
    yarns = generate_yarns(fabric, yarn_radius=RADIUS, quality="draft")
    material = YarnMaterial.named("stitchmesh").of_radius(RADIUS)
    relaxed = relax_yarns(yarns, material=material, quality="draft", device="cpu", keep_shape=fabric)
    assert relaxed.report["converged"] and relaxed.report["pull_throughs"] == 0
    is_leg = yarns.rest_length < (1.0 - 1e-6) * yarns.lengths
    face, points = yarns.face[yarns.segment_points[:, 1]], relaxed.yarns.points[yarns.segment_points].mean(axis=1)
    loops = fabric.side_face[line_of(fabric, 4)[2:6]]
    heights = [points[is_leg & (face == loop), 2].mean() for loop in loops]
    assert min(heights[2:]) > max(heights[:2]) + RADIUS
    for loop, leans in zip(loops, (1, 1, -1, -1), strict=True):
        leg = points[is_leg & (face == loop)]
        assert leans * np.cov(leg[:, 0], leg[:, 1])[0, 1] > 0.0
