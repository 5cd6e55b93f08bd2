# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forms of an edge: a hem that folds to the inside, or stockinette that rolls to the outside.

Rows are added beyond a border along a profile, a line in the plane of the normal n and of the direction u that leads
out of the fabric, across the border. With rows that are h high:

- ``fold``: a purl row turns inwards, over the distance g of two layers, and N rows lie behind the rows of the fabric at
  this distance. Their far end, a cast-on or a bind-off, stays open, to be sewn down.
- ``roll``: N rows of stockinette roll to the outside, as they do by themselves, and show their purl side:

      p_k = p_0 + R sin(k h / R) u + R (1 - cos(k h / R)) n,    R = (N + 2) h / ``ARC``,

  With this radius, the cast-on or bind-off of the edge, which is up to two rows high, does not reach the fabric.

The garment itself stays as it is. The rows are added to a stitch mesh that already lies on its surface, because mesh
relaxation would press them onto it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mesh.change import stretch_at
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.shaping_stitches import closing_half_turns, shaping_stitch
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.selection.borders import Border, borders
from stitchmesh.selection.parse import parse_selection
from stitchmesh.selection.selected_faces import borders_named
from stitchmesh.selection.selection import AtBorder

Form = Literal["fold", "roll"]
"""Forms of an edge."""
GAP_OVER_RADIUS = 7.0
"""Distance of the two layers at a fold, over the yarn radius. With it the row that turns is about as high as other
rows. Plain stitches with their yarn are 5 radii thick; decreases and a chain stand out further."""
MOST_ROWS = 30
"""Largest number of rows of a form."""
ARC = np.radians(300.0)
"""Angle through which an edge rolls, its cast-on or bind-off included."""
_TEXT = re.compile(r"\s*(?P<border>[^=]+?)\s*=\s*(?P<form>[a-z]+)\s*:\s*(?P<rows>\d{1,6})\s*")


@dataclass(frozen=True)
class EdgeForm:
    """The form of the edge at some borders of a garment.

    Raises:
        ParameterError: the border is no border of a selection, or the form or the number of rows is not accepted.
    """

    border: str
    """Borders by their name in selections: ``hem``, ``neck``, ``cuffs``, ``left cuff`` or ``border 2``."""
    form: Form
    """``fold`` or ``roll``."""
    rows: int
    """Rows behind the fold, or rows that roll."""

    def __post_init__(self) -> None:
        if self.form not in get_args(Form):
            known = " or ".join(get_args(Form))
            raise ParameterError(f"edge {self.border}: got the form {self.form!r}; expected {known}")
        if not 1 <= self.rows <= MOST_ROWS:
            raise ParameterError(f"edge {self.border}: got {self.rows} rows; expected 1 to {MOST_ROWS}")
        _named(self.border)


def _named(border: str) -> AtBorder:
    """Return the selection that a name of borders means."""
    selection = parse_selection(border)
    if not isinstance(selection, AtBorder):
        raise ParameterError(f"edge: got {border!r}; expected a border, such as hem, neck, cuffs or 'border 2'")
    return selection


def parse_edge_form(text: str) -> EdgeForm:
    """Read the form of an edge, such as ``hem=fold:5``.

    Raises:
        ParameterError: the text has another form, or ``EdgeForm`` does not accept it.
    """
    match = _TEXT.fullmatch(text)
    if match is None:
        raise ParameterError(f"edge: got {text[:60]!r}; expected BORDER=FORM:ROWS, such as hem=fold:5 or neck=roll:4")
    return EdgeForm(match["border"], match["form"], int(match["rows"]))  # type: ignore[arg-type]


def with_edge_forms(fabric: StitchMesh, forms: Sequence[EdgeForm], yarn_radius: float) -> StitchMesh:
    """Return a fabric whose edges have the rows of their forms.

    The faces of the fabric keep their numbers, and new rows have the numbers after them. If rows are added before the
    first row, all rows are numbered anew. The first row of the fabric is then worked like the row above it, and not
    cast on.

    Args:
        fabric: stitch faces on their surface, with the y axis up.
        forms: forms of borders; each border runs around a tube along one row.
        yarn_radius: radius of the yarn [cm], which gives the distance of the layers at a fold.

    Raises:
        ParameterError: a border does not exist, is named twice or is not along one row, or its first row has stitches
            that are not cast on.
    """
    found, taken = borders(fabric), set()
    for form in forms:
        for border in borders_named(found, _named(form.border)):
            if border.number in taken:
                raise ParameterError(f"edge {form.border}: {border.name} has a form already; name it once")
            taken.add(border.number)
            fabric = _with_form(fabric, border, form, GAP_OVER_RADIUS * yarn_radius)
    return fabric


