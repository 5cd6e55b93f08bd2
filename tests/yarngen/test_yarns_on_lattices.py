# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of periodic fabrics: lattice images across cables, floats and cuts, and distances between images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Cell, Loop, Pattern, Row, read_pattern
from stitchmesh.patterns.swatch_mesh import plain_piece
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.yarn import YarnSet, segment_points
from stitchmesh.yarngen import embedding, generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarngen.loop_check.unrolled_loops import supercell
from stitchmesh.yarngen.splines import control_points_through
from tests.chosen_patterns import CHOSEN_PATTERNS

pytestmark = pytest.mark.decides

WIDTH, HEIGHT, RADIUS = 0.5, 0.4, 0.0625
KNITTED = [Stitch.KNIT, Stitch.PURL]
CROSSED = (Loop(2), Loop(2), Loop(-2, 1), Loop(-2, 1))


def torus(*rows: Row) -> StitchMesh:
    return torus_mesh(Pattern("made", "test", rows), stitch_width=WIDTH, stitch_height=HEIGHT)


def plain_row(yarns: str, loops: tuple[Loop, ...] = ()) -> Row:
    return Row(tuple(Cell(KNITTED[place % 2], yarn=int(yarn)) for place, yarn in enumerate(yarns)), loops)


def moved(fabric: StitchMesh, columns: int, rows: int) -> StitchMesh:
    """The marks of a torus of plain stitches, moved to the right and up: the same fabric, seen in another cell."""
    height = int(fabric.row.max()) + 1

    def roll(values: np.ndarray, sides: int) -> np.ndarray:
        return np.roll(values.reshape(height, -1, sides), (rows, columns), axis=(0, 1)).ravel()

    per_face = {name: roll(getattr(fabric, name), 1) for name in ("stitch", "yarn")}
    per_side = {name: roll(getattr(fabric, name), 4) for name in ("twist", "cable_shift", "cable_layer")}
    return replace(fabric, **per_face, **per_side)


def in_cell(yarns: YarnSet, shift: np.ndarray) -> np.ndarray:
    """Control points modulo the lattice, moved back and sorted [cm].

    The border of the cell is shifted a little, because control points may lie on it.
    """
    assert yarns.lattice is not None
    size = np.array([yarns.lattice.periods[0, 0], yarns.lattice.periods[1, 1], np.inf])
    points = np.where(np.isinf(size), yarns.points, np.mod(yarns.points - shift + 1e-6, size)).round(7)
    return points[np.lexsort(points.T)]


FABRICS = {
    "a cable": torus(plain_row("000000"), plain_row("000000", (*CROSSED, Loop(), Loop()))),
    "a cable in a single row": torus(plain_row("000000", (*CROSSED, Loop(), Loop()))),
    "a wide cable": torus(plain_row("00000", (*[Loop(2)] * 3, *[Loop(-3, 1)] * 2))),
    "two yarns": torus(plain_row("001011"), plain_row("110000")),
    "three yarns": torus(plain_row("000121")),
    "one stitch of a yarn": torus(plain_row("00100")),
    "twisted loops": torus(plain_row("000", (Loop(), Loop(twist=-1), Loop()))),
}


@pytest.mark.parametrize("name", FABRICS)
def test_yarn_across_the_border_of_the_cell_is_generated_as_inside(name):
    fabric = FABRICS[name]
    yarns = generate_yarns(fabric, yarn_radius=RADIUS)
    assert fabric.lattice is not None
    for columns, rows in ((2, 0), (4, 1)):
        again = generate_yarns(moved(fabric, columns, rows), yarn_radius=RADIUS)
        shift = np.array([columns * WIDTH, rows * HEIGHT, 0.0])
        # rounding, and the remaining error of the iteration for control points
        np.testing.assert_allclose(in_cell(again, shift), in_cell(yarns, np.zeros(3)), atol=2e-7)
        assert sorted(map(tuple, np.abs(again.lattice_step))) == [(1, 0)] * yarns.yarn_count


def test_a_cable_across_the_border_of_the_cell_has_the_images_of_its_loops():
    (group,) = cable_groups(moved(FABRICS["a cable"], 4, 0))
    np.testing.assert_array_equal(group.image, [[0, 0], [0, 0], [1, 0], [1, 0]])
    (within,) = cable_groups(FABRICS["a cable"])
    np.testing.assert_array_equal(within.image, np.zeros((4, 2)))


def test_a_float_longer_than_allowed_is_cut_on_a_torus_too():
    fabric = FABRICS["one stitch of a yarn"]
    carried = generate_yarns(fabric, yarn_radius=RADIUS, finish=YarnFinish(longest_float=4))
    cut = generate_yarns(fabric, yarn_radius=RADIUS, finish=YarnFinish(longest_float=3))
    assert carried.closed.all()
    assert cut.closed[cut.colour == 1].tolist() == [False] and cut.closed[cut.colour == 0].all()
    # an open yarn has no lattice step
    np.testing.assert_array_equal(cut.lattice_step[cut.colour == 1], [[0, 0]])


