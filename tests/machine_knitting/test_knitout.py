# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs for knitting machines: a simulated machine makes the loops of the mesh through the correct other loops."""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise

import numpy as np
import pytest
from knitout_interpreter.run_knitout import run_knitout

from stitchmesh.cli import main as cli
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.hand_knitting.pieces import find_pieces
from stitchmesh.io import read_mesh, read_stitches, write_stitches
from stitchmesh.labeling import label
from stitchmesh.machine_knitting import machine_program
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.shaping_stitches import with_increases
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.tessellate import tessellate
from tests.gallery import ROOT
from tests.hand_knitting.stitch_charts import chart_fabric
from tests.machine_knitting.knitout_machine import Machine, Made
from tests.nightly import at_night


class Checked:
    """The comparison of an executed program with its stitch mesh."""

    def __init__(self, fabric: StitchMesh) -> None:
        self.fabric = fabric
        self.machine = Machine().run(machine_program(fabric))
        self.by_loop: dict[tuple[int, int], Made] = {}
        for made in self.machine.made:
            name = re.fullmatch(r"face (\d+) loop (\d+)", made.note)
            if name:
                key = int(name[1]), int(name[2]) - 1
                assert key not in self.by_loop
                self.by_loop[key] = made
        self.is_tube = find_pieces(fabric)[0].in_rounds

    def top(self, face: int, loop: int) -> int:
        """Return the top side of a loop of a face; loops are counted from the left."""
        return int(self.fabric.left_wale[face]) - 1 - loop

    def outside(self, made: Made) -> str:
        """Return the bed that is on the outside of the fabric at a stitch."""
        return "b" if self.is_tube and made.needle % 2 else "f"

    def loop_at(self, side: int) -> int:
        """Return the loop at a top side when the next row works it, after cable crossings and slipped stitches."""
        groups = self.moved_to().get(side, side)
        face = int(self.fabric.side_face[groups])
        place = int(self.fabric.left_wale[face]) - 1 - groups
        if self.letter(face, place) == "s":
            return self.loop_at(int(self.fabric.twin[self.fabric.face_start[face]]))
        return self.by_loop[face, place].loop

    def moved_to(self) -> dict[int, int]:
        """Return, for each top side, the side from which a cable moves its loop; cables here cross adjacent faces."""
        moved = {}
        for side in np.flatnonzero(self.fabric.cable_shift):
            face = int(self.fabric.side_face[side]) + int(self.fabric.cable_shift[side])
            moved[self.top(face, 0)] = int(side)
        return moved

    def letter(self, face: int, place: int) -> str:
        stitch = Stitch(int(self.fabric.stitch[face]))
        return "y" if stitch == Stitch.CAST_ON else VOCABULARY[stitch].made[place]

    def check(self) -> None:
        """Check that every loop is made as its letter states, through the loops below it in the correct order."""
        fabric = self.fabric
        for face in range(fabric.face_count):
            for place in range(int(fabric.n_top[face])):
                self.check_loop(face, place, self.by_loop[face, place])
        assert len(self.by_loop) == int(fabric.n_top.sum())
        ends = [self.loop_at(int(side)) for side in self.last_sides()]
        chain = {loop for made in self.machine.made if made.note == "bind off" for loop in made.through}
        assert set(ends) <= chain

    def last_sides(self) -> np.ndarray:
        fabric = self.fabric
        drawn = (fabric.twin != BORDER) & (fabric.stitch[fabric.side_face[fabric.twin]] == Stitch.DRAW_THROUGH)
        return np.flatnonzero((fabric.side_role == 2) & ((fabric.twin == BORDER) | drawn))

    def check_loop(self, face: int, place: int, made: Made) -> None:
        letter, outside = self.letter(face, place), self.outside(made)
        assert made.carrier == str(self.fabric.yarn[face] + 1)
        assert made.operation == {"k": "knit", "p": "knit", "y": "tuck", "s": "miss"}[letter]
        inside = "b" if outside == "f" else "f"
        front = self.fabric.stitch[face] == Stitch.SLIP_FRONT
        if self.fabric.stitch[face] != Stitch.CAST_ON:  # A cast-on loop is alike on both beds.
            assert made.bed == (inside if letter == "p" or front else outside)
        if letter == "y":
            return
        below = self.fabric.twin[self.fabric.face_start[face] : self.fabric.right_wale[face]].tolist()
        order = VOCABULARY[Stitch(int(self.fabric.stitch[face]))].order
        expected = [self.loop_at(below[loop - 1]) for loop in order]
        assert list(made.through) == (expected if outside == "f" else expected[::-1]), f"face {face}"


