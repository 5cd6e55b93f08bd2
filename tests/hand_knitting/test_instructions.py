# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Written instructions: a simulated knitter who follows the text makes the stitches of the mesh from the same loops."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting import knitting_instructions, parse_instructions, written_pieces
from stitchmesh.hand_knitting.pieces import find_pieces
from stitchmesh.hand_knitting.rhythm import fold_words
from stitchmesh.io import read_mesh, write_stitches
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.courses import bottom_sides, top_sides
from stitchmesh.mesh.shaping_stitches import with_increases
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch
from stitchmesh.tessellate import tessellate
from tests.gallery import ROOT
from tests.hand_knitting.hand_knitter import HandKnitter, Worked, words_of
from tests.hand_knitting.stitch_charts import chart_fabric
from tests.io.test_stitches import one_stitch_torus
from tests.machine_knitting.test_knitout import FLAT, TUBES, crossed
from tests.nightly import at_night

SPECIAL = {"co": Stitch.CAST_ON, "dt": Stitch.DRAW_THROUGH}


class Comparison:
    """Comparison of a knitted text with its mesh.

    If a piece begins without loops below, any stitch of a ring may come first; the comparison then takes the first
    stitch of the mesh. For all other stitches, their loops determine the face.
    """

    def __init__(self, fabric: StitchMesh) -> None:
        self.fabric = fabric
        text = knitting_instructions(fabric)
        assert parse_instructions(text) == written_pieces(fabric)
        self.knitter = HandKnitter().knit(text)
        self.side_of: dict[int, int] = {}
        self.faces: list[int] = []

    def check(self) -> HandKnitter:
        """Check that every face is one stitch of the text, and return the knitter for further checks."""
        pieces = find_pieces(self.fabric)
        assert len(pieces) == len(self.knitter.needles)
        for piece, needle in zip(pieces, self.knitter.needles, strict=True):
            rows = needle.rows
            if not needle.sources:
                tops = top_sides(self.fabric, piece.rows[0].faces)[::-1]
                made = [stitch.made[0] for stitch in rows[0]]
                self.side_of.update(zip(made, tops, strict=True))
                self.faces += piece.rows[0].faces
                rows = rows[1:]
            else:
                new = [loop for loop in needle.sources if loop not in self.side_of]
                free = [side for side in bottom_sides(self.fabric, piece.rows[0].faces)[::-1] if self.is_new(side)]
                self.side_of.update((loop, -1 - side) for loop, side in zip(new, free, strict=True))
            for row in rows:
                self.check_row(row)
            for loop in needle.loops:
                self.check_end(loop, needle.ends[loop])
        assert sorted(self.faces) == list(range(self.fabric.face_count))
        return self.knitter

    def is_new(self, side: int) -> bool:
        across = int(self.fabric.twin[side])
        return across == BORDER or self.fabric.side_role[across] != 2

    def face_above(self, loop: int) -> int:
        side = self.side_of[self.placed(loop)]
        return int(self.fabric.side_face[-1 - side if side < 0 else self.fabric.twin[side]])

    def placed(self, loop: int) -> int:
        """The loop to whose place a cable moves this loop."""
        for one, other in self.knitter.crossed:
            if loop in one + other:
                first, second = (one, other) if self.places(one[0]) > self.places(other[0]) else (other, one)
                right = [*first, *second]  # Working order on the right side: the rightmost loops come first.
                moved = [*second, *first]
                return right[moved.index(loop)]
        return loop

    def places(self, loop: int) -> int:
        return int(self.fabric.side_face[self.side_of[loop]])

    def check_row(self, row: list[Worked]) -> None:
        """Check the stitches of a row, from right to left.

        The face of a stitch follows from its loops. If the stitch has no loops below, its face follows from the
        neighbouring stitch.
        """
        row = self.joined(row)
        faces: list[int | None] = [self.face_above(stitch.through[0]) if stitch.through else None for stitch in row]
        for place in [*range(len(row)), *range(len(row) - 1, -1, -1)]:
            if faces[place] is None and place and faces[place - 1] is not None:
                faces[place] = self.beside(faces[place - 1], self.fabric.left_wale)
            elif faces[place] is None and place + 1 < len(row) and faces[place + 1] is not None:
                faces[place] = self.beside(faces[place + 1], self.fabric.right_wale)
        for before, after in pairwise(faces):
            assert after == before or after == self.beside(before, self.fabric.left_wale)
        for face, stitch in zip(faces, row, strict=True):
            self.check_stitch(face, stitch)

    def joined(self, row: list[Worked]) -> list[Worked]:
        """Join the yarn-overs at the sides of increases, from right to left, to the stitches of their faces."""
        found: list[Worked] = []
        left = 0
        for stitch in row:
            if left:
                assert stitch.code == "y"
                found[-1] = _beside_each_other(stitch, found[-1])
                left -= 1
                continue
            found.append(stitch)
            if stitch.through and stitch.code not in SPECIAL:
                left, right = self.yarn_overs(self.face_above(stitch.through[0]))
                for _ in range(right):
                    found[-2:] = [_beside_each_other(found[-1], found[-2])]
        assert not left
        return found

    def yarn_overs(self, face: int) -> tuple[int, int]:
        """The numbers of yarn-overs on the left and on the right of the stitch of a face."""
        making = VOCABULARY.get(Stitch(int(self.fabric.stitch[face])))
        made = making.made if making and "s" not in making.made else ""
        return len(made) - len(made.lstrip("y")), len(made) - len(made.rstrip("y"))

    def is_made_one(self, side: int) -> bool:
        """Whether the loop at a top side is a yarn-over at a side of its stitch, whose word says its half turn."""
        face = int(self.fabric.side_face[side])
        (left, right), place = self.yarn_overs(face), int(self.fabric.left_wale[face]) - 1 - side
        return place < left or place >= self.fabric.n_top[face] - right

    def beside(self, face: int, wale: np.ndarray) -> int:
        return int(self.fabric.side_face[self.fabric.twin[wale[face]]])

    def check_stitch(self, face: int, stitch: Worked) -> None:
        fabric = self.fabric
        assert fabric.stitch[face] == SPECIAL.get(stitch.code, CODES.get(stitch.code))
        if not self.faces or self.faces[-1] != face:
            self.faces.append(face)
        if stitch.code not in SPECIAL:
            sides = bottom_sides(fabric, (face,))
            found = [self.side_of[self.placed(loop)] for loop in stitch.through]
            assert [-1 - side if side < 0 else int(fabric.twin[side]) for side in found] == sides
            own = [self.side_of[loop] for loop in stitch.through]
            turned = [
                "" if side < 0 or self.is_made_one(side) else {0: "", 1: "L", -1: "R"}[int(fabric.twist[side])]
                for side in own
            ]
            assert list(stitch.turned) == turned
            tops = top_sides(fabric, (face,))
            assert list(stitch.half_turns) == [int(fabric.twist[side]) * self.is_made_one(side) for side in tops]
        if fabric.yarn.any():
            assert stitch.yarn == "ABC"[fabric.yarn[face]]
        self.side_of.update(zip(stitch.made, top_sides(fabric, (face,)), strict=True))

    def check_end(self, loop: int, end: str) -> None:
        across = int(self.fabric.twin[self.side_of[loop]])
        assert (end == "bound") == (across == BORDER)
        assert (end == "grafted") == (across != BORDER and self.fabric.side_role[across] == 2)


