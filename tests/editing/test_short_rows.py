# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Short rows: two more rows over a part of a row, flat and tubular, from the mesh to relaxed yarns."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting import knitting_instructions
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.meshrelax.bobbles import find_bobbles
from stitchmesh.yarngen import check_loops, generate_yarns
from stitchmesh.yarnrelax import relax_yarns
from tests.editing.fabrics import around, face_at, flat, names
from tests.editing.random_edits import bits
from tests.gallery import grid
from tests.hand_knitting.test_instructions import Comparison

pytestmark = pytest.mark.decides

COLUMNS = 12


def wide() -> StitchMesh:
    return flat(COLUMNS, 8)


def run(row: int, *columns: int) -> list[int]:
    return [COLUMNS * row + column for column in columns]


def with_short_rows(fabric: StitchMesh, faces: list[int], **more: object) -> StitchMesh:
    edited = apply_edit(fabric, Edit("short_rows", {"faces": faces, **more}))
    assert bits(apply_changes(edited.fabric, edited.inverse).fabric) == bits(fabric)
    return edited.fabric


def worked_rows(fabric: StitchMesh) -> list[str]:
    """The rows of the instructions after the cast-on row."""
    return [line for line in knitting_instructions(fabric).split("\n") if line.startswith(("Row ", "Rows "))]


RUNS = {
    "inside, right side": (run(3, 3, 4, 5, 6, 7, 8), ["k9, turn", "p6, turn", "k9"]),
    "where the row begins": (run(3, 7, 8, 9, 10, 11), ["k5, turn", "p5", "k12"]),
    "where the row ends": (run(3, 0, 1, 2, 3, 4), ["k12", "p5, turn", "k5"]),
    "two runs of a row": (run(3, 1, 2, 3, 6, 7, 8), ["k6, turn", "p3, turn", "k8, turn", "p3, turn", "k4"]),
}  # fmt: skip
"""Stitches of a piece of 12 wales, and the rows that a knitter works in the place of their row."""


@pytest.mark.parametrize(("faces", "expected"), RUNS.values(), ids=RUNS)
def test_the_knitter_turns_works_back_and_goes_on_with_one_yarn(faces, expected):
    made = with_short_rows(wide(), faces)
    assert made.face_count == wide().face_count + 2 * len(faces)
    assert (made.row[wide().face_count :] == faces[0] // COLUMNS).all()
    rows = worked_rows(made)
    first = faces[0] // COLUMNS
    written = [line.split(": ")[1].rstrip(".") for line in rows]
    start = next(place for place, line in enumerate(rows) if line.startswith(f"Row {first} "))
    assert written[start : start + len(expected)] == expected
    Comparison(made).check()
    yarns = generate_yarns(relax_mesh(made, surface=grid(COLUMNS, 8, height=0.72)).fabric, quality="draft")
    assert yarns.yarn_count == 1 and not yarns.closed[0]


def test_each_end_inside_the_fabric_is_a_slit_of_two_sides():
    for name, slits in (("inside, right side", 2), ("where the row begins", 1), ("two runs of a row", 4)):
        made = with_short_rows(wide(), RUNS[name][0])
        assert sorted(len(loop) for loop in made.boundary_loops)[:-1] == [2] * slits
        assert find_bobbles(made).count == 0


def test_a_round_keeps_its_yarn_and_can_be_worked_in_order():
    fabric = around(12, 6)
    ring = course_through(fabric, face_at(fabric, 3, 0)).faces
    made = with_short_rows(fabric, list(ring[:5]))
    made_yarns, yarns = (generate_yarns(each, yarn_radius=0.06, quality="draft") for each in (made, fabric))
    assert made_yarns.yarn_count == yarns.yarn_count
    assert np.bincount(made.row).tolist() == [12, 12, 12, 12, 10, 12, 12]
    assert [line.split(": ")[1] for line in worked_rows(made)] == ["k12.", "p5, turn.", "k5."]
    Comparison(made).check()
    across = with_short_rows(fabric, [*ring[-2:], *ring[:3]])  # across the first stitch of the round
    assert sorted(len(loop) for loop in across.boundary_loops) == [2, 2, 12, 12]


def test_short_rows_lie_within_short_rows():
    fabric, before = wide(), wide().face_count
    once = with_short_rows(fabric, run(3, 2, 3, 4, 5, 6, 7, 8, 9))
    upper = [before + 2 * place + 1 for place in range(2, 6)]
    twice = with_short_rows(once, upper, stitch="p")
    assert names(twice, *range(once.face_count, twice.face_count)) == [Stitch.PURL] * 8
    rows = [line.split(": ")[1] for line in worked_rows(twice)]
    assert rows[2:7] == ["k10, turn.", "p8, turn.", "k6, turn.", "k4, turn.", "p4, k4."]
    Comparison(twice).check()


def evened_out() -> StitchMesh:
    """A relaxed stitch mesh that is edited and relaxed again."""
    surface = grid(COLUMNS, 8, height=0.72)
    fabric = with_short_rows(relax_mesh(wide(), surface=surface).fabric, run(3, 3, 4, 5, 6, 7, 8))
    return relax_mesh(fabric, surface=surface).fabric


def test_the_loops_hold_each_other():
    even = evened_out()
    check_loops(even, generate_yarns(even, quality="draft"))


@pytest.mark.nightly
def test_the_yarns_come_to_rest_unlinked():
    even = evened_out()
    relaxed = relax_yarns(generate_yarns(even), quality="draft", keep_shape=even)
    assert relaxed.report["converged"] and relaxed.report["pull_throughs"] == 0


def some_neighbours(random: Random, fabric: StitchMesh) -> tuple[int, ...]:
    course = course_through(fabric, random.randrange(fabric.face_count)).faces
    first = random.randrange(len(course))
    return course[first : first + random.randint(2, 6)]


def test_random_runs_are_made_or_refused_in_one_line():
    random = Random(11)
    made = 0
    for _ in range(15):
        fabric = random.choice([wide(), around(12, 6)])
        faces = sorted({face for _ in range(3) for face in some_neighbours(random, fabric)})
        try:
            edited = with_short_rows(fabric, faces)
        except ParameterError as error:
            assert "\n" not in str(error)
            continue
        made += 1
        assert edited.face_count == fabric.face_count + 2 * len(faces)
    assert 3 <= made < 15


def test_whole_rows_are_not_edited_where_the_yarn_turns_back():
    made = with_short_rows(wide(), run(3, 3, 4, 5, 6))
    for name, face in (("insert_row", run(3, 0)[0]), ("remove_row", made.face_count - 1)):
        with pytest.raises(ParameterError, match="the row turns back here, in short rows or a bobble"):
            apply_edit(made, Edit(name, {"face": face}))


REFUSED = {
    "a whole row": (run(3, *range(COLUMNS)), "face 36: its whole row is chosen"),
    "one stitch": (run(3, 4), "face 40: a run of one loop"),
    "the first row": (run(0, 3, 4, 5), "face 3: an end of its short rows meets a border in vertex"),
}


@pytest.mark.parametrize(("faces", "message"), REFUSED.values(), ids=REFUSED)
def test_a_run_that_cannot_be_worked_is_refused(faces, message):
    with pytest.raises(ParameterError, match=message):
        apply_edit(wide(), Edit("short_rows", {"faces": faces}))