FLAT = {
    "plain": ["co co co co co"] + ["k k k k k"] * 4,
    "rib": ["co co co co"] + ["k p k p", "p p k k"] * 2,
    "lace": ["co co co co co co", "k d12k y y d21k k", "k k p k k k", "d21k y k k y d12k", "k k k k k k"],
    "slips": ["co co co co", "k b f k", "k k k k", "p f b p"],
    "tuck": ["co co co", "k sy k", "k d12k k", "ys k k", "d21k k k"],
    "increases": ["co co co", "ky k yk", "k k k k k", "py k yky k yp", "k k k k k k k k k", "k ypy k k k k k k k"],
    "cast on more": ["co co", "new k k new", "k k k k", "k new k k k"],
    "all decreases in two": ["co co co co co co co co", "d12k d21k d12p d21p", "d21p d12p"],
    "three plain": [" ".join(["co"] * 18), "d123k d132k d213k d231k d312k d321k"],
    "three purl": [" ".join(["co"] * 18), "d321p d312p d231p d213p d132p d123p"],
    "in turn": ["co co co co co", "d213k k k", "yk k ky", "d12k d21p k", "ky k k", "k p d12p"],
    "one wale": ["co", "k", "p", "k"],
}


@pytest.mark.parametrize("rows", FLAT.values(), ids=FLAT)
def test_flat_pieces(rows):
    Checked(chart_fabric(rows)).check()


TUBES = {
    "plain": ["co co co co co co"] + ["k k k k k k"] * 3,
    "odd number": ["co co co co co"] + ["k k p k p"] * 3,
    "rib and slips": ["co co co co co co", "k p b f p k", "p k k k f b", "k k k k k k"],
    "narrowing": [" ".join(["co"] * 16), "k d12k d21k k d213k k d12p k k k k", "k d321k k p d21k k k k"],
    "widening": ["co co co co", "ky k yk k", "k ky k k yk k", "ky k k k k k k yky"],
    "on one side": [" ".join(["co"] * 14), 4 * "d21k " + 6 * "k ", "d21k d21k k k k k k k", "k p k k p k k k"],
    "halved": [" ".join(["co"] * 24), " ".join(["d12k"] * 12), " ".join(["d21k"] * 6), "k k k k k k"],
    "lace": [" ".join(["co"] * 9), "d12k y k d12k y k y d21k k", "k k k k k k k k k", "k y d21k k y d21k d12k y k"],
    "drawn together": ["co co co co co co", "k k k k k k", "dt dt dt dt dt dt"],
}


@pytest.mark.parametrize("rows", TUBES.values(), ids=TUBES)
def test_tubes(rows):
    Checked(chart_fabric(rows, ring=True)).check()


def test_several_yarns():
    """Each yarn is knitted in its stitches, in rows of one yarn and of two yarns, flat and in the round."""
    rows, yarns = ["co co co co"] + ["k k p k"] * 5, ["0000", "0000", "1111", "0101", "2200", "0000"]
    Checked(chart_fabric(rows, yarns=yarns)).check()
    Checked(chart_fabric(rows, yarns=yarns, ring=True)).check()