MORE = {
    "threes": ["co co co", "kpk yky kpy", "k k k k k k k k k", "ykp k k k k k k k ypk", " ".join(["p"] * 13)],
    "purled threes": ["co co co", "pkp pyp ypy", " ".join(["k"] * 9), "pky k k k k k k k kyk"],
    "kept loops": ["co co co co", "sk ks sp ps", "k k k k k k k k"],
    "tucks": ["co co", "sy ys", "d12k d21k", "ys sy", "d21p d12p"],
    "wraps": ["co co co", "k x k", "x k k"],
}


@pytest.mark.parametrize("rows", [*FLAT.values(), *MORE.values()], ids=[*FLAT, *MORE])
def test_a_flat_piece_knitted_from_its_text_is_the_mesh(rows):
    Comparison(chart_fabric(rows)).check()


@pytest.mark.parametrize("rows", [*TUBES.values(), *MORE.values()], ids=[*TUBES, *MORE])
def test_a_tube_knitted_from_its_text_is_the_mesh(rows):
    wide = rows if len(rows[0].split()) > 3 else [f"{row} {row} {row}" for row in rows]
    Comparison(chart_fabric(wide, ring=True)).check()


def test_a_round_starts_after_a_stitch_that_spans_the_start_of_the_round():
    """A decrease takes the first and the last loop of the round, so that the round starts one stitch later."""
    fabric = chart_fabric(["co co co co co co", "d12k k k k k", "k k k k k"], ring=True)
    fabric = _rotate_first_row(fabric, np.roll(np.arange(6), -1))
    lines = knitting_instructions(fabric).split("\n")
    assert "Round 1: pass 1, k4, k2tog. (5 sts)" in lines and "Round 2: k5." in lines
    Comparison(fabric).check()