def straight(direction: np.ndarray, lattice: Lattice, step: tuple[int, int]) -> YarnSet:
    """A straight yarn from the origin to its image."""
    points = np.arange(8)[:, None] / 8 * direction
    return YarnSet(
        points=points, start=np.array([0, 8]), closed=np.array([True]), radius=np.array([0.1]),
        rest_length=np.ones(8), row=np.zeros(8), face=np.zeros(8), part=np.zeros(8),
        lattice=lattice, lattice_step=np.array([step]),
    )  # fmt: skip


@pytest.mark.parametrize("step", [(1, 0), (2, 1)])
def test_a_straight_yarn_is_as_far_from_its_images_as_the_lattice_says(step):
    lattice = Lattice(np.array([[1.0, 0.0, 0.0], [0.3, 0.25, 0.0]]))
    along = lattice.shift(np.array(step))
    length = float(np.linalg.norm(along))
    # the distance between a lattice line and its images is the area of the cell over the length of the lattice vector
    beside = 0.25 / length
    # segments whose numbers differ by three may touch: two segments and a quarter lie between their nearest samples
    further_on = 9 / 32 * length
    found, _ = smallest_distance(straight(along, lattice, step), within=1.0)
    # samples are a 32nd of the length apart
    assert min(beside, further_on) - 1e-12 < found < min(np.hypot(beside, length / 64), further_on) + 1e-12


def test_splines_pass_through_their_points_in_every_image():
    step = np.array([[0.7, 0.1, 0.0]])
    points = np.random.default_rng(3).normal(size=(7, 3))
    start, closed = np.array([0, 7]), np.array([True])
    control = control_points_through(points, start, closed, step)
    before, after = np.roll(control, 1, axis=0), np.roll(control, -1, axis=0)
    before[0] -= step[0]
    after[-1] += step[0]
    np.testing.assert_allclose((before + 4 * control + after) / 6, points, atol=1e-14)  # rounding of numbers near 1
    assert len(segment_points(start, closed)) == 7


def test_a_fabric_on_a_lattice_must_close():
    piece = plain_piece(3, 3, WIDTH, HEIGHT)
    lattice = Lattice(np.array([[1.5, 0.0, 0.0], [0.0, 1.2, 0.0]]))
    open_piece = replace(piece, lattice=lattice, corner_image=np.zeros((piece.side_count, 2)))
    assert (open_piece.twin == BORDER).any()
    with pytest.raises(YarnError, match=r"side 0 .*: is a border of a fabric on a lattice"):
        generate_yarns(open_piece)


@pytest.mark.parametrize("name", FABRICS)
def test_loops_on_a_lattice_are_linked_as_defined(name: str) -> None:
    check_loops(FABRICS[name], generate_yarns(FABRICS[name], quality="draft"))


@pytest.mark.parametrize("pattern", CHOSEN_PATTERNS)
def test_loops_of_a_pattern_are_linked_as_defined(pattern: str) -> None:
    fabric = torus_mesh(read_pattern(pattern), stitch_width=WIDTH, stitch_height=HEIGHT)
    check_loops(fabric, generate_yarns(fabric, quality="draft"))


def test_a_stitch_with_the_template_of_another_is_caught_on_a_lattice(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cell has a single stitch, so all its neighbours are its own images."""
    fabric = torus(Row((Cell(Stitch.KNIT),)))
    right = embedding.template
    monkeypatch.setattr(embedding, "template", lambda _, *sides: right(Stitch.PURL, *sides))
    with pytest.raises(YarnError, match=r"face 0: .* passes (-?1) times through loop 1 of face 0, expected (?!\1)-?1"):
        check_loops(fabric, generate_yarns(fabric, quality="draft"))


def test_a_larger_cell_is_the_same_fabric() -> None:
    fabric = FABRICS["a cable"]
    larger = supercell(fabric, 3, 2)
    assert larger.face_count == 6 * fabric.face_count
    assert larger.lattice is not None
    np.testing.assert_allclose(larger.lattice.area, 6 * fabric.lattice.area, rtol=1e-12)
    yarns, many = generate_yarns(fabric, quality="draft"), generate_yarns(larger, quality="draft")
    size = np.array([fabric.lattice.periods[0, 0], fabric.lattice.periods[1, 1], np.inf])
    one = np.round(np.mod(yarns.points[:, :2] + 1e-6, size[:2]), 6)
    all_of_them = np.round(np.mod(many.points[:, :2] + 1e-6, size[:2]), 6)
    np.testing.assert_allclose(np.sort(np.repeat(one, 6, axis=0), axis=0), np.sort(all_of_them, axis=0), atol=2e-6)


def test_images_that_come_near_are_all_found():
    lattice = Lattice(np.array([[0.5, 0.0, 0.0], [0.2, 0.3, 0.0]]))
    points = np.random.default_rng(1).uniform(size=(40, 3)) * [1.0, 0.8, 0.3]
    near = {tuple(image) for image in lattice.near_images(points, 0.2).tolist()}
    for a in range(-4, 5):
        for b in range(-4, 5):
            gaps = points[:, None] - points - lattice.shift((a, b))
            assert np.linalg.norm(gaps, axis=2).min() > 0.2 or (a, b) in near
