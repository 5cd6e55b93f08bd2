# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Random edits, most of which are possible."""

from __future__ import annotations

from dataclasses import fields
from random import Random

import numpy as np

from stitchmesh.editing.edit import Edit
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS

WHOLE_MESH = ("spiral", "unspiral", "graft", "ungraft")
"""Edits that leave less space for further edits; they are chosen less often."""
PATTERNS = ("garter", "eyelet-lace", "rope-cable", "rib1x1")


def arrays_of(fabric: StitchMesh) -> dict[str, np.ndarray]:
    return {part.name: getattr(fabric, part.name) for part in fields(StitchMesh) if part.metadata.get("stored", True)}


def bits(fabric: StitchMesh) -> dict[str, tuple]:
    """Return all arrays of a stitch mesh, to the last bit."""
    return {
        name: (array.dtype, array.shape, array.tobytes())
        for name, array in arrays_of(fabric).items()
        if array is not None
    }


def random_edit(random: Random, fabric: StitchMesh) -> Edit:
    weights = [1 if name in WHOLE_MESH else 10 for name in _ARGUMENTS]
    (name,) = random.choices(list(_ARGUMENTS), weights)
    return Edit(name, _ARGUMENTS[name](random, fabric))


def _side(random: Random, fabric: StitchMesh, roles: tuple[int, ...]) -> int:
    return _one_of(random, np.flatnonzero(np.isin(fabric.side_role, roles)))


def _one_of(random: Random, numbers: np.ndarray) -> int:
    return int(numbers[random.randrange(len(numbers))]) if len(numbers) else 0


def _face(random: Random, fabric: StitchMesh, **more: object) -> dict[str, object]:
    return {"face": random.randrange(fabric.face_count), **more}


def _change_stitch(random: Random, fabric: StitchMesh) -> dict[str, object]:
    face = random.randrange(fabric.face_count)
    counts = int(fabric.n_bottom[face]), int(fabric.n_top[face])
    fitting = [code for code, stitch in CODES.items() if SIDE_COUNTS[stitch] == counts]
    return {"faces": [face], "stitch": random.choice(fitting or ["draw-through"])}


def _twist_loop(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {"side": _side(random, fabric, (2,)), "twist": random.randint(-1, 1)}


def _stripe(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {"yarn": random.randint(0, 3), "rows": [int(fabric.row[random.randrange(fabric.face_count)])]}


def _stripes(random: Random, fabric: StitchMesh) -> dict[str, object]:
    colours = random.choices(["navy", "cream", "0", "2"], k=random.randint(1, 3))
    return {"bands": ", ".join(f"{random.randint(1, 4)} {colour}" for colour in colours)}


def _recolour(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {"yarn": random.randint(0, 5), "colour": random.choice(["navy", "cream", "#a23b4c"])}


def _cross_cable(random: Random, fabric: StitchMesh) -> dict[str, object]:
    side, front = _side(random, fabric, (2,)), random.choice(["left", "right"])
    return {"side": side, "left": random.randint(1, 3), "right": random.randint(1, 3), "front": front}


def _set_cable(random: Random, fabric: StitchMesh) -> dict[str, object]:
    places = random.sample(range(4), 4)
    return {"side": _side(random, fabric, (2,)), "destinations": places, "layers": random.sample(range(4), 4)}


def _clear_cable(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {"side": _one_of(random, np.flatnonzero(fabric.cable_shift))}


def _course_edge(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {"side": _side(random, fabric, (0, 2))}


def _wide_edge(random: Random, fabric: StitchMesh) -> dict[str, object]:
    """Choose a course edge between an increase and a decrease or the border, if there is one."""
    sides = np.flatnonzero((fabric.side_role == 2) & (fabric.n_top[fabric.side_face] > 1))
    across = fabric.twin[sides]
    wide = sides[(across == BORDER) | (fabric.n_bottom[fabric.side_face[across]] > 1)]
    return {"side": _one_of(random, wide if len(wide) and random.random() < 0.8 else sides)}


def _add_wale_edge(random: Random, fabric: StitchMesh) -> dict[str, object]:
    face = _one_of(random, np.flatnonzero(fabric.n_top > 1))
    below, above = random.randint(0, int(fabric.n_bottom[face])), random.randint(0, int(fabric.n_top[face]))
    return {"face": face, "below": below, "above": above}


def _remove_wale_edge(random: Random, fabric: StitchMesh) -> dict[str, object]:
    overs = np.flatnonzero(fabric.n_bottom == 0)
    return {"side": int(fabric.right_wale[_one_of(random, overs)])}


def _shift_wale_edge(random: Random, fabric: StitchMesh) -> dict[str, object]:
    wide = np.flatnonzero(fabric.n_top + fabric.n_bottom > 2)
    side = int(random.choice([fabric.left_wale, fabric.right_wale])[_one_of(random, wide)])
    return {"side": side, "end": random.choice(["top", "bottom"]), "direction": random.choice(["left", "right"])}


def _insert_wale(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {"side": _side(random, fabric, (1, 3)), "courses": random.choice([None, 1, 2, 3])}


def _remove_wale(random: Random, fabric: StitchMesh) -> dict[str, object]:
    """Choose a column below a decrease or above an increase, if there is one."""
    wide = np.flatnonzero(fabric.n_bottom > 1)
    below = fabric.twin[fabric.face_start[_one_of(random, wide)]]
    return {"face": int(fabric.side_face[below]) if below != BORDER else 0, "courses": random.choice([None, None, 1])}


def _short_rows(random: Random, fabric: StitchMesh) -> dict[str, object]:
    face = random.randrange(fabric.face_count)
    return {"faces": list(course_through(fabric, face).faces[: random.randint(2, 6)]), "stitch": random.choice("kp")}


def _pattern(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return _face(random, fabric, pattern=random.choice(PATTERNS))


def _nothing(random: Random, fabric: StitchMesh) -> dict[str, object]:
    return {}


def _border_edges(random: Random, fabric: StitchMesh) -> dict[str, object]:
    sides = np.flatnonzero((fabric.side_role == 2) & (fabric.twin == BORDER))
    return {"first_side": _one_of(random, sides), "second_side": _one_of(random, sides)}


_ARGUMENTS = {
    "change_stitch": _change_stitch,
    "twist_loop": _twist_loop,
    "stripe": _stripe,
    "stripes": _stripes,
    "recolour": _recolour,
    "cross_cable": _cross_cable,
    "set_cable": _set_cable,
    "clear_cable": _clear_cable,
    "split_course_edge": _course_edge,
    "collapse_course_edge": _wide_edge,
    "add_wale_edge": _add_wale_edge,
    "remove_wale_edge": _remove_wale_edge,
    "shift_wale_edge": _shift_wale_edge,
    "insert_wale": _insert_wale,
    "remove_wale": _remove_wale,
    "flip_row": _face,
    "insert_row": _face,
    "remove_row": _face,
    "short_rows": _short_rows,
    "bobble": _face,
    "paste_pattern": _pattern,
    "spiral": _nothing,
    "unspiral": _nothing,
    "graft": _border_edges,
    "ungraft": _course_edge,
}