def _rotate_first_row(fabric: StitchMesh, around: np.ndarray) -> StitchMesh:
    """The same tube with the faces of its first row numbered from another face, so that the ring starts there."""
    order = np.concatenate([around, np.arange(6, fabric.face_count)])
    sides = np.concatenate([np.arange(fabric.face_start[face], fabric.face_start[face + 1]) for face in order])
    new = np.empty_like(sides)
    new[sides] = np.arange(len(sides))
    twin = fabric.twin[sides]
    return dataclasses.replace(
        fabric,
        face_start=np.concatenate([[0], np.cumsum(np.diff(fabric.face_start)[order])]),
        face_vertex=fabric.face_vertex[sides], twin=np.where(twin == BORDER, BORDER, new[twin]),
        **{name: getattr(fabric, name)[order] for name in ("n_bottom", "n_top", "stitch", "row", "yarn")},
        **{name: getattr(fabric, name)[sides] for name in ("twist", "cable_shift", "cable_layer")},
    )  # fmt: skip


def test_a_spiral_is_knitted_in_rounds():
    fabric = make_spiral(chart_fabric(["co co co co co co", "k k p k k k", "k d12k k ky k", "k k k k k k"], ring=True))
    Comparison(fabric).check()
    text = knitting_instructions(fabric)
    assert "Piece 1, worked in rounds" in text and "Seam" not in text


def _beside_each_other(left: Worked, right: Worked) -> Worked:
    return Worked(
        left.code + right.code, left.through + right.through, left.made + right.made, left.yarn,
        left.turned + right.turned, left.half_turns + right.half_turns,
    )  # fmt: skip


@pytest.mark.parametrize("ring", [False, True])
def test_increases_are_written_as_made_ones_and_yarn_overs_only_where_they_are_open(ring):
    """Made ones lean left and right in pairs; the stitches above them are plain."""
    rows = ["co co co co co", "k yk k ky k", "k k k k k k k", "yky k k k k k kyk", "k k k k k k k k k k k"]
    plain = chart_fabric(rows, ring=ring)
    Comparison(plain).check()
    row = "Round" if ring else "Row"
    side = "" if ring else " (RS)"
    assert f"{row} 1{side}: k1, yo, k3, yo, k1. (7 sts)" in knitting_instructions(plain).split("\n")
    fabric = with_increases(plain)
    Comparison(fabric).check()
    lines = knitting_instructions(fabric).split("\n")
    assert f"{row} 1{side}: k1, m1r, k3, m1l, k1. (7 sts)" in lines
    assert f"{row} 3{side}: m1r, k1, m1l, k5, m1r, k1, m1l. (11 sts)" in lines
    assert any(line.startswith("  m1l: make 1 leaning left") for line in lines)
    assert not any(" tbl" in line or "yo" in line for line in lines)