@pytest.mark.parametrize("ring", [False, True])
def test_a_loop_changes_its_bed_only_between_a_knit_and_a_purl_stitch(ring):
    """Loops of a rib are cast on on their beds and stay there; each change in a wale costs one transfer."""
    rows = ["k k p p k k p p"] * 3 + ["p k p k p k p k"] * 2 + ["k k k k k k k k"]
    changes = sum(a != b for low, high in pairwise(rows) for a, b in zip(low.split(), high.split(), strict=True))
    program = machine_program(chart_fabric(["co co co co co co co co", *rows], ring=ring))
    Machine().run(program)
    assert program.partition(";bind off")[0].count("xfer") == changes == 4 + 4


def test_a_rib_is_bound_off_with_one_transfer_for_each_loop_on_the_other_bed():
    """The chain takes 15 further loops by one transfer each, and one more where the first two loops share a bed."""
    fabric = chart_fabric([" ".join(["co"] * 16), *["k k p p " * 4] * 3])
    Checked(fabric).check()
    assert machine_program(fabric).count("xfer") == 15 + 1


@pytest.mark.parametrize("ring", [False, True])
def test_a_made_one_is_a_tuck_against_the_direction_of_its_row(ring):
    """The carrier passes the needle, comes back over it and goes on, so that the legs of the loop cross."""
    plain = chart_fabric(TUBES["widening"] if ring else FLAT["increases"][:3], ring=ring)
    checked = Checked(with_increases(plain))
    checked.check()
    for face in np.flatnonzero(plain.n_top > plain.n_bottom).tolist():
        loops = [checked.by_loop[face, place] for place in range(int(plain.n_top[face]))]
        (along,) = {made.direction for made in loops if made.operation == "knit"}
        tucks = {made.direction for made in loops if made.operation == "tuck"}
        assert len(tucks) == 1 and along not in tucks


def crossed(fabric: StitchMesh, first: int, destination: list[int], layers: list[int]) -> StitchMesh:
    """Return the fabric with a cable on the loops of the face ``first`` and of the following faces."""
    shift, layer = np.zeros((2, fabric.side_count), dtype=np.int64)
    for place, (to, front) in enumerate(zip(destination, layers, strict=True)):
        side = fabric.left_wale[first + place] - 1
        shift[side], layer[side] = to - place, front
    return dataclasses.replace(fabric, cable_shift=shift, cable_layer=layer)


@pytest.mark.parametrize(("ring", "layers"), [(False, [0, 0, 1, 1]), (True, [1, 1, 0, 0])])
def test_the_marked_loops_of_cables_are_in_front(ring, layers):
    plain = chart_fabric([" ".join(["co"] * 12), *[" ".join(["k"] * 12)] * 3], ring=ring)
    fabric = crossed(plain, 13, [2, 3, 0, 1], layers)  # In a tube the first six wales are on the front bed.
    checked = Checked(fabric)
    checked.check()
    loops = [checked.by_loop[13 + place, 0].loop for place in range(4)]
    for left in loops[:2]:
        for right in loops[2:]:
            expected = left if layers[0] else right
            assert checked.machine.in_front[min(left, right), max(left, right)] == expected


def test_a_cable_on_the_back_bed_is_seen_from_outside():
    """On the back half of a tube, a loop in front, as seen from outside, is nearer to the back bed."""
    plain = chart_fabric([" ".join(["co"] * 12), *[" ".join(["k"] * 12)] * 3], ring=True)
    checked = Checked(crossed(plain, 19, [1, 0], [1, 0]))
    checked.check()
    left, right = (checked.by_loop[face, 0].loop for face in (19, 20))
    assert checked.machine.in_front[min(left, right), max(left, right)] == right  # The front bed is inside.


