# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Add, remove and shift wale edges (Yuksel et al. 2012, section 5.3 and figure 13).

A wale edge divides the loops of a row between two stitches. What the edge does not touch, the course lines above and
below, stays as it is.
"""

from __future__ import annotations

from stitchmesh.editing.sides import check_face, check_side, faces_beside
from stitchmesh.editing.sketch import Sketch, SketchFace, like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.stitch import CODES, VOCABULARY


def add_wale_edge(
    fabric: StitchMesh, face: int, below: int, above: int,
    stitch_left: str | None = None, stitch_right: str | None = None,
) -> list[Change]:  # fmt: skip
    """Divide a face into two neighbours in its row.

    Args:
        fabric: stitch faces.
        face: the face.
        below: bottom sides that the left one gets; the right one gets the others.
        above: top sides that the left one gets.
        stitch_left: code for the left one; one like the whole where not given.
        stitch_right: code for the right one.

    Raises:
        ParameterError: there is no such face, it has not so many sides, or no stitch fits a part.
    """
    check_face(fabric, face)
    sketch = Sketch(fabric)
    left = sketch.face(face)
    for name, count, sides in (("below", below, left.below), ("above", above, left.above)):
        if not 0 <= count <= len(sides):
            raise ParameterError(f"{name}: got {count}; face {face} has {len(sides)} such sides")
    right = like(
        left, low=left.low[below:], high=left.high[above:], below=left.below[below:], above=left.above[above:],
        left="new wale",
    )  # fmt: skip
    right.loops = left.loops[above:]
    del left.low[below + 1 :], left.high[above + 1 :], left.below[below:], left.above[above:], left.loops[above:]
    left.right = "new wale"
    sketch.add(right)
    sketch.settle(left, stitch_left)
    sketch.settle(right, stitch_right)
    return [sketch.patch()]


def remove_wale_edge(fabric: StitchMesh, side: int, stitch: str | None = None) -> list[Change]:
    """Make one face of the two beside a wale edge; its loops are made as theirs were, where a stitch does so.

    Args:
        fabric: stitch faces.
        side: either side of the edge.
        stitch: code for the face; found from the two where not given.

    Raises:
        ParameterError: the side is no wale side, has no face across that runs the same way, or no stitch fits.
    """
    sketch = Sketch(fabric)
    left, right, gone = _beside(sketch, side)
    sketch.drop(gone)
    code = stitch or _together(left, right)
    left.low += right.low[1:]
    left.high += right.high[1:]
    left.below += right.below
    left.above += right.above
    left.loops += right.loops
    left.right = right.right
    left.stitch = left.stitch if len(left.below) > len(right.below) else right.stitch
    sketch.settle(left, code)
    return [sketch.patch()]


def shift_wale_edge(
    fabric: StitchMesh, side: int, end: str, direction: str,
    stitch_left: str | None = None, stitch_right: str | None = None,
) -> list[Change]:  # fmt: skip
    """Move one end of a wale edge by one vertex along its course line: a loop goes over to the neighbour.

    Args:
        fabric: stitch faces.
        side: either side of the edge.
        end: ``"top"`` or ``"bottom"``.
        direction: ``"left"`` or ``"right"``.
        stitch_left: code for the face on the left; one like its own where not given.
        stitch_right: code for the face on the right.

    Raises:
        ParameterError: the side is no wale side, has no face across that runs the same way, the end or the direction
            is unknown, or no stitch fits a face.
    """
    _check_word("end", end, ("top", "bottom"))
    _check_word("direction", direction, ("left", "right"))
    sketch = Sketch(fabric)
    left, right, _ = _beside(sketch, side)
    on_top, rightwards = end == "top", direction == "right"
    giver = right if rightwards else left
    if not giver.chain(on_top)[1]:
        raise ParameterError(f"{giver.name}: has no {end} side to give; shift the edge the other way")
    line, edges, border = _joined(left, right, on_top)
    border += 1 if rightwards else -1
    for face, first, last in ((left, 0, border), (right, border, len(edges))):
        vertices, names = face.chain(on_top)
        vertices[:], names[:] = line[first : last + 1], edges[first:last]
    if on_top:
        loops = left.loops + right.loops
        left.loops, right.loops = loops[:border], loops[border:]
    sketch.settle(left, stitch_left)
    sketch.settle(right, stitch_right)
    return [sketch.patch()]


def _beside(sketch: Sketch, side: int) -> tuple[SketchFace, SketchFace, int]:
    """The faces left and right of a wale edge, and the number of the right one."""
    check_side(sketch.fabric, side, "wale")
    left, right = faces_beside(sketch.fabric, side)
    if BORDER in (left, right):
        name = sketch.fabric.side_name(side)
        raise ParameterError(f"{name}: lies on the border; expected a wale edge between two faces")
    return sketch.face(left), sketch.face(right), right


def _joined(left: SketchFace, right: SketchFace, on_top: bool) -> tuple[list[int], list, int]:
    """Vertices and edges along both faces, and the place of the vertex between them."""
    (first, first_edges), (second, second_edges) = left.chain(on_top), right.chain(on_top)
    return [*first, *second[1:]], [*first_edges, *second_edges], len(first_edges)


def _together(left: SketchFace, right: SketchFace) -> str | None:
    """Code of the stitch that makes what two stitches make, if it is a known one."""
    if left.stitch not in VOCABULARY or right.stitch not in VOCABULARY:
        return None
    first, second = VOCABULARY[left.stitch], VOCABULARY[right.stitch]
    code = first.made + second.made
    return code if code in CODES and first.n_bottom + second.n_bottom == VOCABULARY[CODES[code]].n_bottom else None


def _check_word(what: str, word: str, known: tuple[str, str]) -> None:
    if word not in known:
        raise ParameterError(f"{what}: got {word!r}; expected {known[0]} or {known[1]}")