@pytest.mark.parametrize("ring", [False, True])
def test_colours_and_twists(ring):
    rows = ["co co co co co"] + ["k k p k k"] * 4 + ["d12k k p k"]
    plain = chart_fabric(rows, ring=ring, yarns=["00000", "00000", "11111", "01012", "22002", "0000"])
    twist = np.zeros(plain.side_count, dtype=np.int64)
    for face, turn in [(5, -1), (6, 1), (8, -1), (12, -1), (20, -1), (21, 1)]:
        twist[plain.left_wale[face] - 1] = turn
    fabric = dataclasses.replace(plain, twist=twist)
    Comparison(fabric).check()
    text = knitting_instructions(fabric)
    assert f"{'k' if ring else 'p'}1 tbl" in text and "k2tog turning L1 R2" in text


@pytest.mark.parametrize(("row", "layers"), [(1, [0, 0, 1, 1]), (2, [1, 1, 0, 0])])
def test_the_bundle_of_the_higher_cable_layer_is_in_front(row, layers):
    """The cable is worked by a row on the right side and by a row on the wrong side."""
    plain = chart_fabric([" ".join(["co"] * 6), *[" ".join(["k"] * 6)] * 3])
    first = 6 * row + 1
    fabric = crossed(plain, first, [2, 3, 0, 1], layers)
    knitter = Comparison(fabric).check()
    ((front, _),) = knitter.crossed
    compared = Comparison(fabric)
    compared.check()
    faces = sorted(compared.places(loop) for loop in front)
    assert faces == ([first + 2, first + 3] if layers[0] == 0 else [first, first + 1])
    text = knitting_instructions(fabric)
    if row == 1:  # The second row is on the wrong side and in purl; its first two loops are the left two.
        assert f"cross 2/2 {'back' if layers[0] else 'front'}, p5" in text
    else:
        assert f"k1, c4{'f' if layers[0] == 0 else 'b'}, k1" in text