def _with_form(fabric: StitchMesh, border: Border, form: EdgeForm, gap: float) -> StitchMesh:
    """Add the rows of a form beyond a border.

    Forms that were added before have not changed the numbers of its sides.
    """
    sides = border.sides
    roles = np.unique(fabric.side_role[sides])
    if roles.tolist() not in ([BOTTOM], [TOP]):
        raise ParameterError(
            f"edge {form.border}: {border.name} is not along one row around a tube; leave its form out, or close the "
            "fabric there"
        )
    below = roles[0] == BOTTOM
    along, across = _profile(form, _row_height(fabric, sides), gap)
    vertices, ends, out = _border_frame(fabric, sides)
    base, normal = fabric.vertices[vertices], fabric.vertex_normal[vertices]
    rows = base + along[:, None, None] * out + across[:, None, None] * normal
    if form.form == "fold":
        rows[1:] = _behind(fabric, rows[1:], gap)
    stitch = np.full(len(along), Stitch.KNIT)
    if form.form == "fold":
        stitch[0] = Stitch.PURL
    if below:
        stitch[-1] = Stitch.CAST_ON
        fabric = _without_cast_on(fabric, sides, form)
    return _added(fabric, sides, rows, ends, stitch)


def _profile(form: EdgeForm, height: float, gap: float) -> tuple[FloatArray, FloatArray]:
    """Return the end of each new row: its distance beyond the border and along the normal [cm], shape (rows,)."""
    if form.form == "fold":
        return -height * np.arange(form.rows + 1.0), np.full(form.rows + 1, -gap)
    radius = (form.rows + 2) * height / ARC
    angle = np.arange(1, form.rows + 1) * height / radius
    return np.asarray(radius * np.sin(angle)), np.asarray(radius * (1.0 - np.cos(angle)))


def _row_height(fabric: StitchMesh, sides: IntArray) -> float:
    """Return the mean height of the stitches at some sides [cm]."""
    faces = fabric.side_face[sides]
    return float(fabric.side_length[np.concatenate([fabric.left_wale[faces], fabric.right_wale[faces]])].mean())