@pytest.mark.parametrize(("name", "width"), [("hat", 2.0), ("poncho", 6.0), *at_night(("sock", 2.0), ("swatch", 2.0))])
def test_garments(name, width):
    Checked(tessellate(label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")), stitch_width=width)).check()


def test_a_spiral_is_knitted_in_rounds():
    rows = ["co co co co co co", "k k p k k k", "k d12k k ky k", "k k k k k k"]
    Checked(make_spiral(chart_fabric(rows, ring=True))).check()


def test_one_error_lists_all_stitches_that_cannot_be_made():
    fabric = chart_fabric(["co co co co", "kp k x kyk", "k k k k k k k", "kp k k k k k k"])
    twist = np.zeros(fabric.side_count, dtype=np.int64)
    twist[fabric.left_wale[9] - 1] = -1
    fabric = dataclasses.replace(fabric, twist=twist, yarn=np.full(fabric.face_count, 10))
    expected = (
        r"^knitting machine: cannot make 2 \(p1, k1\) in 1 st \(face 4, 15\); 1 w1 \(face 6\); "
        r"1 \(k1, yo, k1\) in 1 st \(face 7\); "
        r"1 twisted loops \(face 9\); 11 yarns, at most 10; change these, or knit them by hand$"
    )
    with pytest.raises(ParameterError, match=expected):
        machine_program(fabric)


def test_branches_are_errors():
    fabric = tessellate(label(read_mesh(ROOT / "assets" / "meshes" / "glove.obj")), stitch_width=2.0)
    with pytest.raises(ParameterError, match="pieces that start from loops of other pieces"):
        machine_program(fabric)


def test_wide_cables_are_errors():
    plain = chart_fabric([" ".join(["co"] * 8), *[" ".join(["k"] * 8)] * 2])
    with pytest.raises(ParameterError, match=r"1 cables \(face 8\)"):
        machine_program(crossed(plain, 8, [3, 4, 5, 0, 1, 2], [0, 0, 0, 1, 1, 1]))


def test_convert_writes_programs_of_stitch_meshes_only(tmp_path, capsys):
    good, bad = str(tmp_path / "good.h5"), str(tmp_path / "bad.h5")
    write_stitches(good, chart_fabric(FLAT["rib"]))
    write_stitches(bad, chart_fabric(["co co", "kp x"]))
    assert cli.main(["convert", good, str(tmp_path / "good.k")]) == 0
    program = (tmp_path / "good.k").read_text()
    assert program.startswith(";!knitout-2\n;;Carriers: 1 2 3 4 5 6 7 8 9 10\n")
    Machine().run(program)
    with pytest.raises(FileError, match=r"unknown format '.k'; expected one of .h5 .smobj"):
        read_stitches(tmp_path / "good.k")
    assert cli.main(["convert", bad, str(tmp_path / "bad.k")]) == 2
    printed = capsys.readouterr().err
    assert "cannot make 1 (p1, k1) in 1 st (face 2); 1 w1 (face 3)" in printed and printed.count("\n") == 1
    assert not (tmp_path / "bad.k").exists()


INTERPRETED = [(FLAT["lace"], False), (FLAT["slips"], False), (FLAT["in turn"], False), (TUBES["narrowing"], True),
         (TUBES["rib and slips"], True), (TUBES["drawn together"], True)]  # fmt: skip


@pytest.mark.parametrize(("rows", "ring"), INTERPRETED)
def test_the_interpreter_of_other_authors_draws_loops_through_the_same_loops(tmp_path, rows, ring):
    """It refuses what a machine cannot do: crossed carriers, wrong racking, transfers to full needles."""
    program = machine_program(chart_fabric(rows, ring=ring))
    (tmp_path / "p.k").write_text(program)
    _, _, graph = run_knitout(str(tmp_path / "p.k"))
    made = [entry for entry in Machine().run(program).made if entry.loop >= 0]
    number = {entry.loop: k for k, entry in enumerate(made)}
    loops = graph.sorted_loops
    assert len(loops) == len(made)
    order = {loop.loop_id: k for k, loop in enumerate(loops)}
    for loop, entry in zip(loops, made, strict=True):
        assert {order[low] for low in loop.parent_loop_ids} == {number[low] for low in entry.through}
