# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small files of faces and of face libraries, which together hold every record of their formats."""

from __future__ import annotations

import dataclasses

import numpy as np

from stitchmesh.faces.face_mesh import FaceMesh

EVERY_RECORD = """\
L knit+ -lX +yX +lX -yX
L drop -l1 +y0 +l0 -y0 # two types of one name
L drop -l1 -y0 +l0 +y0
L edge( x -y1 +y1 x x
L tuck-behind-to-right -l0 +y1 +l1 -y1
v 0 0 0
v 2 0.25 0
v 2 1 1e-3
v 0 1.1 0
v 3 0 0
vt 0 0
vt 1 0
tex cloth.png
f 1/1 2/2 3 4
T 1
N 12
f 2 5 3 -3 # the last number counts backwards
T 2
f 1 2 5 3 4
T 4
N 0
f 1 2 3 4
T 5
N 7
e 1/2 2/-4
e 1/3 4/3
e 3/2 4/-2 # yarn
h 1/1 f20 u
h 2/4 f-0.5 i
o 1/1 2/1 u
t 3 front-back h
I 4/2
o 0/1 0/2 u
ci 16/1
xfer f0 b0
U 1 1
U na 0.125
c 1/4/1 1 1 2 2
c 3/3/1
"""
"""A file with every record; its faces form no cloth."""


def flat_file(kinds: list[str], rows: list[str], *, size: tuple[float, float] = (1.0, 1.0)) -> str:
    """Return a file of quads in rows, joined to their neighbours.

    Args:
        kinds: words of the types of faces.
        rows: one line of digits for each row, from the bottom; each digit is the type of a face, counted from 0.
        size: width and height of a face.
    """
    lines = [f"L {kind}" for kind in kinds]
    joins, width, (w, h) = [], len(rows[0]), size
    for y, row in enumerate(rows):
        for x, kind in enumerate(row):
            first = 4 * (y * width + x)
            corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
            lines += [f"v {a * w:g} {b * h:g} 0" for a, b in corners]
            lines += ["f " + " ".join(str(first + k) for k in (1, 2, 3, 4)), f"T {int(kind) + 1}"]
            face = y * width + x + 1
            joins += [f"e {face}/2 {face + 1}/-4"] * (x + 1 < width)
            joins += [f"e {face}/3 {face + width}/-1"] * (y + 1 < len(rows))
    return "\n".join(lines + joins) + "\n"


WEAVE = ["over -a1 +e1 +a1 -e1", "under -a1 +e1 +a1 -e1"]
"""Types of faces of a weave: warps cross the lower and upper sides, wefts the others."""
KNIT = ["tuck-twist+ -lX +yX +lX -yX", "knit+ -lX +yX +lX -yX", "drop -l1 +y0 +l0 -y0"]
"""Types of faces of a knit: a first row, a knit, and a dropped loop."""

LIBRARY = """\
# threads at a quarter of the width, bent upwards
face over
\tedge (0,0) -a1
\tedge (1,0) +e1
\tedge (1, 1) +a1
\tedge ( 0,1) -e1
\tyarn [0:0.25,0.1] [2:0.75,0.1]
\tyarn [1:0.5,0] (0.75,0.5,-0.1) (0.25, 0.5,-.1) [3:0.5,0]
derive mirrored -a1 +e1 +a1 -e1 by mirror-x reverse-yarn from flipped -a1 -e1 +a1 +e1
derive flipped -a1 -e1 +a1 +e1 by mirror-x mirror-z from over -a1 +e1 +a1 -e1
"""


def assert_same_faces(first: FaceMesh, second: FaceMesh) -> None:
    """Check that every field of two face meshes is the same."""
    for field in dataclasses.fields(FaceMesh):
        a, b = getattr(first, field.name), getattr(second, field.name)
        assert np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b, field.name