def _border_frame(fabric: StitchMesh, sides: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the directions that lead out of the fabric at a border: across the border, in the plane of the fabric.

    Wales run together or apart at increases and decreases, so rows that followed them would cross each other.

    Returns:
        The vertices of the border, ascending, shape (n,); the left and the right end of each side, as indices into
        them, shape (2, s); and the unit vectors at the vertices, shape (n, 3).
    """
    below = fabric.side_role[sides[0]] == BOTTOM
    first, last = fabric.face_vertex[sides], fabric.face_vertex[fabric.side_next[sides]]
    vertices, ends = np.unique(np.stack([first, last] if below else [last, first]), return_inverse=True)
    ends = ends.reshape(2, -1)
    position = fabric.vertices[vertices]
    along = np.zeros((len(vertices), 3))
    for end in ends:
        np.add.at(along, end, position[ends[1]] - position[ends[0]])
    up = np.cross(fabric.vertex_normal[vertices], along)
    out = -up if below else up
    return vertices, ends, unit_vectors(out)


def _behind(fabric: StitchMesh, rows: FloatArray, gap: float) -> FloatArray:
    """Move vertices along the normals of a fabric until they lie behind it at a distance [cm], shape (..., 3)."""
    from scipy.spatial import cKDTree

    nearest = cKDTree(fabric.vertices).query(rows)[1]
    normal = fabric.vertex_normal[nearest]
    depth = np.einsum("...i,...i->...", rows - fabric.vertices[nearest], normal)
    moved: FloatArray = rows - (gap + depth)[..., None] * normal
    return moved


def _without_cast_on(fabric: StitchMesh, sides: IntArray, form: EdgeForm) -> StitchMesh:
    """Work the first row at some sides: purl below purl, knit elsewhere, and close the increases."""
    stitch, twist = fabric.stitch.copy(), fabric.twist.copy()
    for face in np.unique(fabric.side_face[sides]).tolist():
        loops = int(fabric.n_bottom[face]), int(fabric.n_top[face])
        if stitch[face] != Stitch.CAST_ON or min(loops) != 1 or max(loops) > 3:
            raise ParameterError(
                f"edge {form.border}: face {face}: is no cast-on stitch of one to three loops; choose another stitch "
                "width"
            )
        above = int(fabric.twin[fabric.right_wale[face] + 1])
        purled = loops == (1, 1) and above != BORDER and fabric.stitch[fabric.side_face[above]] == Stitch.PURL
        made = Stitch.PURL if purled else shaping_stitch(*loops, keeps="left")
        stitch[face] = made
        for loop, turn in enumerate(closing_half_turns(made)):
            twist[fabric.left_wale[face] - 1 - loop] = turn
    return replace(fabric, stitch=stitch, twist=twist)


def _added(fabric: StitchMesh, sides: IntArray, rows: FloatArray, ends: IntArray, stitch: IntArray) -> StitchMesh:
    """Add rows of plain stitches beyond some sides.

    Args:
        fabric: stitch faces.
        sides: sides of a ring along one row, at the border.
        rows: vertices at the far end of each row [cm], shape (rows, n, 3).
        ends: left and right end of each side, as indices into these vertices, shape (2, s).
        stitch: stitch of each row, from the border on, shape (rows,).
    """
    below = fabric.side_role[sides[0]] == BOTTOM
    count, width = len(stitch), len(sides)
    first, last = fabric.face_vertex[sides], fabric.face_vertex[fabric.side_next[sides]]
    begin = np.stack([first, last] if below else [last, first])
    new = len(fabric.vertices) + np.arange(count)[:, None, None] * rows.shape[1] + ends
    lines = np.concatenate([begin[None], new])  # left and right ends of the lines between the rows
    low, high = (lines[1:], lines[:-1]) if below else (lines[:-1], lines[1:])
    quads = np.stack([low[:, 0], low[:, 1], high[:, 1], high[:, 0]], axis=-1).reshape(-1, 4)
    vertices = np.concatenate([fabric.vertices, rows.reshape(-1, 3)])
    start = 4 * np.arange(len(quads) + 1)
    own = find_twins(start, quads.ravel(), len(vertices))
    twin = np.concatenate([fabric.twin, np.where(own < 0, own, own + fabric.side_count)])
    inner = fabric.side_count + 4 * np.arange(width) + (2 if below else 0)
    twin[sides], twin[inner] = inner, sides
    face, faces = fabric.side_face[sides], len(quads)
    number = np.repeat(np.arange(count), width)
    ones, unmarked = np.ones(faces, dtype=np.int64), np.zeros(4 * faces, dtype=np.int64)
    above = int(fabric.row.max()) + 1
    whole = replace(
        fabric,
        vertices=vertices,
        face_start=np.concatenate([fabric.face_start, fabric.side_count + start[1:]]),
        face_vertex=np.concatenate([fabric.face_vertex, quads.ravel()]),
        twin=twin,
        n_bottom=np.concatenate([fabric.n_bottom, ones]),
        n_top=np.concatenate([fabric.n_top, ones]),
        stitch=np.concatenate([fabric.stitch, np.repeat(stitch, width)]),
        row=np.concatenate([fabric.row + count, count - 1 - number] if below else [fabric.row, above + number]),
        yarn=np.concatenate([fabric.yarn, np.tile(fabric.yarn[face], count)]),
        twist=np.concatenate([fabric.twist, unmarked]),
        cable_shift=np.concatenate([fabric.cable_shift, unmarked]),
        cable_layer=np.concatenate([fabric.cable_layer, unmarked]),
        stretch=None,
    )
    if fabric.stretch is None:
        return whole
    across = whole.twin[whole.edge_side]
    old = np.minimum(whole.edge_side, np.where(across < 0, whole.edge_side, across))
    known = old < fabric.side_count
    stretch = np.full(len(old), float(stretch_at(fabric, sides).mean()))
    stretch[known] = stretch_at(fabric, old[known])
    return replace(whole, stretch=stretch)