@pytest.mark.parametrize(("name", "width"), [
    ("swatch", 2.0), ("glove", 2.0), *at_night(("hat", 2.0), ("sock", 2.0), ("tea_cozy", 2.0), ("dress", 4.0)),
])  # fmt: skip
def test_garments_knitted_from_their_texts_are_the_meshes(name, width):
    Comparison(tessellate(label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")), stitch_width=width)).check()


def test_mismatched_wales_are_grafted():
    """At the underarms of the sweater, the text grafts the same pairs of loops that the mesh joins."""
    fabric = tessellate(label(read_mesh(ROOT / "assets" / "meshes" / "sweater.obj")), stitch_width=4.0)
    compared = Comparison(fabric)
    knitter = compared.check()
    grafted = {frozenset((compared.side_of[one], compared.side_of[other])) for one, other in knitter.grafted}
    tops = np.flatnonzero(fabric.mismatched & (fabric.side_role == 2))
    assert grafted == {frozenset((int(side), int(fabric.twin[side]))) for side in tops}
    assert "(Kitchener stitch)" in knitting_instructions(fabric)


def patchwork(places: list[tuple[int, int, int, bool]]) -> StitchMesh:
    """Plain faces at places (column, level, row, upside down); row 0 is cast on."""
    vertex = {}
    for column, level, _, _ in places:
        for corner in ((0, 0), (1, 0), (1, 1), (0, 1)):
            vertex.setdefault((column + corner[0], level + corner[1]), len(vertex))
    faces = []
    for column, level, _, turned in places:
        face = [vertex[column + x, level + y] for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        faces.append(face[2:] + face[:2] if turned else face)
    row = np.array([place[2] for place in places])
    corners, start = np.array(faces).ravel(), 4 * np.arange(len(faces) + 1)
    return StitchMesh(
        np.array([[*place, 0.0] for place in vertex]), start, corners, find_twins(start, corners, len(vertex)),
        n_bottom=row ** 0, n_top=row ** 0, row=row,
        stitch=np.where(row == 0, int(Stitch.CAST_ON), int(Stitch.KNIT)),
    )  # fmt: skip


def test_stitches_are_bound_off_before_a_row():
    full = [(column, level, level, False) for level in range(2) for column in range(6)]
    fabric = patchwork(full + [(column, level, level, False) for level in (2, 3) for column in range(1, 5)])
    Comparison(fabric).check()
    lines = knitting_instructions(fabric).split("\n")
    assert "Row 2 (WS): first bind off sts 1, 6; p4. (4 sts)" in lines and "Bind off all 4 sts." in lines


def test_wale_edges_that_meet_are_seamed():
    """Two pieces are side by side, and the right one is upside down, so that two right edges meet."""
    upright = [(column, level, level, False) for level in range(3) for column in range(2)]
    fabric = patchwork(upright + [(column, level, 2 - level, True) for level in range(3) for column in (2, 3)])
    Comparison(fabric).check()
    lines = knitting_instructions(fabric).split("\n")
    assert "Seam the right edge of piece 1 to the right edge of piece 2, 3 rows (mattress stitch)." in lines


def test_cast_on_edges_that_meet_are_grafted():
    """Two pieces meet at their first rows, so that both are cast on provisionally."""
    above = [(column, level, level - 2, False) for level in (2, 3) for column in range(3)]
    fabric = patchwork(above + [(column, level, 1 - level, True) for level in (0, 1) for column in range(3)])
    lines = knitting_instructions(fabric).split("\n")
    assert "Join 3 sts where pieces 1 and 2 begin: cast them on provisionally, then graft them." in lines


def test_repeats_are_folded_and_unfolded():
    words = ["k", "k", "p", "k2tog", "yo", "k2tog", "yo", "k2tog", "yo", "k", "ssk", "ssk"]
    line = "k2, p1, [k2tog, yo] 3 times, k1, [ssk] 2 times"
    assert fold_words(words) == line
    assert list(words_of(line)) == words
    rng = np.random.default_rng(4)
    for _ in range(20):  # random sequences of few words, so that there are repeats of all kinds
        words = rng.choice(["k", "p", "yo", "(k1, yo) in 1 st", "A: k"], size=30).tolist()
        assert list(words_of(fold_words(words))) == words


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: label(read_mesh(ROOT / "assets" / "meshes" / "swatch.obj")), "face 0: is a panel of a coarse mesh"),
        (one_stitch_torus, "face 0: their rows depend on each other in a cycle"),
    ],
)
def test_a_fabric_without_a_first_row_is_refused(make, message):
    with pytest.raises(ParameterError, match=message):
        knitting_instructions(make())


def test_the_command_prints_or_writes_the_instructions(tmp_path, capsys):
    fabric = chart_fabric(FLAT["lace"])
    for name in ("lace.h5", "lace.smobj"):
        write_stitches(tmp_path / name, fabric)
        assert cli.main(["instructions", str(tmp_path / name)]) == 0
        assert capsys.readouterr().out == knitting_instructions(fabric)
    assert cli.main(["instructions", str(tmp_path / "lace.h5"), "-o", str(tmp_path / "lace.txt")]) == 0
    assert (tmp_path / "lace.txt").read_text() == knitting_instructions(fabric)
    write_stitches(tmp_path / "torus.h5", one_stitch_torus())
    assert cli.main(["instructions", str(tmp_path / "torus.h5")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
